#pragma once

#include "tests/bench/way.hpp"

//! Whole windows of a coupled run: ids, positions and the number of points change in every one, XXH3 over every frame.
//! Serial: one side waits for the other's result of the same window; parallel: both compute at once.
namespace bench {

std::unique_ptr<Way> session_shm(Setting const& setting);
std::unique_ptr<Way> session_shm_parallel(Setting const& setting);
std::unique_ptr<Way> session_zmq(Setting const& setting);
std::unique_ptr<Way> session_zmq_parallel(Setting const& setting);
//! Forces on points whose velocities go the other way: the ledger off, without energy, and with it in each window.
std::unique_ptr<Way> session_unbooked(Setting const& setting);
std::unique_ptr<Way> session_amounts(Setting const& setting);
std::unique_ptr<Way> session_energy(Setting const& setting);
std::unique_ptr<Way> session_mpi(Setting const& setting);  //!< initialises MPI
//! The points move over a lattice: the receiver spreads what they carry on it (conservative) and gathers at their
//! places (consistent), three numbers each way, with the linear kernel in 3D.
std::unique_ptr<Way> session_lattice(Setting const& setting);

}  // namespace bench
