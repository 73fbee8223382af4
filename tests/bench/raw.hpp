#pragma once

#include "tests/bench/way.hpp"

//! What each medium can do by itself: a copy in, a copy out, and nothing else. Independent of the coupling layer.
namespace bench {

std::unique_ptr<Way> raw_shm(Setting const& setting);  //!< spins for about a millisecond, then a futex
std::unique_ptr<Way> raw_zmq_ipc(Setting const& setting);
std::unique_ptr<Way> raw_zmq_tcp(Setting const& setting);
std::unique_ptr<Way> raw_mpi(Setting const& setting);  //!< MPI_Send and MPI_Recv; MPI is running

//! How much of Setting::arena raw_shm needs.
std::size_t raw_shm_size(std::size_t most_points);

}  // namespace bench
