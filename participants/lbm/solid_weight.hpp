#pragma once

#include <algorithm>

#include "participants/lbm/coverage.hpp"

namespace lbm {

//! Solids in the lattice. A cell of which they cover eps is fluid that is 1/(1 - eps) times as viscous (1/s - 1/2 of
//! the even moments so much larger, of the odd ones smaller), and is pushed toward their velocity by -2 B (j - rho
//! u_s). Why: of a wall along the lattice that covers eps of a cell, the rest conducts momentum over 1 - eps of a cell:
//! with that viscosity alone a shear flow beside it is exact (two resistances, one after the other), and where eps = 1,
//! with B = 1, the collision is bounce-back. All this goes with the viscosity, so that a slow steady flow does not
//! depend on tau with a fixed magic number; what is left of it comes from B < 1 and open > 0.

//! Bodies with direct forcing (Surface::forced) have B = eps, whatever tau, and leave the viscosity as it is: the
//! velocity of a cell, half the force included, is (1 - eps) u + eps u_s, u that without them.

//! Largest B. With 1 the populations inside a disc are thrown back for ever: after a jump of the disc's velocity by dU
//! the force would swing by 2 m_f dU at every step, undamped. With 0.98 the swing falls to a half in 17 steps.
inline constexpr double full_weight = 0.98;
inline constexpr double least_open = 0.05;  //!< even moments in full cells must not stay for ever

//! B in cells deeper than `skin` cells below a disc's surface, where no population comes from outside: what is inside
//! takes the disc's velocity in one step (2 B = 1), so that its inertia can be given back in the same step.
inline constexpr double core_weight = 0.5;
//! Neighbours of such a cell are covered wholly: > 3/sqrt(2) in the plane, sqrt(19)/2 in space.
template <int D>
inline constexpr double skin = D == 2 ? 2.13 : 2.18;

//! K in B/(1 - B) = K (tau - 1/2) eps/(1 - eps): a drag beside the viscosity, for surfaces along which stress is not
//! constant over a cell. It goes with their curvature: K = curvature_drag/R + flat_drag, R in cells. From arrays of
//! discs (K R = 2.8 to 3.6 for c = 0.05 to 0.2, d = 6 to 40 cells; more in narrow gaps) and of spheres (4.0 to 5.0 for
//! c = 0.064 to 0.216, d = 7 to 20); README, Decisions.
template <int D>
inline constexpr double curvature_drag = D == 2 ? 3.6 : 4.5;
//! K of flat walls. The gradient of pressure acts on a whole cell, not on its open part; in a channel of H cells a drag
//! of 2/(3 H) takes that out in the mean over eps: H = 22.
inline constexpr double flat_drag = 0.03;

//! Beside inertia the drag of a sphere's curvature is less: K counts as K (1 + q/3)/(1 + q), q = inertia_ease R |u -
//! u_s|/nu with the cell's own velocity u before the solid acts, in space alone. From the drag of a sphere at rest in a
//! stream, Re = 2 to 100, d = 6 to 24 cells, which else is up to 3 % too high at Re = 32 (discs: as good without);
//! README, Decisions.
template <int D>
inline constexpr bool eased_by_inertia = D == 3;
inline constexpr double inertia_ease = 0.45;

//! R for |u_s| = nu. From the drag of a disc that moves at Re = 5 and 30, d = 4 to 12 cells: with it the drag is the
//! same to 0.5 %, without up to 7 % more.
inline constexpr double moving_lag = 0.1;

//! K of a disc or a sphere of curvature 1/R [1/cells].
template <int D>
double drag_of_curvature(double curvature) noexcept
{
    return curvature_drag<D> * curvature + flat_drag;
}

//! R of a strip's solid, for open_share(); 0 where it rests.
template <int D>
double lag_of(Strip<D> const& strip, std::span<Body<D> const> bodies, double tau) noexcept
{
    if (strip.body >= static_cast<std::ptrdiff_t>(bodies.size())) return 0;
    double square = 0;
    for (double const v : bodies[static_cast<std::size_t>(strip.body)].velocity) square += v * v;
    double const viscosity = (tau - 0.5) / 3;
    return moving_lag * square / (viscosity * viscosity);
}

//! Divides what may be 0 by itself; far below any share of a cell that matters.
template <class Number>
inline constexpr Number tiny = sizeof(Number) == sizeof(double) ? Number(1e-300) : Number(1e-30);

//! B/eps [-] of a cell that solids cover by `fraction` in all; `drag` is the sum of K eps. B is at most full_weight.
//! Where bodies overlap (fraction > 1) they share the cell.
template <class Number>
Number weight_per_fraction(Number fraction, Number drag, double tau) noexcept
{
    Number const t = static_cast<Number>(tau - 0.5), open = std::max(Number(0), Number(1) - fraction), push = t * drag;
    Number const share = std::min(push / std::max(open + push, tiny<Number>), Number(full_weight));
    return share / std::max(fraction, tiny<Number>);
}

//! The same where forced bodies cover `forced` of it, which is their B; fraction and drag are those of the others.
template <class Number>
Number weight_beside_forced(Number forced, Number fraction, Number drag, double tau) noexcept
{
    Number const share = std::min(forced + fraction * weight_per_fraction(fraction, drag, tau), Number(full_weight));
    return share / std::max(forced + fraction, tiny<Number>);
}

//! q/(eps |u - u_s|) of a cell [steps/cell], by R = curvature_drag/(K - flat_drag); 0 without curvature, and of so
//! little solid that it would not be finite.
template <class Number>
Number ease_per_fraction(Number fraction, Number drag, double tau) noexcept
{
    Number const curved = drag - Number(flat_drag) * fraction;
    return curved > std::max(Number(1e-6) * fraction, tiny<Number>)
               ? Number(3 * inertia_ease * curvature_drag<3>) / (static_cast<Number>(tau - 0.5) * curved)
               : Number(0);
}

//! How much of a cell counts as open [-]: (1 - eps + R)/(1 + R), R = moving_lag (|u_s|/nu)^2. A solid that moves covers
//! a cell in part for some 1/|u_s| steps; if momentum takes longer through the cell, 1/nu, the two resistances are
//! never steady, and the stiff cell drags more than the surface would. `lag` is the mean of R over the solids in the
//! cell.
template <class Number>
Number open_share(Number fraction, Number lag) noexcept
{
    return (std::max(Number(1) - fraction, Number(least_open)) + lag) / (Number(1) + lag);
}

}  // namespace lbm
