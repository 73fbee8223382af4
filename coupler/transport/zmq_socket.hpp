#pragma once

#include "coupler/transport/zmq_endpoint.hpp"
#include "coupler/transport/zmq_handle.hpp"

namespace sluice {

//! A PAIR socket with every bound that a run needs: queues, sizes, heartbeats, handshake, linger.
Socket open_pair(void* context, Network const& network, bool tcp);

//! Throws bind_error(). Over tcp this process may then hold more descriptors than before.
void listen_at(void* socket, Endpoint const& endpoint);

bool call_at(void* socket, Endpoint const& endpoint);
bool has_message(void* socket);  //!< one can be read now

}  // namespace sluice
