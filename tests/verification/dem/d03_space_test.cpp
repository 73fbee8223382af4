#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "participants/dem/restitution.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/oblique_impact.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D01 to D03 in space: the same tables, with the impact in any direction. A sphere meets a tilted wall, or another
//! sphere; the tables are for a wall, so that in a pair the masses are doubled (m* = m), the two spins added, and the
//! speed is low.
namespace {

using namespace scenes;
using dem::Vec3;

//! Relative speed of a pair [m/s]: its line of centres turns by v t_c/D during the impact, which a wall's does not; at
//! 1 m/s by 0.01. The law is linear, so that outcomes scale with the speed.
constexpr double slow = 0.005;

//! A frame whose z is a contact's normal.
struct Frame
{
    Vec3 normal, forward, side;

    //! `tilt` and `turn` [rad]: of the normal; `azimuth` of the motion.
    Frame(double tilt, double turn, double azimuth)
        : normal{std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)}
    {
        Vec3 const a{std::cos(tilt) * std::cos(turn), std::cos(tilt) * std::sin(turn), -std::sin(tilt)};
        Vec3 const b = cross(normal, a);
        forward = std::cos(azimuth) * a + std::sin(azimuth) * b;
        side = cross(normal, forward);
    }
};

struct Outcome
{
    Rebound rebound;
    double off_plane;  //!< largest velocity out of the plane of impact [m/s]
};

Outcome impact_in_space(Frame const& f, bool pair, double angle, double alpha_n, double alpha_t, double dt,
                        double phase)
{
    dem::Setup<3> s =
        setup<3>({.stiffness = stiffness, .damping_ratio = alpha_n, .tangential_damping = alpha_t, .friction = mu});
    double const speed = pair ? slow : 1.0;
    double const gap = phase * dt * speed * std::cos(angle), mass = pair ? 2.0 * sphere_mass : sphere_mass;
    Vec3 const velocity = speed * (std::sin(angle) * f.forward - std::cos(angle) * f.normal);
    dem::Grains<3> g;
    if (pair) {
        add_body(g, (sphere_radius + 0.5 * gap) * f.normal, sphere_radius, mass, 0.4, {0.5 * velocity, {}});
        add_body(g, -(sphere_radius + 0.5 * gap) * f.normal, sphere_radius, mass, 0.4, {-0.5 * velocity, {}});
    } else {
        add_wall(s, {}, f.normal);
        add_body(g, (sphere_radius + gap) * f.normal, sphere_radius, mass, 0.4, {velocity, {}});
    }
    dem::Solver<3> solver(s, g);
    auto const distance = [&] {
        return pair ? 0.5 * norm(solver.grains().place[0].centre - solver.grains().place[1].centre)
                    : dot(solver.grains().place[0].centre, f.normal);
    };
    solver.step(dt);
    while (distance() < sphere_radius || solver.time() < 2.5 * dt) solver.step(dt);
    auto const& a = solver.grains().motion[0];
    auto const& b = pair ? solver.grains().motion[1] : dem::Motion<3>{};
    Vec3 const v = 1.0 / speed * (a.velocity - b.velocity), spin = 1.0 / speed * (a.spin + b.spin);
    // a spin along n x forward turns the surface backwards: the plane's is against it
    return {{dot(v, f.normal), dot(v, f.forward), -dot(spin, f.side)},
            std::max({std::abs(dot(v, f.side)), sphere_radius * std::abs(dot(spin, f.normal)),
                      sphere_radius * std::abs(dot(spin, f.forward))})};
}

void check(char const* what, bool pair, double degrees, Rebound const& reference, double alpha_n, double alpha_t)
{
    for (double const steps : {50.0, 500.0}) {
        verification::Stopwatch watch;
        double const dt = std::numbers::pi * std::sqrt(sphere_mass / stiffness) / steps;
        double worst = 0.0, off = 0.0;
        for (int k = 0; k < 8; ++k) {
            Frame const f(0.4 * k, 0.3 + k, 0.7 * k);
            auto const o =
                impact_in_space(f, pair, degrees * std::numbers::pi / 180.0, alpha_n, alpha_t, dt, (k + 0.5) / 8.0);
            worst = std::max({worst, std::abs(o.rebound.vn - reference.vn), std::abs(o.rebound.vt - reference.vt),
                              std::abs(o.rebound.spin - reference.spin) * sphere_radius});
            off = std::max(off, o.off_plane);
        }
        char metric[64];
        std::snprintf(metric, sizeof metric, "%s, %g degrees, v_t/v0, t_c/%g", what, degrees, steps);
        CHECK(verification::report(
            {"D03", metric, reference.vt + worst, reference.vt, worst, steps > 100.0 ? 5e-4 : 0.005, watch.seconds()}));
        CHECK(off < 1e-12);  // rounding: an impact stays in its plane
    }
}

}  // namespace

TEST_CASE("D03: oblique impact of a sphere in space, on a wall of any direction (tables D03a, D03b)")
{
    for (Row const& row : damped) check("space D03a", false, row.angle, {row.vn, row.vt, row.spin}, 0.08, 0.5);
    for (Row const& row : undamped) check("space D03b", false, row.angle, {row.vn, row.vt, row.spin}, 0.0, 0.0);
}

TEST_CASE("D03: oblique impact of two spheres in space, along any line (tables D03a, D03b)")
{
    for (Row const& row : damped) check("pair D03a", true, row.angle, {row.vn, row.vt, row.spin}, 0.08, 0.5);
    for (Row const& row : undamped) check("pair D03b", true, row.angle, {row.vn, row.vt, row.spin}, 0.0, 0.0);
}
