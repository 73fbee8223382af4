#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "tests/verification/lbm/lattice_case.hpp"

//! R11, R12: fluid in a frame that turns. Lattice units.
using namespace lattice_case;

namespace {

//! w about z, in space; periodic in the plane across it.
lbm::Config turning(lbm::Extent const& cells, double tau, double rate)
{
    lbm::Config c = config(cells[0], cells[1], tau);
    c.dimension = 3;
    c.size[2] = static_cast<double>(cells[2]);
    c.collision = lbm::Operator::trt;
    c.set_periodic(0);
    c.set_periodic(1);
    c.rotation = sluice::Rotation{.direction = {0, 0, 1}, .rate = rate};
    return c;
}

}  // namespace

TEST_CASE("R11: inertial circles of a uniform flow")
{
    // closed form: u turns by -2 w t; marks of the file: phase (2 w dt)^2/12 2 w t 2, speed 1e-10 a step
    for (auto const& [turn, steps] : {std::pair{0.01, 100}, std::pair{0.1, 10}, std::pair{0.1, 100}}) {
        verification::Stopwatch const watch;
        lbm::Config c = turning({4, 4, 4}, 0.8, turn);
        c.set_periodic(2);
        lbm::Solver<3> solver(c);
        solver.set_state([](auto const&) {
            return lbm::PointState<3>{.velocity = {0.02, 0, 0}, .pressure = 0, .gradient = {}};
        });
        for (int k = 0; k < steps; ++k) solver.step();
        lbm::Fields const f = solver.fields();
        double const angle = 2 * turn * steps, x = f.velocity[0] / 0.02, y = f.velocity[1] / 0.02;
        double const phase = std::abs(std::remainder(std::atan2(y, x) + angle, 2 * std::numbers::pi));
        double const mark = 4 * turn * turn / 12 * angle * 2;
        CHECK(verification::report({"R11", text("phase at w dt=%.2g after %.0f steps [rad]", turn, steps), phase, 0,
                                    phase, mark, watch.seconds()}));
        double const drift = std::abs(std::hypot(x, y) - 1) / steps;
        CHECK(verification::report({"R11", text("drift of the speed a step, w dt=%.2g, %.0f steps", turn, steps), drift,
                                    0, drift, 1e-10, watch.seconds()}));
    }
}

TEST_CASE("R12: Ekman layer, depth of 10 cells")
{
    verification::Stopwatch const watch;
    // closed form: (u, v) = U (1 - e^-z/d cos(z/d), e^-z/d sin(z/d)), d = sqrt(nu/w); mark 1.5 %
    double const rate = 1e-3, depth = 10, speed = 0.02, viscosity = rate * depth * depth;
    lbm::Config c = turning({2, 2, 80}, 0.5 + 3 * viscosity, rate);
    c.walls[lbm::upper_z].kind = lbm::Border::slip;
    c.acceleration = {0, 2 * rate * speed, 0};  // the gradient of pressure that the flow far from the wall needs
    lbm::Solver<3> solver(c);
    solver.set_state([&](auto const&) {
        return lbm::PointState<3>{.velocity = {speed, 0, 0}, .pressure = 0, .gradient = {}};
    });
    // the wall's start decays as a layer of sqrt(nu t) spreads: 2 w t = 60, H^2/(4 nu t) = 0.5
    for (int k = 0; k < 30000; ++k) solver.step();
    lbm::Fields const f = solver.fields();
    double sum = 0;
    for (std::size_t z = 0; z < 80; ++z) {
        double const s = (static_cast<double>(z) + 0.5) / depth;
        double const u = f.velocity[3 * 4 * z] / speed - (1 - std::exp(-s) * std::cos(s)),
                     v = f.velocity[3 * 4 * z + 1] / speed - std::exp(-s) * std::sin(s);
        sum += u * u + v * v;
    }
    double const rms = std::sqrt(sum / 80);
    CHECK(verification::report({"R12", "RMS of u and v over 8 depths / U", rms, 0, rms, 0.015, watch.seconds()}));
}
