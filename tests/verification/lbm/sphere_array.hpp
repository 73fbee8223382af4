#pragma once

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "tests/participants/lbm/surfaces.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

namespace lattice_case {

inline lbm::Config config_in_space(lbm::Extent const& cells, double tau, std::array<bool, 3> periodic)
{
    lbm::Config c = config(cells[0], cells[1], tau);
    c.dimension = 3;
    c.size[2] = static_cast<double>(cells[2]);
    c.collision = lbm::Operator::trt;
    for (std::size_t k = 0; k < 3; ++k) c.set_periodic(k, periodic[k]);
    return c;
}

enum class Made
{
    analytic,
    of_triangles  //!< a solid at rest; 60 bands of 120
};

//! K = F/(6 pi mu a U) of one sphere in a periodic cube of `side` cells, driven by a force density on all of it; U is
//! the mean over the whole cube.
inline double sphere_array_drag(std::ptrdiff_t side, double diameter, double tau, Made made = Made::analytic,
                                Variant const& variant = {.collision = lbm::Operator::trt})
{
    lbm::Config c = config_in_space({side, side, side}, tau, {true, true, true});
    variant.set(c);
    auto const length = static_cast<double>(side);
    double const push = 1e-3 * c.viscosity * c.viscosity / (length * length * length) * diameter;  // Re far below 0.01
    c.acceleration = {push, 0, 0};
    c.hydrodynamic_radius = 1;
    double const middle = 0.5 * length + 0.13;  // of no symmetry
    std::vector<double> const place{middle, middle + 0.2, middle - 0.3}, rest(3, 0.0), radius{0.5 * diameter};
    if (made == Made::of_triangles)
        c.solids = {{.name = "sphere",
                     .shape = lbm::Solid::Shape::mesh,
                     .surface = surfaces::sphere({place[0], place[1], place[2]}, radius[0], 60)}};
    lbm::Solver<3> solver(c);
    if (made == Made::analytic) solver.set_bodies({place, rest, rest, radius});
    // the flow comes up with the time constant U L^3/(F/rho) = L^3/(6 pi nu a K)
    int const interval = std::max(20, static_cast<int>(length * length * length / (9.4 * c.viscosity * diameter * 4)));
    double const u = run_to_steady(solver, interval, 3e-4, 100000, [&] { return mean_velocity(solver, 0); });
    return push * length * length * length / (3 * std::numbers::pi * c.viscosity * diameter * u);
}

}  // namespace lattice_case
