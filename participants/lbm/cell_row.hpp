#pragma once

#include <array>

#include "participants/lbm/lanes.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/relaxation.hpp"

//! What the collisions of a row of cells share (collide_plane.hpp, collide_space.hpp).
namespace lbm {

//! What a run of the solver needs; chosen once (kernels.hpp).
struct Features
{
    bool les = false;
    bool force = false;
    bool grains = false;
    bool split = false;  //!< in space: the second moments have rates of their own, as with les
    bool frame = false;  //!< force grows along the row, and turns with the velocity
    bool operator==(Features const&) const = default;
};

//! What the collision of one row needs to know of the solids, and what it tells of them; arrays over x, 64-byte
//! aligned.
struct SolidRow
{
    double const* fraction;  //!< sum of the bodies' solid fractions eps [-], may exceed 1 where bodies overlap
    double const* weight;    //!< B/sum(eps) [-]: solids push a cell by -2 B (j - rho u_s) a step
    double const* open;      //!< the fluid of the cell is 1/open times as viscous [-]
    std::array<double const*, 3> momentum;  //!< sum of eps u_s (cells a step); of D entries
    double* force_rate;                     //!< out: 2 weight rho
    std::array<double*, 3> force;           //!< out: 2 weight j; a body's force is eps (force - force_rate u_s)
};

inline constexpr double eddy_free = 1e-6;  //!< cells covered by more have no eddy viscosity

//! Rate of an even moment where the fluid is 1/open times as viscous: (1/rate - 1/2) is 1/open times as large.
template <class V>
[[gnu::always_inline]] inline V stiffened(double rate, V open) noexcept
{
    return open / (0.5 * open + (1.0 / rate - 0.5));
}
//! Rate of an odd moment there: (1/rate - 1/2) is open times as large, so that their product, magic, is the same.
template <class V>
[[gnu::always_inline]] inline V loosened(double rate, V open) noexcept
{
    return 1.0 / (0.5 + (1.0 / rate - 0.5) * open);
}

}  // namespace lbm
