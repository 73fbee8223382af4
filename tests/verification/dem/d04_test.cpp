#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "participants/dem/restitution.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D04 to D06: rigid-body closed forms, benchmark file D04_rigid_dynamics.csv. Relative error; marks of the benchmark:
//! 1 %, 0.2 % for the acceleration on an incline, 1e-6 for the static overlap. Rolling friction is not part of this
//! solver.
namespace {

using namespace scenes;

constexpr double gravity = 9.81, radius = 0.01, stiffness = 1e8;
constexpr double disc_mass = 2650.0 * std::numbers::pi * radius * radius;

void check(std::string const& metric, double value, double reference, double mark, verification::Stopwatch const& watch)
{
    CHECK(verification::report(
        {"D04", metric, value, reference, std::abs(value / reference - 1.0), mark, watch.seconds()}));
}

//! One body resting on a floor under a gravity that is turned by `slope` [rad], so that it runs towards +x.
dem::Solver<2> on_floor(double friction, double inertia_factor, double speed, double slope = 0.0)
{
    dem::Setup<2> s =
        setup<2>({.stiffness = stiffness, .damping_ratio = 0.3, .tangential_damping = 0.3, .friction = friction},
                 {gravity * std::sin(slope), -gravity * std::cos(slope)});
    add_wall(s, {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    double const overlap = disc_mass * gravity * std::cos(slope) / stiffness;
    add_body(g, {0.0, radius - overlap}, radius, disc_mass, inertia_factor, {{speed, 0.0}, 0.0});
    return {s, g};
}

double const dt = dem::contact_time(stiffness, stiffness * 2.0 / 7.0, disc_mass) / 50.0;

void slide_to_roll(std::string const& body, double inertia_factor, double t_roll, double v_roll, double x_slide)
{
    verification::Stopwatch watch;
    dem::Solver<2> solver = on_floor(0.3, inertia_factor, 1.0);
    auto const& g = solver.grains();
    while (g.motion[0].velocity.x + radius * g.motion[0].spin > 0.0) solver.step(dt);
    check(body + " slide->roll, t_roll [s]", solver.time(), t_roll, 0.01, watch);
    check(body + " slide->roll, x_slide [m]", g.place[0].centre.x, x_slide, 0.01, watch);
    while (solver.time() < 1.3 * t_roll) solver.step(dt);
    check(body + " slide->roll, v_roll [m/s]", g.motion[0].velocity.x, v_roll, 0.01, watch);
    double const ratio = g.motion[0].velocity.x * g.motion[0].velocity.x +
                         inertia_factor * radius * radius * g.motion[0].spin * g.motion[0].spin;
    check(body + " slide->roll, kinetic ratio", ratio, v_roll, 0.01, watch);
}

void incline(std::string const& body, double inertia_factor, double degrees, double friction, double a,
             double spin_rate)
{
    verification::Stopwatch watch;
    dem::Solver<2> solver = on_floor(friction, inertia_factor, 0.0, degrees * std::numbers::pi / 180.0);
    auto const& g = solver.grains();
    while (solver.time() < 0.02) solver.step(dt);
    double const t = solver.time(), v = g.motion[0].velocity.x, w = g.motion[0].spin;
    while (solver.time() < 0.2) solver.step(dt);
    check(body + " on incline, acceleration [m/s2]", (g.motion[0].velocity.x - v) / (solver.time() - t), a, 0.002,
          watch);
    check(body + " on incline, turning [rad/s2]", std::abs(g.motion[0].spin - w) / (solver.time() - t), spin_rate,
          0.002, watch);
}

}  // namespace

TEST_CASE("D04: a sliding body comes to roll")
{
    slide_to_roll("disc", 0.5, 0.1132631102, 0.6666666667, 0.09438592517);
    slide_to_roll("sphere", 0.4, 0.09708266589, 0.7142857143, 0.08321371362);
}

TEST_CASE("D04: a body rolls or slips down an incline")
{
    incline("disc, 20 degrees, mu = 0.6,", 0.5, 20.0, 0.6, 2.236811737, 223.6811737);
    incline("disc, 35 degrees, mu = 0.1,", 0.5, 35.0, 0.1, 4.823196685, 160.7176311);
    incline("sphere, 20 degrees, mu = 0.6,", 0.4, 20.0, 0.6, 2.396584004, 239.6584004);
    incline("sphere, 35 degrees, mu = 0.1,", 0.4, 35.0, 0.1, 4.823196685, 200.8970389);
}

TEST_CASE("D04: a bouncing body loses e^2 of its height at each bounce")
{
    verification::Stopwatch watch;
    dem::Setup<2> s = setup<2>({.stiffness = stiffness, .damping_ratio = dem::damping_ratio_for(0.8)}, {0.0, -gravity});
    add_wall(s, {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    add_body(g, {0.0, 0.5 + radius}, radius, disc_mass, 0.5);
    dem::Solver<2> solver(s, g);
    double apex = 0.0, speed = 0.0;
    for (int n = 0; n < 4;) {
        solver.step(dt);
        double const now = solver.grains().motion[0].velocity.y;
        if (speed > 0.0 && now <= 0.0) {
            apex = solver.grains().place[0].centre.y - radius;
            ++n;
            if (n == 1) check("bounce e = 0.8, apex 1 [m]", apex, 0.32, 0.01, watch);
            if (n == 3) check("bounce e = 0.8, apex 3 [m]", apex, 0.131072, 0.01, watch);
        }
        speed = now;
    }
}

TEST_CASE("D04: static overlap under a stack of six")
{
    for (double factor : {1.0, 15.0}) {
        verification::Stopwatch watch;
        dem::Setup<2> s = setup<2>({.stiffness = 1e6, .damping_ratio = 0.5}, {0.0, -gravity * factor});
        add_wall(s, {0.0, 0.0}, {0.0, 1.0});
        dem::Grains<2> g;
        for (int n = 0; n < 6; ++n) add_body(g, {0.0, (2 * n + 1) * sphere_radius}, sphere_radius, sphere_mass, 0.4);
        dem::Solver<2> solver(s, g);
        double const step = dem::contact_time(1e6, 0.0, 0.5 * sphere_mass) / 50.0;
        for (int n = 0; n < 40000; ++n) solver.step(step);
        check("overlap at the floor of 6 grains, N = " + std::to_string(static_cast<int>(factor)) + " [m]",
              sphere_radius - solver.grains().place[0].centre.y, factor > 1.0 ? 6.272287751e-07 : 4.181525167e-08, 1e-6,
              watch);
    }
}
