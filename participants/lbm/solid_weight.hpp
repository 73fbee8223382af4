#pragma once

#include <algorithm>

namespace lbm {

//! Largest weight of the solid's collision. With 1 the populations inside a disc are thrown back for ever: after a jump
//! of the disc's velocity by dU the force would swing by 2 m_f dU at every step, undamped. With 0.95 the swing falls to
//! a half in 7 steps, and drag changes by less than 0.4 % (README: Decision, weight).
inline constexpr double full_weight = 0.95;

//! B in cells deeper than `skin` cells below a disc's surface, where no population comes from outside: what is inside
//! takes the disc's velocity in one step (2 B = 1), so that its inertia can be given back in the same step.
inline constexpr double core_weight = 0.5;
//! Neighbours of such a cell are covered wholly: > 3/sqrt(2) in the plane, sqrt(19)/2 in space.
template <int D>
inline constexpr double skin = D == 2 ? 2.13 : 2.18;

//! Drag of a partly covered cell in space over that of its fluid share: B/(1 - B) = solid_drag (tau - 1/2) eps/(1 -
//! eps). From one array of spheres (c = 0.216, d = 12 cells); README, Decisions, has the others.
inline constexpr double solid_drag = 2.5;

//! B/eps [-]: the weight of the solid's collision for each unit of fraction in a cell that bodies cover by
//! `fraction` in all. In the plane B = eps (tau - 1/2)/((1 - eps) + (tau - 1/2)), Noble and Torczynski, Int. J. Mod.
//! Phys. C 9 (1998) 1189; at most full_weight. Where bodies overlap (fraction > 1) they share the cell.
template <int D>
double weight_per_fraction(double fraction, double tau) noexcept
{
    double const t = tau - 0.5, open = std::max(0.0, 1.0 - fraction);
    double const inverse = D == 2 ? open / t + 1.0 : open / (solid_drag * t) + fraction;  // eps/B
    return 1.0 / std::max(inverse, fraction * (1.0 / full_weight));
}

}  // namespace lbm
