#include "coupler/transport/zmq_socket.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace sluice {
namespace {

constexpr int linger = 2000;           // ms that an end waits for what nobody takes
constexpr int handshake = 5000;        // ms that a stranger may hold a descriptor
constexpr int beats = 5;               // heartbeats in the silence that is allowed
constexpr int never = 86'400'000;      // ms
constexpr int no_return = 43'200'000;  // ms before libzmq itself calls again: by then a run that lost a peer is over
constexpr rlim_t enough_descriptors = 65'536;
// measured (tests/faults/zmq_test.cpp, S6): 9, and 4 a peer, with shared memory 3 more; the rest is for files
constexpr rlim_t own_descriptors = 12, peer_descriptors = 7;

//! Strangers may hold a descriptor of ours each until their handshake has timed out.
void allow_many_descriptors()
{
    rlimit limit = {};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = std::max(limit.rlim_cur, std::min(limit.rlim_max, enough_descriptors));
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

void require_descriptors(std::size_t peers)
{
    std::error_code none;
    auto const open = std::distance(std::filesystem::directory_iterator("/proc/self/fd", none), {});
    auto const needed = static_cast<rlim_t>(open) + own_descriptors + peer_descriptors * peers;
    rlimit limit = {};
    if (none || ::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= needed) return;
    limit.rlim_cur = std::min(limit.rlim_max, needed);
    require(limit.rlim_max >= needed && ::setrlimit(RLIMIT_NOFILE, &limit) == 0, [&] {
        return Error("open files: the limit is " + std::to_string(limit.rlim_max) + " (needed for " +
                         std::to_string(peers) + " peers: " + std::to_string(needed) + "). Raise `ulimit -n`.",
                     Exit::io);
    });
}

Socket open_pair(void* context, Network const& network, bool tcp)
{
    auto socket = new_socket(context, ZMQ_PAIR);
    auto const largest = static_cast<std::int64_t>(network.largest_message);
    auto const silence = static_cast<int>(network.silence.count());
    zmq_setsockopt(socket.get(), ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    set_option(socket.get(), ZMQ_LINGER, linger);
    set_option(socket.get(), ZMQ_SNDHWM, network.queue);
    set_option(socket.get(), ZMQ_RCVHWM, network.queue);
    set_option(socket.get(), ZMQ_HEARTBEAT_IVL, silence / beats);
    // Over tcp Connection::look() finds who is silent: to ZeroMQ a message under way is no sign of life before its end.
    set_option(socket.get(), ZMQ_HEARTBEAT_TIMEOUT, tcp ? never : silence);
    set_option(socket.get(), ZMQ_HANDSHAKE_IVL, handshake);
    // Not ZMQ_IMMEDIATE, which would spare us asking whether there is a connection before sending: with it the side
    // that called drops what it has not read yet when the other one leaves. We call again ourselves, on a new socket,
    // and no more once all have met. Not -1: libzmq would then end the endpoint, and drop what was not read with it.
    set_option(socket.get(), ZMQ_RECONNECT_IVL, no_return);
    return socket;
}

void listen_at(void* socket, Endpoint const& endpoint)
{
    if (endpoint.port != 0) allow_many_descriptors();
    set_option(socket, ZMQ_IPV6, endpoint.ipv6 ? 1 : 0);
    require(zmq_bind(socket, endpoint.uri.c_str()) == 0, [&] { return bind_error(endpoint, errno); });
}

bool call_at(void* socket, Endpoint const& endpoint)
{
    set_option(socket, ZMQ_IPV6, endpoint.ipv6 ? 1 : 0);
    return zmq_connect(socket, endpoint.uri.c_str()) == 0;
}

bool has_message(void* socket)
{
    int events = 0;
    std::size_t size = sizeof events;
    return zmq_getsockopt(socket, ZMQ_EVENTS, &events, &size) == 0 && (events & ZMQ_POLLIN) != 0;
}

}  // namespace sluice
