#pragma once

#include "tests/bench/way.hpp"

//! This project's transports with opaque bytes: reserve, fill, commit; receive and read every byte in place.
namespace bench {

std::unique_ptr<Way> our_shm(Setting const& setting);
std::unique_ptr<Way> our_zmq_ipc(Setting const& setting);
std::unique_ptr<Way> our_zmq_tcp(Setting const& setting);
std::unique_ptr<Way> our_mpi(Setting const& setting);  //!< initialises MPI

}  // namespace bench
