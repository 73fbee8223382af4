#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "participants/dem/measures.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/dem/setup.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D07: energy and settling; targets of the benchmark file D07_energy_and_settling.csv.
namespace {

using namespace scenes;

dem::Config const bed_config = column(1000, 0.8);
dem::Packing<2> const& bed()
{
    static dem::Packing<2> const packing = dem::pour_packing<2>(bed_config);
    return packing;
}

}  // namespace

TEST_CASE("D07: a disc between two walls keeps its period and its energy")
{
    verification::Stopwatch watch;
    double const radius = 0.01, mass = 0.8, length = 0.1, v = 1.0;
    dem::Setup<2> s = setup<2>({.stiffness = 1e6});
    add_wall(s, {0.0, 0.0}, {1.0, 0.0});
    add_wall(s, {length, 0.0}, {-1.0, 0.0});
    dem::Grains<2> g;
    add_body(g, {0.5 * length, 0.0}, radius, mass, 0.5, {{v, 0.0}, 0.0});
    dem::Solver<2> solver(s, g);
    double const tc = dem::contact_time(1e6, 0.0, mass), dt = tc / 50.0, energy = 0.5 * mass * v * v;
    double const period = 2.0 * (length - 2.0 * radius) / v + 2.0 * tc;
    double before = solver.grains().place[0].centre.x, crossed = 0.0, spread = 0.0;
    int periods = 0;
    while (periods < 200) {
        solver.step(dt);
        double const now = solver.grains().place[0].centre.x;
        spread = std::max(spread, std::abs(solver.energies().held() / energy - 1.0));
        if (before < 0.5 * length && now >= 0.5 * length) {
            crossed = solver.time() - dt * (now - 0.5 * length) / (now - before);
            ++periods;
        }
        before = now;
    }
    double const drift = std::abs(solver.energies().held() / energy - 1.0);
    CHECK(verification::report({"D07", "period between two walls [s], t_c/50", crossed / periods, period,
                                std::abs(crossed / periods / period - 1.0), 1e-3, watch.seconds()}));
    CHECK(verification::report(
        {"D07", "largest energy error in 200 periods, t_c/50", 1.0 + spread, 1.0, spread, 2e-3, watch.seconds()}));
    CHECK(verification::report(
        {"D07", "energy after 200 periods, t_c/50", 1.0 + drift, 1.0, drift, 2e-3, watch.seconds()}));
}

TEST_CASE("D07: a settled bed rests on its walls")
{
    verification::Stopwatch watch;
    dem::Config config = bed_config;
    config.walls.back().removed_at = 1e9;  // the gate stays
    dem::Solver<2> solver = dem::make_solver<2>(config, bed());
    dem::Grains<2> const& g = solver.grains();
    double weight = 0.0, reaction = 0.0, kinetic = 0.0, walls = 0.0;
    for (double m : g.mass) weight += 9.81 * m;
    constexpr int steps = 5000;
    for (int n = 0; n < steps; ++n) {
        solver.step(config.step);
        for (auto const& load : g.contact) reaction += load.force.y / steps;
        if (n % 500 == 0) kinetic = std::max(kinetic, dem::measure(solver).kinetic);
    }
    for (std::size_t w = 0; w < config.walls.size(); ++w) walls += dem::wall_reaction(solver, w).y;
    CHECK(verification::report({"D07", "reaction of floor and sides / weight, mean", reaction / weight, 1.0,
                                std::abs(reaction / weight - 1.0), 1e-3, watch.seconds()}));
    CHECK(verification::report({"D07", "the same summed wall by wall, last step", walls / weight, 1.0,
                                std::abs(walls / weight - 1.0), 1e-3, watch.seconds()}));
    double const ratio = kinetic / (weight * 1.4e-3);
    CHECK(verification::report({"D07", "kinetic energy / m g d, largest", ratio, 0.0, ratio, 1e-8, watch.seconds()}));
}

TEST_CASE("D07: packing fraction and coordination of a poured column")
{
    verification::Stopwatch watch;
    dem::Solver<2> const solver = dem::make_solver<2>(bed_config, bed());
    dem::Measures<2> const m = dem::measure(solver);
    double const margin = 3.0 * 1.4e-3,
                 width = dem::column_width(bed_config);  // bulk: 3 d from walls, 4 d below the top
    double const fraction =
        dem::packing_fraction<2>(solver.grains(), {margin, margin}, {width - margin, m.height - margin - 1.4e-3});
    CHECK(verification::report({"D07", "packing fraction in the bulk (0.81 to 0.84)", fraction, 0.825,
                                std::abs(fraction - 0.825), 0.015, watch.seconds()}));
    CHECK(verification::report({"D07", "coordination without rattlers, walls counted (3.5 to 4.2)", m.coordination,
                                3.85, std::abs(m.coordination - 3.85), 0.35, watch.seconds()}));
    CHECK(verification::report({"D07", "rattlers / grains", static_cast<double>(m.rattlers) / 1000.0, 0.0,
                                static_cast<double>(m.rattlers) / 1000.0, 0.1, watch.seconds()}));
}
