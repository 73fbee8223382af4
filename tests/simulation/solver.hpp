#pragma once

#include <string>
#include <vector>

#include "coupler/coupler.hpp"
#include "tests/simulation/topology.hpp"
#include "tests/simulation/world.hpp"

namespace simulation {

//! What one member has seen and done.
struct Record
{
    std::uint64_t states = 0;              //!< hash of all that it received and sent
    std::vector<double> times{0.0};        //!< ends of the windows that stand, s
    std::vector<std::string> broken = {};  //!< what was not as it must be
};

//! The tiny solver of process `rank` of participant p: tells its points, checks everything that it receives.
void solve(sluice::Participant& self, Topology const& topology, int p, int member, std::int64_t work, World& world,
           Record& record);

}  // namespace simulation
