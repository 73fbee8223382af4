#pragma once

#include <cmath>
#include <vector>

#include "tests/verification/lbm/lattice_case.hpp"

namespace lattice_case {

//! Schaefer and Turek (1996): a channel of 2.2 by 0.41 m, a cylinder of 0.1 m about (0.2, 0.2), nu = 1e-3 m2/s, rho =
//! 1; SI.
struct Cylinder
{
    lbm::Config config;
    double mean_velocity;  //!< 2/3 of the largest

    Cylinder(std::ptrdiff_t cells, double largest_velocity, double lattice_velocity, Variant const& variant = {})
        : mean_velocity(2 * largest_velocity / 3)
    {
        lbm::Config& c = config;
        c.cell = 0.1 / static_cast<double>(cells);
        c.step = lattice_velocity * c.cell / largest_velocity;
        c.size = {2.2, 0.41};
        c.density = 1;
        c.viscosity = 1e-3;
        c.max_velocity = largest_velocity;
        variant.set(c);
        c.walls[lbm::left] = {
            .kind = lbm::Border::inflow, .velocity = {largest_velocity, 0, 0}, .parabola = true, .ramp = 0.2};
        c.walls[lbm::right].kind = lbm::Border::pressure;
    }
    double coefficient(double force) const { return 2 * force / (mean_velocity * mean_velocity * 0.1); }
};

struct Forces
{
    double drag, lift, pressure_drop;
    double recirculation;  //!< from the rear point to where fluid on the axis of the cylinder flows downstream [m]
};

//! Coefficients of 2D-1 (Re = 20) once they are steady.
inline Forces steady_cylinder(std::ptrdiff_t cells, Variant const& variant = {})
{
    Cylinder const c(cells, 0.3, 0.04, variant);
    lbm::Solver<2> solver(c.config);
    std::vector<double> const position{0.2, 0.2}, rest{0, 0}, spin{0}, radius{0.05};
    solver.set_bodies({position, rest, spin, radius});
    double drag = 0, lift = 0;
    for (double before = 1; solver.time() < 30;) {
        double const end = solver.time() + 1;
        double sum_drag = 0, sum_lift = 0, n = 0;
        while (solver.time() < end) {
            solver.step();
            sum_drag += solver.loads().force[0], sum_lift += solver.loads().force[1], n += 1;
        }
        drag = c.coefficient(sum_drag / n), lift = c.coefficient(sum_lift / n);
        if (std::abs(drag - before) < 1e-4 * drag) break;
        before = drag;
    }
    // pressure at the front and the rear point, from the line through the axis
    lbm::Fields const f = solver.fields();
    auto const row = static_cast<std::ptrdiff_t>(0.2 / c.config.cell);
    auto const pressure = [&](double x, int away) {
        auto const value = [&](int k) {
            auto const at = [&](std::ptrdiff_t y) {
                double const s = x / c.config.cell + away * (k + 0.5);
                return f.pressure[static_cast<std::size_t>(y * f.nx + static_cast<std::ptrdiff_t>(s))];
            };
            return 0.5 * (at(row - 1) + at(row));
        };
        // to the surface by the parabola through the cells 1.5, 2.5 and 3.5 off it
        return (35 * value(1) - 42 * value(2) + 15 * value(3)) / 8;
    };
    auto const along = [&](std::ptrdiff_t x) {
        auto const at = [&](std::ptrdiff_t y) { return f.velocity[static_cast<std::size_t>(2 * (y * f.nx + x))]; };
        return 0.5 * (at(row - 1) + at(row));
    };
    auto x = static_cast<std::ptrdiff_t>(0.27 / c.config.cell);
    while (x + 1 < f.nx && along(x) < 0) ++x;
    double const turns = static_cast<double>(x) + 0.5 - along(x) / (along(x) - along(x - 1));
    return {drag, lift, pressure(0.15, -1) - pressure(0.25, 1), turns * c.config.cell - 0.25};
}

}  // namespace lattice_case
