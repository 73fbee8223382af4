#pragma once

#include <string>

#include "coupler/base/error.hpp"
#include "coupler/transport/transport.hpp"

namespace sluice {

//! Where the lower-numbered member of a pair listens and the other one connects.
struct Endpoint
{
    std::string uri;  //!< tcp://10.0.0.1:5003, tcp://[fe80::1]:5003 or ipc:///run/..., numbers only
    int port = 0;     //!< 0: ipc
    bool ipv6 = false;
    std::string host;  //!< as the scene says it; empty: loopback
};

//! Resolves the listener's host: IPv4 if the name has such an address, else IPv6, alike on both sides.
//! Throws Error (exit 2) if the name is unknown, the port is missing or too high, or if this member listens on loopback
//! where a peer on another host could not come; (exit 7) if an ipc path is too long.
Endpoint endpoint_between(Members const& members, Network const& network, int peer);

//! Why `endpoint` could not be bound: a taken port with its owner, an address of another machine.
Error bind_error(Endpoint const& endpoint, int error);

//! Tries a connection of its own for at most 0.3 s: "connection refused" or the like; empty if somebody listens there.
std::string why_unreachable(Endpoint const& endpoint);

}  // namespace sluice
