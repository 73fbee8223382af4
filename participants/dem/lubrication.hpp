#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dem {

//! The fluid that is squeezed out of a gap narrower than a cell of its lattice, which does not see it: a normal force
//! against approach and parting,
//!     spheres  F = -6 pi mu R*^2 dh/dt (1/h - 1/hc),   discs  F = -3 sqrt(2) pi mu dh/dt ((R*/h)^1.5 - (R*/hc)^1.5)
//!     [N/m],
//! h the gap, at least `floor` R* (roughness), below the cutoff hc, from which the lattice has it. Where grains touch
//! it fades over an overlap of floor R*: what happens in a contact is the contact law's. Source: lubrication theory,
//! Kim and Karrila, Microhydrodynamics (1991), ch. 9; discs: the same integral in the plane.
struct Lubrication
{
    double viscosity = 0.0;  //!< mu [Pa s]
    double cutoff = 0.0;     //!< hc [m]; 0: none
    double floor = 0.0;      //!< smallest gap that counts, over R* [-]

    bool any() const noexcept { return cutoff > 0.0; }

    //! Force over closing speed at a gap [m] of partners of effective radius R* [m]: spheres N s/m, discs N s/m2.
    template <int D>
    double resistance(double gap, double radius) const noexcept
    {
        double const smallest = floor * radius, h = std::max(gap, smallest), pi = std::numbers::pi;
        if (h >= cutoff || gap <= -smallest) return 0.0;
        double const share = gap < 0.0 ? 1.0 + gap / smallest : 1.0;
        if constexpr (D == 3) return share * 6.0 * pi * viscosity * radius * radius * (1.0 / h - 1.0 / cutoff);
        return share * 3.0 * std::numbers::sqrt2 * pi * viscosity *
               (std::pow(radius / h, 1.5) - std::pow(radius / cutoff, 1.5));
    }
};

}  // namespace dem
