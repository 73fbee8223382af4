#pragma once

#include <array>

#include "participants/lbm/populations.hpp"

namespace lbm {

//! The four sides in lattice units.
struct Walls
{
    bool periodic_x, periodic_y;
    std::array<double, 4> velocity;  //!< along the side, indexed by Side (cells a step)
};

//! Rewrites the populations that enter row y from ghost cells, before the row collides: half-way bounce-back takes the
//! one that left into that ghost cell and adds 6 w_q rho_0 c_q.u_wall (Ladd, J. Fluid Mech. 271 (1994) 285); a periodic
//! side takes the one that left on the other side. Corner links belong to the bottom or top wall: with rho_0 a moving
//! wall then adds no mass. Touches slots of row y alone, and may be repeated.
void enter_from_outside(Populations& populations, std::ptrdiff_t y, Walls const& walls);

}  // namespace lbm
