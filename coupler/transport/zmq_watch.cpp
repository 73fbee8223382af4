#include "coupler/transport/zmq_watch.hpp"

#include <linux/filter.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace sluice {
namespace {

constexpr int events_of_interest = ZMQ_EVENT_LISTENING | ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_CONNECTED | ZMQ_EVENT_CLOSED |
                                   ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                                   ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                                   ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;

constexpr std::chrono::milliseconds shortest_look{20}, longest_look{500};

std::string take_part(void* socket)
{
    Received part;
    if (zmq_msg_recv(&part.message, socket, ZMQ_DONTWAIT) < 0) return {};
    return {static_cast<char const*>(zmq_msg_data(&part.message)), zmq_msg_size(&part.message)};
}

std::vector<std::string> take_parts(void* socket)
{
    std::vector<std::string> parts;
    int more = 1;
    for (std::size_t size = sizeof more; more != 0; zmq_getsockopt(socket, ZMQ_RCVMORE, &more, &size))
        parts.push_back(take_part(socket));
    return parts;
}

//! A filter that lets no packet through; connections that there are have none.
void close_to_strangers(int listening)
{
    sock_filter nothing[] = {BPF_STMT(BPF_RET | BPF_K, 0)};
    sock_fprog const program = {1, nothing};
    (void)::setsockopt(listening, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);  // refused all the same
}

}  // namespace

ConnectionWatch::ConnectionWatch(void* context, std::vector<Endpoint> const& endpoints, int self,
                                 Doorman const& doorman, std::chrono::milliseconds silence)
    : endpoints_(endpoints),
      self_(self),
      doorman_(doorman),
      look_every_(std::clamp(silence / 10, shortest_look, longest_look)),
      events_(new_socket(context, ZMQ_PULL)),
      requests_(new_socket(context, ZMQ_REP)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))
{
    require(wake_ >= 0, [] { return Error("no descriptor left. Raise `ulimit -n`.", Exit::io); });
    set_option(events_.get(), ZMQ_LINGER, 0);
    set_option(events_.get(), ZMQ_RCVHWM, 0);  // without limit: a full queue would stop libzmq
    set_option(requests_.get(), ZMQ_LINGER, 0);
    zmq_bind(requests_.get(), "inproc://zeromq.zap.01");
    for (std::size_t p = 0; p < endpoints.size(); ++p) {
        bool const tcp = endpoints[p].port != 0;
        connections_.emplace_back(Connection::Terms{self < static_cast<int>(p), tcp, doorman.curve() && tcp, silence});
        open_.emplace_back(false);
    }
    thread_ = std::thread([this] { run(); });
}

ConnectionWatch::~ConnectionWatch()
{
    {
        std::lock_guard const lock(mutex_);
        ending_ = true;
    }
    wake();
    thread_.join();
    ::close(wake_);
}

void ConnectionWatch::wake() const
{
    std::uint64_t const one = 1;
    (void)!::write(wake_, &one, sizeof one);
}

//! The thread is made to listen before there can be an event: libzmq waits, with all its sockets, for who takes them.
void ConnectionWatch::attach(int peer, void* socket)
{
    auto const name = "inproc://monitor-" + std::to_string(peer) + "-" + std::to_string(attachments_++);
    require(zmq_socket_monitor(socket, name.c_str(), events_of_interest) == 0,
            [] { return Error(std::string("no events: ") + zmq_strerror(errno) + ".", Exit::io); });
    std::unique_lock lock(mutex_);
    to_attach_ = name;
    wake();
    attached_.wait(lock, [&] { return to_attach_.empty(); });
}

void ConnectionWatch::run()
{
    zmq_pollitem_t items[] = {
        {nullptr, wake_, ZMQ_POLLIN, 0}, {events_.get(), 0, ZMQ_POLLIN, 0}, {requests_.get(), 0, ZMQ_POLLIN, 0}};
    auto next_look = Transport::Clock::now() + look_every_;
    for (;;) {
        for (auto& item : items) item.revents = 0;
        (void)zmq_poll(items, 3, look_every_.count());
        std::lock_guard const lock(mutex_);
        if (items[0].revents & ZMQ_POLLIN) {
            std::uint64_t count = 0;
            (void)!::read(wake_, &count, sizeof count);
        }
        if (ending_) return;
        if (!to_attach_.empty()) {
            zmq_connect(events_.get(), to_attach_.c_str());
            to_attach_.clear();
            attached_.notify_all();
        }
        if (items[1].revents & ZMQ_POLLIN)
            read_event();
        else if (items[2].revents & ZMQ_POLLIN)
            answer_request();  // after what is known has been taken in
        if (Transport::Clock::now() < next_look) continue;
        for (auto& connection : connections_) connection.look();
        next_look = Transport::Clock::now() + look_every_;
    }
}

Connection* ConnectionWatch::find(std::string const& uri)
{
    auto const colon = uri.rfind(':');
    for (std::size_t p = 0; p < endpoints_.size(); ++p) {
        bool const ipc = endpoints_[p].port == 0;
        if (static_cast<int>(p) != self_ &&
            (ipc ? uri == endpoints_[p].uri : uri.substr(colon + 1) == std::to_string(endpoints_[p].port)))
            return &connections_[p];
    }
    return nullptr;
}

void ConnectionWatch::read_event()
{
    auto const parts = take_parts(events_.get());  // number (16 bits) and value (32 bits); endpoint
    if (parts.size() != 2 || parts[0].size() != 6) return;
    std::uint16_t number = 0;
    std::memcpy(&number, parts[0].data(), sizeof number);
    std::int32_t value = 0;
    std::memcpy(&value, parts[0].data() + sizeof number, sizeof value);
    auto* const connection = find(parts[1]);
    if (!connection) return;
    connection->event(number, value);
    open_[static_cast<std::size_t>(connection - connections_.data())] = connection->is_open();
}

void ConnectionWatch::answer_request()
{
    auto const parts = take_parts(requests_.get());  // version, id, domain, address, identity, mechanism, credentials
    if (parts.size() < 6) return;
    auto const verdict = doorman_.judge({parts[2], parts[5], {parts.begin() + 6, parts.end()}});
    char const* status = verdict.refusal.empty() ? "200" : "400";
    if (verdict.peer >= 0) {
        auto& connection = at(verdict.peer);
        if (!verdict.refusal.empty())
            connection.refused(verdict.refusal);
        else if (connection.is_taken() || connection.is_settled())
            status = "500";
    }
    std::string const answer[] = {"1.0", parts[1], status, "", "", ""};  // ..., text, user, metadata
    for (std::size_t i = 0; i < std::size(answer); ++i)
        zmq_send(requests_.get(), answer[i].data(), answer[i].size(), i + 1 < std::size(answer) ? ZMQ_SNDMORE : 0);
}

bool ConnectionWatch::lost(int peer) const
{
    std::lock_guard const lock(mutex_);
    return connections_[static_cast<std::size_t>(peer)].lost();
}

void ConnectionWatch::carried_message(int peer, int descriptor)
{
    std::lock_guard const lock(mutex_);
    at(peer).carried_message(descriptor);
    open_[static_cast<std::size_t>(peer)] = at(peer).is_open();
}

bool ConnectionWatch::take_failed_attempt(int peer)
{
    std::lock_guard const lock(mutex_);
    return at(peer).take_failed_attempt();
}

void ConnectionWatch::settle()
{
    std::lock_guard const lock(mutex_);
    for (std::size_t p = 0; p < connections_.size(); ++p) {
        connections_[p].settle();
        if (endpoints_[p].port != 0 && connections_[p].listening() >= 0)
            close_to_strangers(connections_[p].listening());
    }
}

std::string ConnectionWatch::trouble(int peer) const
{
    auto const at = static_cast<std::size_t>(peer);
    bool unreached = false;
    {
        std::lock_guard const lock(mutex_);
        auto const& connection = connections_[at];
        if (auto text = connection.trouble(); !text.empty() || connection.is_taken()) return text;
        unreached = connection.unreached();
    }
    auto const& endpoint = endpoints_[at];
    auto const why = unreached && peer != self_ ? why_unreachable(endpoint) : "";
    return why.empty() ? why : endpoint.uri + ": " + why;
}

}  // namespace sluice
