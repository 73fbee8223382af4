#pragma once

#include <memory>

#include "participants/ranks/peers.hpp"

namespace ranks {

//! The processes of a participant that one mpirun has started side by side: this one is `rank` of `count`. Begins MPI
//! unless somebody has, and then ends it. Throws sluice::Error (config) if they are not there.
std::unique_ptr<Peers> mpi_peers(int rank, int count);

}  // namespace ranks
