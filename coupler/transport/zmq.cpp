#include <poll.h>
#include <sys/resource.h>

#include <algorithm>

#include "coupler/transport/transport.hpp"
#include "coupler/transport/zmq_door.hpp"
#include "coupler/transport/zmq_pool.hpp"
#include "coupler/transport/zmq_watch.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;

constexpr int high_water_mark = 16;           // messages each way: bounds what a fast sender queues
constexpr std::size_t copied_below = 16'384;  // bytes; transport_bench: a copy is cheaper than the way back of a buffer
constexpr milliseconds first_retry{10}, longest_retry{200}, meeting_slice{20};
constexpr rlim_t enough_descriptors = 65'536;

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
            sockets_.push_back(other ? open_socket(peer, members.self < peer) : nullptr);
            calls_.emplace_back();
            calls_.back().due = other && members.self > peer;
            slots_.push_back(nullptr);
            if (!other) continue;
            peers_.push_back(peer);
            int descriptor = -1;
            std::size_t size = sizeof descriptor;
            zmq_getsockopt(sockets_.back().get(), ZMQ_FD, &descriptor, &size);
            signals_.push_back({descriptor, POLLIN, 0});
        }
        watch_ = std::make_unique<ConnectionWatch>(context_.get(), sockets_, endpoints_, members.self, doorman_,
                                                   network.silence);
        listen(members);
        call_those_due();
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
        if (!settled_) call_those_due();
        auto const at = static_cast<std::size_t>(peer);
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
        for (;;) {
            if (!settled_) call_those_due();
            if (auto incoming = take_any()) return incoming;
            auto left = deadline - Clock::now();
            if (left <= Clock::duration::zero()) return std::nullopt;
            if (!settled_) left = std::min<Clock::duration>(left, meeting_slice);
            sleep_until_signal(std::chrono::duration_cast<std::chrono::nanoseconds>(left));
        }
    }

    bool lost(int peer) const override { return watch_->lost(peer); }
    std::string kind() const override { return "zmq"; }

    std::string trouble(int peer) const override
    {
        if (calls_[static_cast<std::size_t>(peer)].due && door_) return "it does not listen yet";
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
        bool due = false;
        Clock::time_point not_before{};
        Clock::duration pause = first_retry;
    };

    //! What must be so before there is anything to close.
    static Doorman prepared(Members const& members, Network const& network)
    {
        if (!network.directory.empty() && network.hosts.empty()) require_private(network.directory);
        return {members, network};
    }

    Socket open_socket(int peer, bool listener)
    {
        auto socket = new_socket(context_.get(), ZMQ_PAIR);
        auto const largest = static_cast<std::int64_t>(network_.largest_message);
        set_option(socket.get(), ZMQ_LINGER, 500);
        set_option(socket.get(), ZMQ_SNDHWM, high_water_mark);
        set_option(socket.get(), ZMQ_RCVHWM, high_water_mark);
        zmq_setsockopt(socket.get(), ZMQ_MAXMSGSIZE, &largest, sizeof largest);
        set_option(socket.get(), ZMQ_HEARTBEAT_IVL, static_cast<int>(network_.silence.count() / 5));
        set_option(socket.get(), ZMQ_HEARTBEAT_TIMEOUT, static_cast<int>(network_.silence.count()));
        set_option(socket.get(), ZMQ_HANDSHAKE_IVL, 5000);
        set_option(socket.get(), ZMQ_IMMEDIATE, 1);       // nothing is queued for a connection that there is not
        set_option(socket.get(), ZMQ_RECONNECT_IVL, -1);  // we call again ourselves, and no more once all have met
        set_option(socket.get(), ZMQ_IPV6, endpoints_.back().ipv6 ? 1 : 0);
        doorman_.protect(socket.get(), peer, listener);
        return socket;
    }

    void listen(Members const& members)
    {
        if (network_.hosts.empty() && !network_.directory.empty())
            door_ = std::make_unique<Door>(network_.directory, members.self,
                                           members.names[static_cast<std::size_t>(members.self)]);
        for (int peer : peers_) {
            auto const at = static_cast<std::size_t>(peer);
            if (peer < members.self) continue;
            if (endpoints_[at].port != 0) allow_many_descriptors();
            require(zmq_bind(sockets_[at].get(), endpoints_[at].uri.c_str()) == 0,
                    [&] { return bind_error(endpoints_[at], errno); });
        }
        if (door_) door_->open();
    }

    //! Strangers may hold a descriptor of ours each until their handshake has timed out.
    static void allow_many_descriptors()
    {
        rlimit limit = {};
        if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
        limit.rlim_cur = std::max(limit.rlim_cur, std::min(limit.rlim_max, enough_descriptors));
        ::setrlimit(RLIMIT_NOFILE, &limit);
    }

    void call_those_due()
    {
        auto const now = Clock::now();
        for (int peer : peers_) {
            auto const at = static_cast<std::size_t>(peer);
            auto& call = calls_[at];
            if (watch_->take_failed_attempt(peer)) {
                zmq_disconnect(sockets_[at].get(), endpoints_[at].uri.c_str());  // what is left of the attempt
                call.due = true;
            }
            if (!call.due || now < call.not_before) continue;
            call.not_before = now + call.pause;
            call.pause = std::min<Clock::duration>(2 * call.pause, longest_retry);
            if (door_ && !Door::is_open(network_.directory, peer)) continue;
            call.due = zmq_connect(sockets_[at].get(), endpoints_[at].uri.c_str()) != 0;
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

    std::optional<Incoming> take_any()
    {
        for (std::size_t k = 0; k < peers_.size(); ++k) {
            auto const i = (k + turn_) % peers_.size();  // nobody is served first for ever
            auto message = std::move(spare_);
            if (!message) message = std::make_shared<Received>();
            int const peer = peers_[i];
            if (zmq_msg_recv(&message->message, sockets_[static_cast<std::size_t>(peer)].get(), ZMQ_DONTWAIT) < 0) {
                spare_ = std::move(message);
                continue;
            }
            turn_ = i + 1;
            if (!settled_) watch_->carried_message(peer, zmq_msg_get(&message->message, ZMQ_SRCFD));
            auto const* const data = static_cast<std::byte const*>(zmq_msg_data(&message->message));
            std::span const bytes(data, zmq_msg_size(&message->message));
            return Incoming{peer, {bytes, std::move(message)}};
        }
        return std::nullopt;
    }

    //! Right after take_any() found nothing: only then do the sockets signal whatever comes next.
    void sleep_until_signal(std::chrono::nanoseconds time)
    {
        timespec const limit{time.count() / 1'000'000'000, time.count() % 1'000'000'000};
        ::ppoll(signals_.data(), signals_.size(), &limit, nullptr);
    }

    Network network_;
    Doorman doorman_;
    SendPool pool_;  // before the context: its thread sends from here
    Context context_;
    std::vector<Endpoint> endpoints_;     //!< per member
    std::vector<Socket> sockets_;         //!< per member
    std::vector<Call> calls_;             //!< per member
    std::vector<SendPool::Slot*> slots_;  //!< per member: reserved, not yet sent
    std::vector<int> peers_;              //!< all members but this one
    std::vector<pollfd> signals_;         //!< per peer
    std::shared_ptr<Received> spare_;     //!< for the next message
    std::unique_ptr<Door> door_;
    std::unique_ptr<ConnectionWatch> watch_;  // after the sockets: it ends before they close
    std::size_t turn_ = 0;
    bool settled_ = false;
};

}  // namespace

std::unique_ptr<Transport> make_zmq_transport(Members const& members, Network const& network)
{
    return std::make_unique<ZmqTransport>(members, network);
}

}  // namespace sluice
