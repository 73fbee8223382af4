#pragma once

#include <algorithm>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"

namespace ranks {

//! Throws sluice::Error (exit 2) for a participant of several processes with partners, in a scene that goes back in
//! place when one dies: some of its processes may still wait for one another then, where nobody can call them back.
inline void refuse_restart(sluice::Scene const& scene, std::string const& participant)
{
    int const self = scene.index_of(participant);
    int const ranks = scene.participants[static_cast<std::size_t>(self)].ranks;
    bool const coupled = std::ranges::any_of(
        scene.edges, [&](sluice::Edge const& edge) { return edge.from == self || edge.to == self; });
    sluice::require(ranks == 1 || !coupled || !scene.restart_on_death, [&] {
        return sluice::Error(participant + ": on-death: restart with " + std::to_string(ranks) +
                             " processes that are coupled: they cannot go back together when a partner dies (needed: "
                             "ranks: 1, or on-death: stop). Try on-death: stop, and `sluice resume` after a death.");
    });
}

}  // namespace ranks
