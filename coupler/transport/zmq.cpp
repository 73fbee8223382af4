#include <poll.h>

#include <algorithm>
#include <utility>

#include "coupler/transport/transport.hpp"
#include "coupler/transport/zmq_door.hpp"
#include "coupler/transport/zmq_pool.hpp"
#include "coupler/transport/zmq_socket.hpp"
#include "coupler/transport/zmq_watch.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t copied_below =
    65'536;  // bytes; zmq_bench: below, a copy costs no more than handing over a buffer
constexpr milliseconds first_retry{10}, longest_retry{200}, meeting_slice{20};

class ZmqTransport final : public Transport
{
 public:
    ZmqTransport(Members const& members, Network const& network)
        : network_(network), doorman_(prepared(members, network)), context_(zmq_ctx_new())
    {
        int const count = static_cast<int>(members.names.size());
        for (int peer = 0; peer < count; ++peer) {
            bool const other = peer != members.self;
            endpoints_.push_back(other ? endpoint_between(members, network, peer) : Endpoint{});
            sockets_.push_back(nullptr);
            calls_.emplace_back();
            calls_.back().is_ours = calls_.back().due = other && members.self > peer;
            calls_someone_ = calls_someone_ || calls_.back().is_ours;
            slots_.push_back(nullptr);
            if (other) peers_.push_back(peer);
        }
        signals_.resize(peers_.size());
        watch_ = std::make_unique<ConnectionWatch>(context_.get(), endpoints_, members.self, doorman_, network.silence);
        for (std::size_t i = 0; i < peers_.size(); ++i) open_socket(i);
        listen(members);
        call_those_due();
    }

    ~ZmqTransport() override
    {
        for (int peer : peers_) close_socket(static_cast<std::size_t>(peer));
    }

    std::span<std::byte> reserve(int peer, std::size_t size) override
    {
        auto& slot = slots_[static_cast<std::size_t>(peer)];
        if (!slot) slot = pool_.take();
        return slot->buffer.room(size);
    }

    bool commit(int peer, std::size_t size) override
    {
        require(size <= network_.largest_message, [&] {
            return Error("a message of " + std::to_string(size) + " bytes (at most " +
                             std::to_string(network_.largest_message) + " between these participants).",
                         Exit::io);
        });
        auto const at = static_cast<std::size_t>(peer);
        if (!settled_) call_those_due();
        if (calls_[at].is_ours && !watch_->is_open(peer)) return false;  // it would be kept for nobody
        int const sent = size < copied_below
                             ? zmq_send(sockets_[at].get(), slots_[at]->buffer.data(), size, ZMQ_DONTWAIT)
                             : send_in_place(at, size);
        if (sent >= 0) return true;
        require(errno == EAGAIN || errno == EINTR,
                [] { return Error(std::string("zmq_send: ") + zmq_strerror(errno) + ".", Exit::io); });
        return false;
    }

    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        auto const deadline = Clock::now() + patience;
        for (auto left = Clock::duration(patience);; left = deadline - Clock::now()) {
            if (!settled_ && calls_someone_) {
                call_those_due();
                left = std::min<Clock::duration>(left, meeting_slice);
            }
            if (auto incoming = peers_.size() == 1 ? await_only(left) : await_any(left)) return incoming;
            if (Clock::now() >= deadline) return std::nullopt;
        }
    }

    bool lost(int peer) const override { return watch_->lost(peer); }
    std::string kind() const override { return "zmq"; }

    std::string trouble(int peer) const override
    {
        bool const waits = calls_[static_cast<std::size_t>(peer)].due && door_;
        if (waits && !Door::is_open(network_.directory, peer)) return "it does not listen yet";
        return watch_->trouble(peer);
    }

    void settle() override
    {
        settled_ = true;
        watch_->settle();
    }

 private:
    struct Call  //!< an attempt to connect to a listener
    {
        bool is_ours = false;  //!< this side calls
        bool due = false;
        bool has_ended = false;  //!< the last one
        Clock::time_point not_before{};
        Clock::duration pause = first_retry;
    };

    //! What must be so before there is anything to close.
    static Doorman prepared(Members const& members, Network const& network)
    {
        require_descriptors(members.names.size() - 1);
        if (!network.directory.empty() && network.hosts.empty()) require_private(network.directory);
        return {members, network};
    }

    //! A new one for each call: what is left of an attempt that has ended would end the next one on the same socket.
    void open_socket(std::size_t i)
    {
        int const peer = peers_[i];
        auto const at = static_cast<std::size_t>(peer);
        auto socket = open_pair(context_.get(), network_, endpoints_[at].port != 0);
        doorman_.protect(socket.get(), peer, !calls_[at].is_ours);
        watch_->attach(peer, socket.get());
        sockets_[at] = std::move(socket);
        int descriptor = -1;
        std::size_t size = sizeof descriptor;
        zmq_getsockopt(sockets_[at].get(), ZMQ_FD, &descriptor, &size);
        signals_[i] = {descriptor, POLLIN, 0};
        wait_ = -1;
    }

    void close_socket(std::size_t at)
    {
        if (!sockets_[at]) return;
        if (calls_[at].is_ours && !watch_->is_open(static_cast<int>(at)))
            set_option(sockets_[at].get(), ZMQ_LINGER, 0);  // nobody to wait for
        sockets_[at].reset();
    }

    void listen(Members const& members)
    {
        if (network_.hosts.empty() && !network_.directory.empty())
            door_ = std::make_unique<Door>(network_.directory, members.self,
                                           members.names[static_cast<std::size_t>(members.self)]);
        for (int peer : peers_) {
            auto const at = static_cast<std::size_t>(peer);
            if (peer > members.self) listen_at(sockets_[at].get(), endpoints_[at]);
        }
        if (door_) door_->open();
    }

    void call_those_due()
    {
        auto const now = Clock::now();
        for (std::size_t i = 0; i < peers_.size(); ++i) {
            int const peer = peers_[i];
            auto const at = static_cast<std::size_t>(peer);
            auto& call = calls_[at];
            if (watch_->take_failed_attempt(peer)) {
                call.due = call.has_ended = true;
                call.not_before = std::max(call.not_before, now + first_retry);  // its last words are on their way
            }
            if (!call.due || now < call.not_before) continue;
            if (has_message(sockets_[at].get())) continue;  // of a peer that has ended since
            call.not_before = now + call.pause;
            call.pause = std::min<Clock::duration>(2 * call.pause, longest_retry);
            if (door_ && !Door::is_open(network_.directory, peer)) continue;
            if (std::exchange(call.has_ended, false)) {
                close_socket(at);
                open_socket(i);
            }
            call.due = !call_at(sockets_[at].get(), endpoints_[at]);
        }
    }

    int send_in_place(std::size_t at, std::size_t size)
    {
        auto*& slot = slots_[at];
        zmq_msg_t message;
        require(zmq_msg_init_data(&message, slot->buffer.data(), size, SendPool::give_back, slot) == 0,
                [] { return Error("no memory for a message.", Exit::io); });
        int const sent = zmq_msg_send(&message, sockets_[at].get(), ZMQ_DONTWAIT);
        if (sent >= 0) {
            slot = nullptr;
            return sent;
        }
        int const error = errno;
        zmq_msg_close(&message);  // gives the buffer back: it is taken again, for the next attempt
        slot->busy = true;
        errno = error;
        return sent;
    }

    //! With one peer its socket waits itself: two system calls less than poll and receive.
    std::optional<Incoming> await_only(Clock::duration time)
    {
        int const wait = std::max(0, static_cast<int>(std::chrono::ceil<milliseconds>(time).count()));
        if (wait != wait_) set_option(sockets_[static_cast<std::size_t>(peers_[0])].get(), ZMQ_RCVTIMEO, wait);
        wait_ = wait;
        return take_from(0, 0);
    }

    std::optional<Incoming> await_any(Clock::duration time)
    {
        for (auto& signal : signals_) signal.revents = POLLIN;
        if (auto incoming = take_signalled()) return incoming;
        auto const ns = std::max<std::int64_t>(0, std::chrono::duration_cast<std::chrono::nanoseconds>(time).count());
        timespec const limit{ns / 1'000'000'000, ns % 1'000'000'000};
        // right after nothing was found: only then do the sockets signal whatever comes next
        if (::ppoll(signals_.data(), signals_.size(), &limit, nullptr) <= 0) return std::nullopt;
        return take_signalled();
    }

    std::optional<Incoming> take_signalled()
    {
        for (std::size_t k = 0; k < peers_.size(); ++k) {
            auto const i = (k + turn_) % peers_.size();  // nobody is served first for ever
            if (signals_[i].revents == 0) continue;
            auto incoming = take_from(i, ZMQ_DONTWAIT);
            if (!incoming) continue;
            turn_ = i + 1;
            return incoming;
        }
        return std::nullopt;
    }

    std::optional<Incoming> take_from(std::size_t i, int flags)
    {
        int const peer = peers_[i];
        if (!spare_) spare_ = std::make_shared<Received>();
        auto* const raw = &spare_->message;
        if (zmq_msg_recv(raw, sockets_[static_cast<std::size_t>(peer)].get(), flags) < 0) return std::nullopt;
        if (!settled_) watch_->carried_message(peer, zmq_msg_get(raw, ZMQ_SRCFD));
        auto const* const data = static_cast<std::byte const*>(zmq_msg_data(raw));
        std::span const bytes(data, zmq_msg_size(raw));
        return Incoming{peer, {bytes, std::move(spare_)}};
    }

    Network network_;
    Doorman doorman_;
    SendPool pool_;  // before the context: its thread sends from here
    Context context_;
    std::vector<Endpoint> endpoints_;  //!< per member
    std::unique_ptr<ConnectionWatch> watch_;
    std::vector<Socket> sockets_;         //!< per member
    std::vector<Call> calls_;             //!< per member
    std::vector<SendPool::Slot*> slots_;  //!< per member: reserved, not yet sent
    std::vector<int> peers_;              //!< all members but this one
    std::vector<pollfd> signals_;         //!< per peer
    std::shared_ptr<Received> spare_;     //!< for the next message
    std::unique_ptr<Door> door_;
    std::size_t turn_ = 0;
    int wait_ = -1;               //!< ms, of await_only()
    bool calls_someone_ = false;  //!< who only listens is woken by what comes
    bool settled_ = false;
};

}  // namespace

std::unique_ptr<Transport> make_zmq_transport(Members const& members, Network const& network)
{
    return std::make_unique<ZmqTransport>(members, network);
}

}  // namespace sluice
