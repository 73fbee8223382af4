#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "participants/dem/restitution.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! Hertz and Mindlin on single impacts, after the tests of Chung and Ooi, Granular Matter 13 (2011) 643: their
//! particles (glass, aluminium alloy), against closed forms. Elastic impact at relative speed v: largest overlap (15 m*
//! v^2 / (16 E* sqrt(R*)))^(2/5), largest force 4/3 E* sqrt(R*) xi^(3/2), duration 2.9432750 xi/v (Johnson, Contact
//! Mechanics (1985), sec. 11.4). Damped: e as for the linear law (Antypov and Elliott 2011). Oblique, gross sliding:
//! the impulses of rigid bodies.
namespace {

using namespace scenes;
using dem::Vec3;

struct Matter
{
    char const* name;
    double modulus, poisson, friction, radius, density;
};
constexpr Matter glass{"glass", 48e9, 0.2, 0.35, 0.010, 2800.0};
constexpr Matter aluminium{"aluminium", 70e9, 0.33, 0.092, 0.0025, 2699.0};

dem::Setup<3> setup_of(Matter const& m, double damping_ratio, bool friction)
{
    dem::ContactConfig c;
    c.elasticity = dem::Elasticity::hertz;
    c.youngs_modulus = m.modulus;
    c.poissons_ratio = m.poisson;
    c.damping_ratio = c.tangential_damping = damping_ratio;
    c.friction = friction ? m.friction : 0.0;
    dem::Setup<3> s;
    s.law = dem::contact_law(c);
    s.skin = 1e-3 * m.radius;
    s.features = {.elasticity = dem::Elasticity::hertz, .friction = friction, .ledger = true};
    return s;
}

struct Impact
{
    double overlap = 0.0, force = 0.0, duration = 0.0, kinetic = 0.0, gap = 0.0;
    Vec3 velocity, spin;  //!< relative, after
};

//! A pair (or a grain and a wall) meets at `velocity`, z along the line of centres; `steps` to the contact's time.
Impact meet(Matter const& m, bool wall, double damping_ratio, bool friction, Vec3 velocity, Vec3 spin, double time,
            double steps)
{
    dem::Setup<3> s = setup_of(m, damping_ratio, friction);
    dem::Grains<3> g;
    double const dt = time / steps, apart = 0.3 * dt * std::abs(velocity.z);
    if (wall) add_wall(s, {}, {0.0, 0.0, 1.0});
    g.add({0.0, 0.0, m.radius + apart}, m.radius, m.density, {wall ? velocity : 0.5 * velocity, spin});
    if (!wall) g.add({0.0, 0.0, -m.radius}, m.radius, m.density, {-0.5 * velocity, spin});
    dem::Solver<3> solver(s, g);
    Impact o;
    double const start = solver.energies().balance(), kinetic = solver.energies().kinetic();
    double touched = 0.0;
    for (int n = 0; n < 3 * steps; ++n) {
        solver.step(dt);
        auto const& place = solver.grains().place;
        double const overlap =
            wall ? m.radius - place[0].centre.z : 2.0 * m.radius - norm(place[0].centre - place[1].centre);
        double const force = norm(solver.grains().contact[0].force);
        o.overlap = std::max(o.overlap, overlap);
        o.force = std::max(o.force, force);
        touched += force > 0.0 ? dt : 0.0;
    }
    auto const& a = solver.grains().motion[0];
    o.velocity = wall ? a.velocity : a.velocity - solver.grains().motion[1].velocity;
    o.spin = a.spin;
    o.duration = touched;
    o.kinetic = solver.energies().kinetic() / kinetic;
    o.gap = std::abs(solver.energies().balance() - start) / kinetic;
    return o;
}

struct Closed
{
    double overlap, force, duration;
    Closed(Matter const& m, bool wall, double v)
    {
        double const mass = m.density * 4.0 / 3.0 * std::numbers::pi * std::pow(m.radius, 3) * (wall ? 1.0 : 0.5);
        double const radius = wall ? m.radius : 0.5 * m.radius;
        double const modulus = m.modulus / (2.0 * (1.0 - m.poisson * m.poisson));
        overlap = std::pow(15.0 * mass * v * v / (16.0 * modulus * std::sqrt(radius)), 0.4);
        force = 4.0 / 3.0 * modulus * std::sqrt(radius) * std::pow(overlap, 1.5);
        duration = 2.9432750 * overlap / v;
    }
};

void check(Matter const& m, bool wall, std::string const& what, double value, double reference, double mark,
           verification::Stopwatch const& watch)
{
    std::string const pair = wall ? " on a wall, " : " pair, ";
    CHECK(verification::report(
        {"Hertz", m.name + pair + what, value, reference, std::abs(value / reference - 1.0), mark, watch.seconds()}));
}

}  // namespace

TEST_CASE("Hertz: an elastic impact has the closed form's overlap, force and duration (Chung and Ooi 1, 2)")
{
    for (bool const wall : {false, true}) {
        auto const& m = wall ? aluminium : glass;
        double const v = wall ? 0.2 : 20.0;  // theirs: a pair at 10 m/s each, a grain on a wall at 0.2 m/s
        verification::Stopwatch watch;
        Closed const reference(m, wall, v);
        Impact const o = meet(m, wall, 0.0, false, {0.0, 0.0, -v}, {}, reference.duration, 200.0);
        check(m, wall, "largest overlap [m]", o.overlap, reference.overlap, 1e-3, watch);
        check(m, wall, "largest force [N]", o.force, reference.force, 1e-3, watch);
        check(m, wall, "duration [s]", o.duration, reference.duration, 1.0 / 200.0, watch);  // a step
        check(m, wall, "rebound", o.velocity.z, v, 1e-3, watch);
    }
}

TEST_CASE("Hertz: restitution is the closed form's, at every speed (Chung and Ooi 3)")
{
    for (double const alpha : {0.02, 0.1, 0.3, 0.6})
        for (double const v : {0.02, 0.2, 2.0}) {
            verification::Stopwatch watch;
            Closed const reference(aluminium, true, v);
            Impact const o = meet(aluminium, true, alpha, false, {0.0, 0.0, -v}, {}, reference.duration, 100.0);
            double const e = dem::restitution(alpha), error = std::abs(o.velocity.z / v - e);
            // as D01: 0.003 at t_c/50
            CHECK(verification::report({"Hertz",
                                        "e, alpha = " + std::to_string(alpha).substr(0, 4) +
                                            ", v = " + std::to_string(v).substr(0, 4) + " m/s",
                                        o.velocity.z / v, e, error, 0.003, watch.seconds()}));
        }
}

TEST_CASE("Hertz: an oblique impact that slides throughout has the impulses of rigid bodies (Chung and Ooi 4)")
{
    // sliding throughout: tan(angle) > 7 mu (1 + e)/2 here with e = 1
    for (double const degrees : {45.0, 60.0, 75.0, 85.0}) {
        double const v = 3.9, angle = degrees * std::numbers::pi / 180.0, mu = aluminium.friction;
        verification::Stopwatch watch;
        Closed const reference(aluminium, true, v * std::cos(angle));
        Impact const o = meet(aluminium, true, 0.0, true, {v * std::sin(angle), 0.0, -v * std::cos(angle)}, {},
                              reference.duration, 400.0);
        double const change = 2.0 * mu * v * std::cos(angle);
        auto const at = std::to_string(static_cast<int>(degrees)) + " degrees, ";
        check(aluminium, true, at + "tangential velocity", o.velocity.x, v * std::sin(angle) - change, 2e-3, watch);
        check(aluminium, true, at + "spin", o.spin.y, 2.5 * change / aluminium.radius, 5e-3, watch);
    }
}

TEST_CASE("Hertz: oblique impacts lose energy or keep it, and the ledger closes (Chung and Ooi 4 to 7)")
{
    double worst = 0.0, most = 0.0, spread = 0.0;
    verification::Stopwatch watch;
    for (double const degrees : {2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 70.0})
        for (double const spin : {-200.0, 0.0, 200.0}) {
            double const v = 3.9, angle = degrees * std::numbers::pi / 180.0;
            Closed const reference(aluminium, true, v * std::cos(angle));
            auto const run = [&](double steps) {
                return meet(aluminium, true, 0.0, true, {v * std::sin(angle), 0.0, -v * std::cos(angle)},
                            {0.0, spin, 0.0}, reference.duration, steps);
            };
            Impact const o = run(100.0), fine = run(1000.0);
            most = std::max(most, fine.kinetic);
            worst = std::max(worst, o.gap);
            spread = std::max(
                {spread, norm(o.velocity - fine.velocity) / v, aluminium.radius * norm(o.spin - fine.spin) / v});
        }
    CHECK(verification::report({"Hertz", "largest kinetic energy after / before", most, 1.0, std::max(0.0, most - 1.0),
                                1e-5, watch.seconds()}));
    CHECK(verification::report(
        {"Hertz", "ledger's gap / kinetic energy, t_c/100", worst, 0.0, worst, 1e-3, watch.seconds()}));
    CHECK(verification::report(
        {"Hertz", "outcome at t_c/100 against t_c/1000, / v", spread, 0.0, spread, 0.005, watch.seconds()}));
}

TEST_CASE("Hertz: two spheres that spin alike part without a tangential force, counter-spinning ones keep the sum")
{
    verification::Stopwatch watch;
    // Chung and Ooi 7: spins that cancel at the contact make no friction
    Closed const reference(glass, false, 0.4);
    Impact const o = meet(glass, false, 0.0, true, {0.0, 0.0, -0.4}, {0.0, 0.0, 300.0}, reference.duration, 100.0);
    CHECK(o.spin == Vec3{0.0, 0.0, 300.0});  // about the line of centres: nothing rubs
    check(glass, false, "rebound with spin about the line of centres", o.velocity.z, 0.4, 1e-3, watch);
}
