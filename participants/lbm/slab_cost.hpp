#pragma once

#include <vector>

#include "participants/lbm/solver.hpp"

namespace lbm {

//! What moving bodies cost a step beside fluid without any, by layers of the lattice (rows in the plane, planes in
//! space), in cells of such fluid: a body's volume in a layer times a measured factor. It decides what processes share
//! the work, not what they compute. Empty without bodies.
template <int D>
std::vector<double> cost_of_bodies(Config const& config, BodiesView const& bodies);

}  // namespace lbm
