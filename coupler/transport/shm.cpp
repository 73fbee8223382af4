#include "coupler/transport/shm.hpp"

#include <algorithm>
#include <deque>

#include "coupler/base/error.hpp"
#include "coupler/transport/shm_bell_file.hpp"
#include "coupler/transport/shm_note.hpp"
#include "coupler/transport/shm_queue.hpp"
#include "coupler/transport/spin.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr milliseconds slice{50};          // of a sleep: between two, the network has its turn
constexpr milliseconds network_pause{20};  // between two looks at a network that nothing is awaited from
constexpr microseconds network_turn{5};    // while messages may come from both sides
constexpr int network_share = 8;           // messages from shared memory for one look at the network
struct Peer
{
    std::unique_ptr<ShmOutbox> out;  //!< ours, offered to the peer
    std::shared_ptr<ShmInbox> in;    //!< the peer's, open here
    std::optional<BellFile> bell;    //!< the peer's
    std::uint64_t life = 0;          //!< of the transport that last made an offer
    bool accepted = false;           //!< the peer has opened `out`
    bool sends_here = false;         //!< our messages go through `out`: the network had the last one
    bool receives_here = false;      //!< the peer's come through `in`: the last one on the network was read
    std::span<std::byte> room = {};  //!< the network's, being filled by the user: no note may take its place
    bool ended = false;              //!< it was lost when the network was looked at last
    bool network_empty = false;      //!< since the peer was lost the network was looked at, and had nothing more
    mutable bool was_lost = false;   //!< lost() has said so, before everybody had met
    std::deque<Note> notes = {};     //!< to be sent over the network
};

class ShmTransport final : public Transport
{
 public:
    ShmTransport(Members const& members, std::unique_ptr<Transport> network)
        : network_(std::move(network)), self_(members.self), peers_(members.names.size()), life_(random_token()[0] | 1)
    {
        for (int peer = 0; peer < count(); ++peer)
            if (peer != self_) offer_queue(peer);
    }

    std::span<std::byte> reserve(int peer, std::size_t size) override
    {
        auto& at = of(peer);
        if (!settled_ && (at.sends_here || at.accepted) && (at.was_lost || network_->lost(peer))) offer_queue(peer);
        at.room = {};
        tell(peer);
        if (at.sends_here) return at.out->reserve(size);
        auto const room = network_->reserve(peer, size + sizeof(Trailer));
        if (room.size() < size + sizeof(Trailer)) return {};
        at.room = room;
        return room.first(size);
    }

    bool commit(int peer, std::size_t size) override;

    std::optional<Incoming> receive(microseconds patience) override;

    bool lost(int peer) const override
    {
        auto const& at = peers_[static_cast<std::size_t>(peer)];
        if (!network_->lost(peer)) return false;
        if (!settled_) at.was_lost = true;
        // what it sent before it ended comes first, also if the word that it moved is still under way
        return !(at.in && at.in->ready() && (at.receives_here || !at.network_empty));
    }

    std::string trouble(int peer) const override { return network_->trouble(peer); }
    void settle() override
    {
        settled_ = true;
        network_->settle();
    }
    void give_up(int exit_code) override { network_->give_up(exit_code); }
    Clock::time_point now() const override { return network_->now(); }

    std::string kind() const override
    {
        auto const here = std::count_if(peers_.begin(), peers_.end(), [](Peer const& p) { return p.sends_here; });
        auto const others = count() - 1 - here;
        if (here == 0) return network_->kind();
        if (others == 0) return "shm";
        return "shm " + std::to_string(here) + ", " + network_->kind() + " " + std::to_string(others);
    }

 private:
    int count() const { return static_cast<int>(peers_.size()); }
    Peer& of(int peer) { return peers_[static_cast<std::size_t>(peer)]; }

    void offer_queue(int peer);
    void tell(int peer);
    bool send_note(int peer, Note const& note);
    void read_note(int peer, Note const& note);
    void read_offer(int peer, Note const& note);
    void update();

    std::optional<Incoming> look_here();
    std::optional<Incoming> look_at_network(microseconds patience);
    std::optional<Incoming> sleep(Clock::duration time);
    bool anything_here() const;

    std::unique_ptr<Transport> network_;
    BellFile bell_;
    int self_;
    std::vector<Peer> peers_;
    std::uint64_t life_;
    Spin spin_;
    Clock::time_point network_seen_{};
    bool all_here_ = false;  //!< all pairs use shared memory both ways: nothing is awaited from the network
    bool settled_ = false;
    int turn_ = 0, since_network_ = 0;
};

// ---- The way from the network to shared memory

//! Makes a queue to `peer`, a new one if there was one; until the peer has opened it messages take the network.
void ShmTransport::offer_queue(int peer)
{
    auto& at = of(peer);
    at.accepted = at.sends_here = at.was_lost = false;
    at.out.reset();
    std::erase_if(at.notes, [](Note const& n) { return n.kind == Note::Kind::offer; });
    try {
        at.out = std::make_unique<ShmOutbox>();
    } catch (Error const&) {
        return;  // this system gives none: kind() says so
    }
    at.notes.push_back({.kind = Note::Kind::offer,
                        .process = at.out->address().process,
                        .queue = at.out->address().descriptor,
                        .bell = bell_.address().descriptor,
                        .life = life_,
                        .token = at.out->token(),
                        .bell_token = bell_.token()});
    update();
}

//! Sends what is to be said to `peer`, and moves to shared memory when both sides are ready for it.
void ShmTransport::tell(int peer)
{
    auto& at = of(peer);
    while (at.room.empty() && !at.notes.empty() && send_note(peer, at.notes.front())) at.notes.pop_front();
    if (!at.room.empty() || at.sends_here || !at.accepted || !at.bell || !at.notes.empty()) return;
    at.sends_here = send_note(peer, {.kind = Note::Kind::moved, .token = at.out->token()});
    update();
}

bool ShmTransport::send_note(int peer, Note const& note)
{
    constexpr std::size_t size = sizeof(Note) + sizeof(Trailer);
    auto const room = network_->reserve(peer, size);
    if (room.size() < size) return false;
    put(room.data(), note);
    put(room.data() + sizeof note, Trailer{.content = Trailer::Content::note});
    return network_->commit(peer, size);
}

void ShmTransport::read_note(int peer, Note const& note)
{
    auto& at = of(peer);
    switch (note.kind) {
        case Note::Kind::offer:
            return read_offer(peer, note);
        case Note::Kind::accept:  // of an earlier queue: from before one of us was started again
            if (at.out && note.token == at.out->token()) at.accepted = true;
            break;
        case Note::Kind::moved:
            if (at.in && note.token == at.in->token()) at.receives_here = true;
            break;
        case Note::Kind::ring:
            break;
    }
    tell(peer);
    update();
}

void ShmTransport::read_offer(int peer, Note const& note)
{
    auto& at = of(peer);
    bool const other_life = at.life != 0 && at.life != note.life;
    at.life = note.life;
    at.in = ShmInbox::open({note.process, note.queue}, note.token);
    at.bell = BellFile::open({note.process, note.bell}, note.bell_token);
    at.receives_here = at.network_empty = false;
    if (other_life) offer_queue(peer);  // it knows nothing of the queue that the earlier one opened
    if (at.in && at.bell) at.notes.push_back({.kind = Note::Kind::accept, .token = note.token});
    tell(peer);
    update();
}

void ShmTransport::update()
{
    int here = 0, both = 0;
    for (Peer const& p : peers_) {
        here += p.sends_here || p.receives_here;
        both += p.sends_here && p.receives_here;
    }
    all_here_ = both == count() - 1;
    spin_.set_crowded(crowded(here + 1));
}

// ---- Messages

bool ShmTransport::commit(int peer, std::size_t size)
{
    auto& at = of(peer);
    if (!at.room.empty()) {
        put(at.room.data() + size, Trailer{});
        if (!network_->commit(peer, size + sizeof(Trailer))) return false;
        at.room = {};
        return true;
    }
    if (!at.sends_here) return true;  // reserved for a process that has ended since, and was started again
    at.out->commit(size);
    if ((*at.bell)->ring_is_for_network()) (void)send_note(peer, {});  // no room there: then it is awake
    return true;
}

std::optional<Transport::Incoming> ShmTransport::receive(microseconds patience)
{
    bool const network_first = !all_here_ && ++since_network_ >= network_share;
    if (!network_first)
        if (auto incoming = look_here()) {
            spin_.found();
            return incoming;
        }
    auto now = Clock::now();
    auto const deadline = now + patience;
    spin_.begin(now);
    for (;;) {
        std::optional<Incoming> incoming;
        if (since_network_ >= network_share ||
            now - network_seen_ >= (all_here_ ? Clock::duration(network_pause) : network_turn))
            incoming = look_at_network(microseconds(0));
        if (!incoming) incoming = look_here();
        now = Clock::now();
        if (!incoming && now < deadline && !spin_.again(now))
            incoming = sleep(std::min<Clock::duration>(deadline - now, slice));
        if (incoming) {
            spin_.found(Clock::now());
            return incoming;
        }
        if (now >= deadline) {
            spin_.gave_up(now);
            return std::nullopt;
        }
    }
}

std::optional<Transport::Incoming> ShmTransport::look_here()
{
    for (int k = 0; k < count(); ++k) {
        int const peer = (turn_ + k) % count();  // nobody is served first for ever
        auto& at = of(peer);
        if (!at.receives_here) continue;
        if (auto message = at.in->take()) {
            turn_ = peer + 1;
            return Incoming{peer, std::move(*message)};
        }
    }
    return std::nullopt;
}

bool ShmTransport::anything_here() const
{
    return std::any_of(peers_.begin(), peers_.end(), [](Peer const& p) { return p.receives_here && p.in->ready(); });
}

//! The next message of a user's; notes are read on the way.
std::optional<Transport::Incoming> ShmTransport::look_at_network(microseconds patience)
{
    since_network_ = 0;
    for (int peer = 0; peer < count(); ++peer) {
        tell(peer);
        auto& at = of(peer);
        at.ended = at.in && !at.receives_here && network_->lost(peer);
    }
    auto incoming = network_->receive(patience);
    network_seen_ = Clock::now();
    if (!incoming) {
        for (auto& at : peers_) at.network_empty |= at.ended;
        return std::nullopt;
    }
    auto& bytes = incoming->message.bytes;
    auto const trailer = trailer_of(bytes);
    auto const content = trailer ? bytes.first(bytes.size() - sizeof(Trailer)) : bytes;
    if (trailer && trailer->content == Trailer::Content::user) {
        bytes = content;
        return incoming;
    }
    auto const note = trailer ? note_in(content) : std::nullopt;
    require(note.has_value(), [&] {
        return Error("a message of " + std::to_string(bytes.size()) + " bytes from member " +
                         std::to_string(incoming->peer) +
                         " is not of this transport. Give all participants the same transport and the same Sluice.",
                     Exit::protocol);
    });
    read_note(incoming->peer, *note);
    return std::nullopt;
}

//! Until there is something to look at, or for `time`.
std::optional<Transport::Incoming> ShmTransport::sleep(Clock::duration time)
{
    bell_->announce(all_here_ ? Bell::on_bell : Bell::on_network);
    std::optional<Incoming> incoming;
    if (!anything_here()) {
        if (all_here_)
            bell_->sleep(time);
        else
            incoming = look_at_network(std::chrono::ceil<microseconds>(time));
    }
    bell_->stay_awake();
    return incoming;
}

}  // namespace

std::unique_ptr<Transport> make_shm_over(Members const& members, std::unique_ptr<Transport> network)
{
    return std::make_unique<ShmTransport>(members, std::move(network));
}

std::unique_ptr<Transport> make_shm_transport(Members const& members, Network const& network)
{
    return make_shm_over(members, make_zmq_transport(members, network));
}

}  // namespace sluice
