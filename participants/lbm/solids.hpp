#pragma once

#include <vector>

#include "participants/lbm/config.hpp"
#include "participants/lbm/coverage.hpp"

namespace lbm {

//! The solids at rest of a configuration, as fractions of cells.
template <int D>
std::vector<Patch<D>> patches_of(Config const& config);

}  // namespace lbm
