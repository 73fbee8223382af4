#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/verification/lbm/lattice_case.hpp"

namespace lattice_case {

//! F/(mu U) of one disc in a periodic square of `side` cells [-]. The flow is driven by a force density b on the
//! fluid's share of each cell; U is the mean over the whole square. In the steady state the disc takes b side^2 (1 -
//! c), but the pressure gradient that the reference means is b side^2 (Sangani and Acrivos).
inline double disc_array_drag(std::ptrdiff_t side, double diameter, double factor = 1,
                              std::array<double, 2> offset = {0, 0}, double tau = 0.6, Variant const& variant = {})
{
    lbm::Config c = config(side, side, tau);
    variant.set(c);
    make_periodic(c, true, true);
    auto const length = static_cast<double>(side);
    double const push = 1e-3 * c.viscosity * c.viscosity / (length * length);  // Re far below 0.01
    c.acceleration = {push, 0};
    c.hydrodynamic_radius = factor;
    lbm::Solver<2> solver(c);
    Discs discs;
    discs.add(0.5 * length + offset[0], 0.5 * length + offset[1], 0.5 * diameter);
    solver.set_bodies(discs.view());
    int const interval = std::max(50, static_cast<int>(length * length / c.viscosity / 150));
    double const u = run_to_steady(solver, interval, 1e-4, 200000, [&] { return mean_velocity(solver, 0); });
    return push * length * length / (c.viscosity * u);
}

}  // namespace lattice_case
