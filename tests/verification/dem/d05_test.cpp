#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "participants/dem/restitution.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D05: a body that rolls is stopped by the resistance to rolling, and stays. Closed forms of the benchmark file
//! D04_rigid_dynamics.csv: a = mu_r g/(1 + I*), distance v0^2/2a, time v0/a. Mark of the benchmark: 1 %.
namespace {

using namespace scenes;
using dem::Rolling;

constexpr double gravity = 9.81, radius = 0.01, stiffness = 1e7;

template <int D>
dem::Solver<D> rolling_on_floor(Rolling law, double azimuth, double speed, bool ledger)
{
    dem::ContactConfig contact;
    contact.normal_stiffness = stiffness;
    contact.tangential_stiffness = stiffness * 2.0 / 7.0;
    contact.damping_ratio = contact.tangential_damping = 0.3;
    contact.friction = 0.5;
    contact.rolling = law;
    contact.rolling_friction = 0.02;
    contact.rolling_stiffness = 1.0;
    contact.rolling_damping = 0.3;
    dem::Setup<D> s;
    s.law = dem::contact_law(contact);
    s.skin = 1e-3;
    s.features = {.friction = true, .rolling = law, .ledger = ledger};
    dem::Grains<D> g;
    dem::Motion<D> motion{};
    double const mass = 2650.0 * std::numbers::pi * radius * radius * (D == 2 ? 1.0 : 4.0 / 3.0 * radius);
    double const height = radius - mass * gravity / stiffness;
    if constexpr (D == 2) {
        s.gravity = {0.0, -gravity};
        add_wall<2>(s, {}, {0.0, 1.0});
        motion = {{speed, 0.0}, -speed / radius};
        g.add({0.0, height}, radius, 2650.0, motion);
    } else {
        s.gravity = {0.0, 0.0, -gravity};
        add_wall<3>(s, {}, {0.0, 0.0, 1.0});
        dem::Vec3 const forward{std::cos(azimuth), std::sin(azimuth), 0.0};
        motion.velocity = speed * forward;
        motion.spin = (speed / radius) * cross(dem::Vec3{0.0, 0.0, 1.0}, forward);
        g.add({0.0, 0.0, height}, radius, 2650.0, motion);
    }
    return dem::Solver<D>(s, g);
}

template <int D>
void stops(std::string const& body, Rolling law, double distance, double time)
{
    verification::Stopwatch watch;
    dem::Solver<D> solver = rolling_on_floor<D>(law, 0.7, 0.5, false);
    auto const& g = solver.grains();
    double const step = dem::contact_time(stiffness, stiffness * 2.0 / 7.0, g.mass[0], D) / 20.0;
    double stopped = 0.0;
    while (solver.time() < 1.2 * time) {
        solver.step(step);
        if (stopped == 0.0 && norm(g.motion[0].velocity) < 1e-4) stopped = solver.time();
    }
    double const path = D == 2 ? g.place[0].centre.x : std::hypot(g.place[0].centre.x, g.place[0].centre.y);
    auto const check = [&](std::string const& what, double value, double reference) {
        CHECK(verification::report(
            {"D05", body + what, value, reference, std::abs(value / reference - 1.0), 0.01, watch.seconds()}));
    };
    check(", stopping distance [m]", path, distance);
    check(", stopping time [s]", stopped, time);
    if (law == Rolling::constant) return;  // its torque has no rest: it turns over with every step
    auto const place = g.place[0].centre;
    double const rest = norm(g.motion[0].velocity);
    while (solver.time() < 2.0 * time) solver.step(step);
    double const crept = norm(g.place[0].centre - place) / (2.0 * radius);
    CHECK(verification::report({"D05", body + ", velocity at rest [m/s]", rest, 0.0, rest, 1e-9, watch.seconds()}));
    CHECK(verification::report({"D05", body + ", creep at rest / d", crept, 0.0, crept, 1e-9, watch.seconds()}));
}

}  // namespace

TEST_CASE("D05: the resistance to rolling stops a body in the closed form's distance, and it stays")
{
    stops<2>("disc, elastic-plastic", Rolling::elastic_plastic, 0.9556574924, 3.822629969);
    stops<3>("sphere, elastic-plastic", Rolling::elastic_plastic, 0.8919469929, 3.567787971);
    stops<2>("disc, constant", Rolling::constant, 0.9556574924, 3.822629969);
    stops<3>("sphere, constant", Rolling::constant, 0.8919469929, 3.567787971);
}

TEST_CASE("D05: what the resistance to rolling takes is in the ledger")
{
    for (Rolling const law : {Rolling::elastic_plastic, Rolling::constant}) {
        verification::Stopwatch watch;
        dem::Solver<3> solver = rolling_on_floor<3>(law, 0.7, 0.05, true);
        double const step = dem::contact_time(stiffness, stiffness * 2.0 / 7.0, solver.grains().mass[0], 3) / 50.0;
        double const kinetic = solver.energies().kinetic(), start = solver.energies().balance();
        while (solver.time() < 0.3) solver.step(step);
        auto const e = solver.energies();
        double const gap = std::abs(e.balance() - start) / kinetic, share = e.rolling / (kinetic - e.kinetic());
        CHECK(verification::report(
            {"D05", "ledger's gap / initial kinetic energy", gap, 0.0, gap, 1e-6, watch.seconds()}));
        // all but what friction takes while the grain is brought to the speed that rolls with resistance
        CHECK(verification::report({"D05", "share of the resistance in what is lost", share, 1.0, std::abs(share - 1.0),
                                    0.01, watch.seconds()}));
    }
}
