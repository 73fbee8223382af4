#pragma once

#include <array>

#include "participants/lbm/populations.hpp"

namespace lbm {

//! The sides in lattice units.
struct Walls
{
    std::array<bool, 3> periodic;  //!< along x, y, z
    //! Of the lower and the upper side along each axis; along the side (cells a step).
    std::array<std::array<std::array<double, 3>, 2>, 3> velocity;
};

//! Rewrites the populations that enter a row from ghost cells, before the row collides: half-way bounce-back takes the
//! one that left into that ghost cell and adds 6 w_q rho_0 c_q.u_wall (Ladd, J. Fluid Mech. 271 (1994) 285); a periodic
//! side takes the one that left on the other side. Links through an edge belong to the wall across the last axis (top
//! and bottom before the others): with rho_0 such a moving wall then adds no mass. Touches slots of that row alone, and
//! may be repeated.
template <int D>
void enter_from_outside(Populations<D>& populations, std::ptrdiff_t row, Walls const& walls);

}  // namespace lbm
