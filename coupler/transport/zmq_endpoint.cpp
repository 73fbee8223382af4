#include "coupler/transport/zmq_endpoint.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "coupler/transport/port_owner.hpp"

namespace sluice {
namespace {

constexpr int last_port = 65535;
constexpr int patience = 300;  // ms, of why_unreachable()

struct FreeAddresses
{
    void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

struct Address
{
    std::string number;
    bool ipv6 = false;
    bool loopback = false;
};

Address resolve(std::string const& host)
{
    addrinfo hints = {};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    int const failed = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
    std::unique_ptr<addrinfo, FreeAddresses> const list(found);
    require(failed == 0, [&] {
        return Error("host " + host + ": " + ::gai_strerror(failed) + " (needed: an address, or a name in DNS or " +
                     "/etc/hosts of every host of the run).");
    });
    addrinfo const* best = found;
    for (auto const* a = found; a; a = a->ai_next)
        if (a->ai_family == AF_INET && best->ai_family != AF_INET) best = a;
    char number[NI_MAXHOST] = {};
    ::getnameinfo(best->ai_addr, best->ai_addrlen, number, sizeof number, nullptr, 0, NI_NUMERICHOST);
    Address address{number, best->ai_family == AF_INET6, false};
    address.loopback = address.number.starts_with("127.") || address.number == "::1";
    return address;
}

//! PORT of tcp://HOST:PORT, 0 if there is none.
int port_of(std::string const& address)
{
    auto const colon = address.rfind(':');
    auto const digits = address.substr(colon + 1);
    bool const number = colon > 5 && !digits.empty() && digits.size() <= 5 &&
                        digits.find_first_not_of("0123456789") == std::string::npos;
    return number ? std::stoi(digits) : 0;
}

void require_port(int port, int count, std::string const& what)
{
    require(port > 0 && port + count * count - 1 <= last_port, [&] {
        return Error(what + ": no port, or not room for " + std::to_string(count) +
                     " processes (needed: PORT + n*n - 1 <= 65535; for loopback tcp://127.0.0.1:PORT).");
    });
}

//! A name such as this host's own may stand for 127.0.1.1: then nobody could come from outside.
void require_reachable(std::string const& host, Address const& address, Members const& members, Network const& network)
{
    if (!address.loopback) return;
    for (auto p = static_cast<std::size_t>(members.self) + 1; p < network.hosts.size(); ++p) {
        auto const& other = network.hosts[p];
        if (other.empty() || other == host || resolve(other).loopback) continue;
        throw Error("host " + host + " of \"" + members.names[static_cast<std::size_t>(members.self)] + "\" is " +
                    address.number + " here, this host's loopback: \"" + members.names[p] + "\" on " + other +
                    " cannot come (needed: an address of this host's network). Look at /etc/hosts.");
    }
}

Endpoint over_ipc(Network const& network, std::string const& pair)
{
    Endpoint endpoint;
    endpoint.uri = "ipc://" + network.directory.string() + "/" + pair;
    auto const length = endpoint.uri.size() - 6;
    require(length < sizeof(sockaddr_un::sun_path), [&] {
        return Error(
            endpoint.uri + ": " + std::to_string(length) + " characters (at most 107). Use a shorter directory.",
            Exit::io);
    });
    return endpoint;
}

}  // namespace

Endpoint endpoint_between(Members const& members, Network const& network, int peer)
{
    int const count = static_cast<int>(members.names.size());
    int const low = std::min(peer, members.self), high = std::max(peer, members.self);
    if (network.hosts.empty() && network.address.empty())
        return over_ipc(network, std::to_string(low) + "-" + std::to_string(high));
    Endpoint endpoint;
    if (network.hosts.empty()) {
        int const first = port_of(network.address);
        require_port(first, count, "address " + network.address);
        endpoint.port = first + low * count + high;
        endpoint.uri = network.address.substr(0, network.address.rfind(':') + 1) + std::to_string(endpoint.port);
        return endpoint;
    }
    require_port(network.port, count, "port " + std::to_string(network.port));
    endpoint.port = network.port + low * count + high;
    endpoint.host = network.hosts.at(static_cast<std::size_t>(low));
    auto const address = endpoint.host.empty() ? Address{"127.0.0.1", false, true} : resolve(endpoint.host);
    if (low == members.self) require_reachable(endpoint.host, address, members, network);
    endpoint.ipv6 = address.ipv6;
    endpoint.uri =
        "tcp://" + (address.ipv6 ? "[" + address.number + "]" : address.number) + ":" + std::to_string(endpoint.port);
    return endpoint;
}

Error bind_error(Endpoint const& endpoint, int error)
{
    auto const what = endpoint.uri + ": ";
    if (error == EADDRINUSE && endpoint.port != 0)
        return Error(what + "port " + std::to_string(endpoint.port) + " is taken by " + port_owner(endpoint.port) +
                         " (needed by this run). End it, or give the scene another port.",
                     Exit::io);
    if (error == EADDRNOTAVAIL || error == ENODEV)
        return Error(what + (endpoint.host.empty() ? "the address" : "host " + endpoint.host) +
                         " is not an address of this machine (needed: one of those that `ip address` lists). Is this "
                         "participant started on the wrong host?",
                     Exit::io);
    return Error(what + zmq_strerror(error) + " (needed by this run).", Exit::io);
}

std::string why_unreachable(Endpoint const& endpoint)
{
    if (endpoint.port == 0) return {};
    auto const colon = endpoint.uri.rfind(':');
    auto host = endpoint.uri.substr(6, colon - 6);
    if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
    addrinfo hints = {};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICHOST;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found) != 0) return {};
    std::unique_ptr<addrinfo, FreeAddresses> const list(found);
    int const probe = ::socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (probe < 0) return std::strerror(errno);
    int error = ::connect(probe, found->ai_addr, found->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
        pollfd item{probe, POLLOUT, 0};
        socklen_t size = sizeof error;
        if (::poll(&item, 1, patience) == 1)
            ::getsockopt(probe, SOL_SOCKET, SO_ERROR, &error, &size);
        else
            error = ETIMEDOUT;
    }
    ::close(probe);
    std::string text = error == 0 ? "" : error == ETIMEDOUT ? "no answer within 0.3 s" : std::strerror(error);
    if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
    return text;
}

}  // namespace sluice
