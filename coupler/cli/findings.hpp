#pragma once

#include <string>
#include <vector>

namespace sluice {

//! One thing looked at on this machine.
struct Finding
{
    enum class State
    {
        ok,
        warn,  //!< runs will do without, or be slower
        fail   //!< something will not run
    };
    std::string what;
    State state = State::ok;
    std::string found;
    std::string advice;  //!< what to do; empty if nothing is to be done
};

//! Looks at everything that runs need: libraries, solvers, MPI, shared memory, limits, Python, graphviz, clock, cores.
//! Starts mpirun, dot and python3 once each, for at most 20 s; writes nothing outside /tmp and /dev/shm.
std::vector<Finding> examine();

}  // namespace sluice
