#pragma once

#include <cmath>

#include "participants/dem/vec.hpp"

namespace dem {

//! Friction with memory, limited by Coulomb:
//!     trial = spring + 2 alpha_t sqrt(kt m*) s,      Ft = trial, or shortened to mu |Fn|   [N], against the slip s
//! where the spring is the elastic force: it grows by kt ds. The dashpot is inside the limit. In sliding the spring is
//! cut back so that spring + dashpot equals the limit.
//! Source: Cundall and Strack (1979); cut as in Luding, Granular Matter 10 (2008), sec. 3. hertz: kt = 8 G* sqrt(R*
//! xi), Mindlin (1949) without slip; the spring shrinks with kt in unloading, else it would make energy (Thornton,
//! Cummins and Cleary, Powder Technology 210 (2011) 189).
struct TangentialForce
{
    double stiffness = 0.0;  //!< linear: kt [N/m]; hertz: 8 G* [Pa]
    double damping = 0.0;  //!< linear: 2 alpha_t sqrt(kt) [sqrt(N/m)]; hertz: 2 alpha_t sqrt(5/6) sqrt(8 G*) [sqrt(Pa)]
    double friction = 0.0;  //!< mu [-], >= 0
};

//! A force that sticks or is at its limit.
template <class Tangent>
struct Limited
{
    Tangent force;   //!< spring + dashpot after the limit [N]
    Tangent spring;  //!< the elastic part, after the cut [N]
    bool slides;
};

//! `spring` already stretched by this step's slip, `dashpot` the viscous part, `limit` >= 0   [N].
template <class Tangent>
inline Limited<Tangent> limited(Tangent spring, Tangent dashpot, double limit) noexcept
{
    Tangent const trial = spring + dashpot;
    double const square = dot(trial, trial);
    if (square <= limit * limit) return {trial, spring, false};
    Tangent const force = limit / std::sqrt(square) * trial;
    return {force, force - dashpot, true};
}

}  // namespace dem
