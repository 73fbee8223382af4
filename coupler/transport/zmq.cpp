#include <zmq.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <set>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t largest_message = std::int64_t{1} << 30;  // bytes; libzmq reserves what a header announces
constexpr int high_water_mark = 16;                              // messages each way: bounds what a fast sender queues
constexpr milliseconds settling{300};
constexpr milliseconds slice{50};  // how often a wait looks whether a peer is lost

struct CloseSocket
{
    void operator()(void* socket) const { zmq_close(socket); }
};
using Socket = std::unique_ptr<void, CloseSocket>;

struct CloseContext
{
    void operator()(void* context) const { zmq_ctx_term(context); }
};
using Context = std::unique_ptr<void, CloseContext>;

void set_option(void* socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

//! Watches the connections in a thread of its own: libzmq stops for everybody when its events are not read.
class ConnectionWatch
{
 public:
    //! `sockets` outlives the watch.
    ConnectionWatch(void* context, std::vector<Socket> const& sockets)
        : sockets_(sockets), lost_(sockets.size()), open_(sockets.size()), monitors_(sockets.size())
    {
        for (std::size_t p = 0; p < sockets.size(); ++p) {
            if (!sockets[p]) continue;
            auto const name = "inproc://monitor-" + std::to_string(p);
            zmq_socket_monitor(sockets[p].get(), name.c_str(),
                               ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_CONNECTED | ZMQ_EVENT_DISCONNECTED);
            monitors_[p].reset(zmq_socket(context, ZMQ_PAIR));
            set_option(monitors_[p].get(), ZMQ_LINGER, 0);
            zmq_connect(monitors_[p].get(), name.c_str());
        }
        thread_ = std::thread([this] { run(); });
    }

    ConnectionWatch(ConnectionWatch const&) = delete;
    ConnectionWatch& operator=(ConnectionWatch const&) = delete;

    ~ConnectionWatch()
    {
        stop_ = true;
        thread_.join();
        for (auto const& socket : sockets_)
            if (socket) zmq_socket_monitor(socket.get(), nullptr, 0);  // before the reader closes
    }

    bool lost(int peer) const { return lost_[static_cast<std::size_t>(peer)].load(); }
    void settle() { settled_at_ = std::chrono::steady_clock::now().time_since_epoch().count(); }

 private:
    void run()
    {
        std::vector<zmq_pollitem_t> items;
        std::vector<std::size_t> peers;
        for (std::size_t p = 0; p < monitors_.size(); ++p)
            if (monitors_[p]) {
                items.push_back({monitors_[p].get(), 0, ZMQ_POLLIN, 0});
                peers.push_back(p);
            }
        while (!stop_) {
            if (zmq_poll(items.data(), static_cast<int>(items.size()), slice.count()) <= 0) continue;
            for (std::size_t i = 0; i < items.size(); ++i)
                if (items[i].revents & ZMQ_POLLIN) read_event(items[i].socket, peers[i]);
        }
    }

    //! Events of the time before may still be on their way for a moment.
    bool settled() const
    {
        using std::chrono::steady_clock;
        return settled_at_ != 0 &&
               steady_clock::now() > steady_clock::time_point(steady_clock::duration(settled_at_)) + settling;
    }

    void read_event(void* monitor, std::size_t peer)
    {
        unsigned char event[6] = {};  // event number (16 bits) and value (32 bits); a second part names the endpoint
        if (zmq_recv(monitor, event, sizeof event, ZMQ_DONTWAIT) < 2) return;
        char endpoint[256];
        zmq_recv(monitor, endpoint, sizeof endpoint, ZMQ_DONTWAIT);
        std::uint16_t number = 0;
        std::memcpy(&number, event, sizeof number);
        std::uint32_t descriptor = 0;
        std::memcpy(&descriptor, event + sizeof number, sizeof descriptor);
        auto& open = open_[peer];
        if (number != ZMQ_EVENT_DISCONNECTED) {  // before everybody has met a peer may be started again
            open.insert(descriptor);
            if (!settled()) lost_[peer] = false;
        } else if (open.erase(descriptor) > 0 && open.empty())  // not a stranger's that came and went
            lost_[peer] = true;
    }

    std::vector<Socket> const& sockets_;
    std::vector<std::atomic<bool>> lost_;
    std::vector<std::set<std::uint32_t>> open_;  //!< per peer: descriptors of its connections; the thread's own
    std::vector<Socket> monitors_;
    std::atomic<bool> stop_ = false;
    std::atomic<std::chrono::steady_clock::rep> settled_at_ = 0;
    std::thread thread_;
};

//! Keeps a received message alive.
struct Received
{
    Received() { zmq_msg_init(&message); }
    Received(Received const&) = delete;
    Received& operator=(Received const&) = delete;
    ~Received() { zmq_msg_close(&message); }
    zmq_msg_t message;
};

class ZmqTransport final : public Transport
{
 public:
    ZmqTransport(Members const& members, Network const& network)
        : context_(zmq_ctx_new()), sockets_(members.names.size()), buffers_(members.names.size())
    {
        auto const address = network.address.empty() ? network.directory.string() : network.address;
        auto const silence = network.silence;
        bool const tcp = address.starts_with("tcp://");
        int const count = static_cast<int>(members.names.size());
        for (int peer = 0; peer < count; ++peer)
            if (peer != members.self) sockets_[static_cast<std::size_t>(peer)] = open_socket(silence);
        watch_ = std::make_unique<ConnectionWatch>(context_.get(), sockets_);
        for (int peer = 0; peer < count; ++peer)
            if (peer != members.self) attach(peer, members.self, endpoint(address, tcp, peer, members.self, count));
    }

    std::span<std::byte> reserve(int peer, std::size_t size) override
    {
        return buffers_[static_cast<std::size_t>(peer)].room(size);
    }

    bool commit(int peer, std::size_t size) override
    {
        auto const at = static_cast<std::size_t>(peer);
        if (zmq_send(sockets_[at].get(), buffers_[at].data(), size, ZMQ_DONTWAIT) >= 0) return true;
        require(errno == EAGAIN || errno == EINTR,
                [] { return Error(std::string("zmq_send: ") + zmq_strerror(errno) + ".", Exit::io); });
        return false;
    }

    std::optional<Incoming> receive(std::chrono::microseconds patience) override
    {
        std::vector<zmq_pollitem_t> items;
        std::vector<int> peers;
        for (std::size_t p = 0; p < sockets_.size(); ++p)
            if (sockets_[p]) {
                items.push_back({sockets_[p].get(), 0, ZMQ_POLLIN, 0});
                peers.push_back(static_cast<int>(p));
            }
        if (zmq_poll(items.data(), static_cast<int>(items.size()), std::chrono::ceil<milliseconds>(patience).count()) <=
            0)
            return std::nullopt;
        for (std::size_t k = 0; k < items.size(); ++k) {
            auto const i = (k + turn_) % items.size();  // nobody is served first for ever
            if (!(items[i].revents & ZMQ_POLLIN)) continue;
            turn_ = i + 1;
            auto message = std::make_shared<Received>();
            if (zmq_msg_recv(&message->message, items[i].socket, ZMQ_DONTWAIT) < 0) continue;
            auto const* const data = static_cast<std::byte const*>(zmq_msg_data(&message->message));
            std::span const bytes(data, zmq_msg_size(&message->message));
            return Incoming{peers[i], {bytes, std::move(message)}};
        }
        return std::nullopt;
    }

    bool lost(int peer) const override { return watch_->lost(peer); }
    std::string kind() const override { return "zmq"; }

    void settle() override { watch_->settle(); }

 private:
    Socket open_socket(milliseconds silence)
    {
        Socket socket(zmq_socket(context_.get(), ZMQ_PAIR));
        require(socket != nullptr, [] {
            return Error(std::string("no ZeroMQ socket: ") + zmq_strerror(errno) + ". Raise `ulimit -n`?", Exit::io);
        });
        set_option(socket.get(), ZMQ_LINGER, 500);
        set_option(socket.get(), ZMQ_SNDHWM, high_water_mark);
        set_option(socket.get(), ZMQ_RCVHWM, high_water_mark);
        zmq_setsockopt(socket.get(), ZMQ_MAXMSGSIZE, &largest_message, sizeof largest_message);
        set_option(socket.get(), ZMQ_HEARTBEAT_IVL, static_cast<int>(silence.count() / 5));
        set_option(socket.get(), ZMQ_HEARTBEAT_TIMEOUT, static_cast<int>(silence.count()));
        set_option(socket.get(), ZMQ_HANDSHAKE_IVL, 5000);
        set_option(socket.get(), ZMQ_RECONNECT_IVL, 10);
        set_option(socket.get(), ZMQ_RECONNECT_IVL_MAX, 200);
        return socket;
    }

    static std::string endpoint(std::string const& address, bool tcp, int peer, int self, int count)
    {
        int const low = std::min(peer, self), high = std::max(peer, self);
        if (!tcp) return "ipc://" + address + "/" + std::to_string(low) + "-" + std::to_string(high);
        auto const colon = address.rfind(':');
        int port = 0;
        try {
            port = std::stoi(address.substr(colon + 1));
        } catch (std::exception const&) {
        }
        require(colon > 5 && port > 0 && port + count * count < 65536, [&] {
            return Error("address " + address + ": no port (needed: tcp://127.0.0.1:PORT, PORT from 1024 to 65000).");
        });
        return address.substr(0, colon + 1) + std::to_string(port + low * count + high);
    }

    void attach(int peer, int self, std::string const& where)
    {
        void* const socket = sockets_[static_cast<std::size_t>(peer)].get();
        int const failed = self < peer ? zmq_bind(socket, where.c_str()) : zmq_connect(socket, where.c_str());
        require(failed == 0, [&] {
            return Error(where + ": " + zmq_strerror(errno) + " (needed by this run). Is another run still going?",
                         Exit::io);
        });
    }

    Context context_;
    std::vector<Socket> sockets_;
    std::vector<Buffer> buffers_;             //!< per peer
    std::unique_ptr<ConnectionWatch> watch_;  // after the sockets: it ends before they close
    std::size_t turn_ = 0;
};

}  // namespace

std::unique_ptr<Transport> make_zmq_transport(Members const& members, Network const& network)
{
    return std::make_unique<ZmqTransport>(members, network);
}

}  // namespace sluice
