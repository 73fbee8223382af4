#pragma once

#include "participants/dem/config.hpp"
#include "participants/dem/state.hpp"

namespace dem {

//! Grains that fill a periodic cell loosely: each at a random place in one cell of a grid, at rest, or at the speed of
//! the shear there.
template <int D>
Grains<D> filling(Config const& config);

}  // namespace dem
