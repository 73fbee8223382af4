#pragma once

#include <memory>

#include "coupler/transport/transport.hpp"

namespace sluice {

//! Shared memory where members can open each other's, `network` elsewhere and for the handshake, liveness and errors.
//! Every member wraps its network transport; a message on it grows by 8 bytes.
std::unique_ptr<Transport> make_shm_over(Members const& members, std::unique_ptr<Transport> network);

}  // namespace sluice
