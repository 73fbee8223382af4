#pragma once

#include "coupler/transport/zmq_endpoint.hpp"
#include "coupler/transport/zmq_handle.hpp"

namespace sluice {

//! Raises this process's limit of open files to what so many peers need. Throws Error (exit 7) where it may not:
//! libzmq ends a process that has no descriptor left.
void require_descriptors(std::size_t peers);

//! A PAIR socket with every bound that a run needs: queues, sizes, heartbeats, handshake, linger.
Socket open_pair(void* context, Network const& network, bool tcp);

//! Throws bind_error(). Over tcp this process may then hold more descriptors than before.
void listen_at(void* socket, Endpoint const& endpoint);

bool call_at(void* socket, Endpoint const& endpoint);
bool has_message(void* socket);  //!< one can be read now

}  // namespace sluice
