#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/verification/mpm/bars.hpp"

using namespace verification;

//! M01, M01b: axial vibration of a bar, modes 1 and 2 (Bardenhagen, J. Comput. Phys. 180 (2002) 383; files
//! M01_axial_bar_mode1.csv, M01b_axial_bar_mode2.csv). v = v0 sin(b x), closed form v0 cos(w t) sin(b x). Marks: RMS of
//! the centre's velocity over two periods 1 % of v0, mean energy of a period 2 %.
TEST_CASE("M01: axial vibration of a bar, modes 1 and 2")
{
    for (int mode : {1, 2})
        for (auto scheme : {mpm::Scheme::musl, mpm::Scheme::usl})
            for (auto const& [cells, points] : {std::pair{13, 1}, {13, 2}, {26, 1}, {26, 2}}) {
                double const length = 25, v0 = 0.1, b = (2 * mode - 1) * std::numbers::pi / (2 * length), rate = 10 * b;
                mpm::Config c = bar(length, cells, points);
                c.density = 1;
                c.scheme = scheme;
                c.law = mpm::LinearElastic{{100, 0}};
                auto solver = mpm::make_solver<2>(c);
                for (auto& p : solver.points()) {
                    p.velocity[0] = v0 * std::sin(b * p.place[0]);
                    p.slope(0, 0) = v0 * b * std::cos(b * p.place[0]);
                }
                Stopwatch const watch;
                auto const held = [&] {
                    auto const e = solver.energies();
                    return e.kinetic + e.elastic;
                };
                // velocities lag behind stresses by half a step: their sum swings by w dt/2 about its mean
                double const start = held(), dt = 0.1 * c.cell / 10, period = 2 * std::numbers::pi / rate;
                double squares = 0, energy[2] = {};
                int const steps = static_cast<int>(std::lround(period / dt));
                for (int k = 0; k < 2 * steps; ++k) {
                    solver.step(dt);
                    double const v = mean(solver.state(), [](auto const& p) { return p.velocity[0]; });
                    double const exact = v0 / (b * length) * std::cos(rate * solver.time());
                    squares += (v - exact) * (v - exact) / (v0 * v0);
                    energy[k / steps] += held() / start / steps;
                }
                double const drift = std::max(std::abs(energy[0] - 1), std::abs(energy[1] - 1));
                double const rms = std::sqrt(squares / (2 * steps));
                std::string const name = named("mode %.0f, %.0f cells, ", mode, cells) + std::to_string(points) +
                                         (scheme == mpm::Scheme::musl ? " points, musl" : " points, usl");
                char const* const id = mode == 1 ? "M01" : "M01b";
                CHECK(report({id, name + ": velocity", rms, 0, rms, 0.01, watch.seconds()}));
                CHECK(report({id, name + ": energy", drift, 0, drift, 0.02, watch.seconds()}));
            }
}

//! M02: a step of pressure at x = 0 runs along a bar, its fixed end doubles it (file M02_step_wave.csv). Marks: arrival
//! at L/2 2 %, plateaus 2 %, overshoot 30 %, momentum p t until the reflection.
TEST_CASE("M02: a step wave in a bar and its reflection")
{
    double const length = 1, modulus = 1e6, density = 1000, pressure = 100;
    double const speed = std::sqrt(modulus / density), h = length / 100;
    mpm::Config c = bar(length, 100, 2);
    c.density = density;
    c.law = mpm::LinearElastic{{modulus, 0}};
    c.bodies[0].low = {2 * h, 0, 0};  // away from the domain's left side
    c.bodies[0].high[0] = length + 2 * h;
    c.size[0] = length + 2 * h;  // its right side is the fixed end
    c.walls[1].place = c.size[0];
    c.walls.erase(c.walls.begin());
    auto setup = mpm::make_setup<2>(c);
    auto state = mpm::make_state<2>(c);
    for (std::size_t p = 0; p < state.points.size(); ++p)
        if (state.points[p].place[0] < 2.5 * h)
            setup.tractions.push_back({.point = p, .axis = 0, .side = -1, .stress = {pressure, 0}});
    REQUIRE(setup.tractions.size() == 2);
    mpm::Solver<2> solver(setup, state);
    Stopwatch const watch;
    double const dt = 0.2 * h / speed;
    auto const middle = [&](double from, double to, auto&& of) {  // over points by their x/L
        double sum = 0;
        int count = 0;
        for (auto const& p : solver.state().points) {
            double const x = (p.place[0] - 2 * h) / length;
            if (x < from || x > to) continue;
            sum += of(p);
            ++count;
        }
        return sum / count;
    };
    auto const stress = [](auto const& p) { return p.matter.stress(0, 0); };
    auto const velocity = [](auto const& p) { return p.velocity[0]; };
    double arrival = 0, before = 0, largest = 0;
    double const clear = 5 * h / length;
    auto const run_to = [&](double crossings) {
        while (solver.time() * speed / length < crossings - 1e-9) {
            solver.step(dt);
            double const now = -middle(0.5 - 0.51 * h, 0.5 + 0.51 * h, stress);
            if (arrival == 0 && now > pressure / 2)
                arrival = solver.time() - dt * (now - pressure / 2) / (now - before);
            before = now;
            largest = std::max(largest, now);
        }
    };
    auto const plateau = [&](char const* name, double value, double reference) {
        CHECK(report({"M02", name, value, reference, std::abs(value / reference - 1), 0.02, watch.seconds()}));
    };
    run_to(0.4);
    double momentum = 0;
    for (auto const& p : solver.state().points) momentum += p.mass * p.velocity[0];
    double const pushed = pressure * h * solver.time();
    CHECK(report({"M02", "momentum / p t, until the reflection", momentum / pushed, 1, std::abs(momentum / pushed - 1),
                  1e-10, watch.seconds()}));
    plateau("stress behind the front, t c/L = 0.4", middle(clear, 0.4 - clear, stress), -pressure);
    plateau("velocity behind the front, t c/L = 0.4", middle(clear, 0.4 - clear, velocity), pressure / density / speed);
    run_to(0.75);
    CHECK(report({"M02", "arrival at L/2, c t/L", arrival * speed / length, 0.5,
                  std::abs(arrival * speed / length / 0.5 - 1), 0.02, watch.seconds()}));
    plateau("stress, t c/L = 0.75", middle(clear, 0.75 - clear, stress), -pressure);
    CHECK(report({"M02", "overshoot at L/2", largest / pressure, 1, std::max(0.0, largest / pressure - 1), 0.3,
                  watch.seconds()}));
    run_to(1.4);
    plateau("stress before the reflected front, t c/L = 1.4", middle(clear, 0.6 - clear, stress), -pressure);
    plateau("stress behind it", middle(0.6 + clear, 1 - clear, stress), -2 * pressure);
    run_to(1.75);
    plateau("stress behind it, t c/L = 1.75", middle(0.25 + clear, 1 - clear, stress), -2 * pressure);
}
