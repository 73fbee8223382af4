#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <string>

#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/oblique_impact.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D03: oblique impact of one body on a wall; mu = 0.5, kt = 2/7 kn, v0 = 1 m/s. The sphere rows are the converged
//! solutions of the benchmark files D03a (alpha_n = 0.08, alpha_t = 0.5) and D03b (undamped), run with I* = 2/5; the
//! disc rows (I* = 1/2) are integrated here, same model, 40000 midpoint steps a contact. Norm: the largest of |v' -
//! v'_ref|/v0 for v_n, v_t and omega R, worst of 8 phases of the first touch in a step. Marks of the benchmark: 0.005
//! at dt = t_c/50, 5e-4 at t_c/500.
namespace {

using namespace scenes;

//! The benchmark's model as an ordinary differential equation, midpoint rule. s = v_t + omega R; z follows s, and is
//! set back so that spring + dashpot is the limit.
Rebound converged(double angle, double inertia_factor, double alpha_n, double alpha_t)
{
    double const kt = stiffness * 2.0 / 7.0, m = sphere_mass, radius = sphere_radius;
    double const cn = 2.0 * alpha_n * std::sqrt(stiffness * m), ct = 2.0 * alpha_t * std::sqrt(kt * m);
    double const dt = std::numbers::pi * std::sqrt(m / stiffness) / 40000.0;
    double vn = -std::cos(angle), vt = std::sin(angle), spin = 0.0, overlap = 0.0, z = 0.0;
    auto forces = [&](double xi, double rate, double slip, double& spring) {
        double const normal = std::max(0.0, stiffness * xi + cn * rate), trial = kt * spring + ct * slip;
        double const tangential = std::clamp(trial, -mu * normal, mu * normal);
        if (tangential != trial) spring = (tangential - ct * slip) / kt;
        return std::pair(normal, tangential);
    };
    do {
        double spring = z;
        auto const [n0, t0] = forces(overlap, -vn, vt + spin * radius, spring);
        double const half = 0.5 * dt, vn_mid = vn + half * n0 / m, vt_mid = vt - half * t0 / m;
        double const spin_mid = spin - half * t0 / (inertia_factor * m * radius);
        double spring_mid = spring + half * (vt + spin * radius);
        auto const [n1, t1] = forces(overlap - half * vn, -vn_mid, vt_mid + spin_mid * radius, spring_mid);
        overlap -= dt * vn_mid;
        z = spring + dt * (vt_mid + spin_mid * radius);
        vn += dt * n1 / m;
        vt -= dt * t1 / m;
        spin -= dt * t1 / (inertia_factor * m * radius);
        forces(overlap, -vn, vt + spin * radius, z);
    } while (overlap > 0.0);
    return {vn, vt, spin};
}

void check(char const* what, double angle, Rebound const& reference, double inertia_factor, double alpha_n,
           double alpha_t)
{
    for (double steps : {50.0, 500.0}) {
        verification::Stopwatch watch;
        double const error =
            error_of(reference, angle * std::numbers::pi / 180.0, inertia_factor, alpha_n, alpha_t, steps);
        char metric[64];
        std::snprintf(metric, sizeof metric, "%s, %g degrees, v_t/v0, t_c/%g", what, angle, steps);
        CHECK(verification::report(
            {"D03", metric, reference.vt + error, reference.vt, error, steps > 100.0 ? 5e-4 : 0.005, watch.seconds()}));
    }
}

}  // namespace

TEST_CASE("D03: oblique impact of a sphere, damped (table D03a)")
{
    for (Row const& row : damped) check("sphere D03a", row.angle, {row.vn, row.vt, row.spin}, 0.4, 0.08, 0.5);
}

TEST_CASE("D03: oblique impact of a sphere, undamped (table D03b)")
{
    for (Row const& row : undamped) check("sphere D03b", row.angle, {row.vn, row.vt, row.spin}, 0.4, 0.0, 0.0);
}

TEST_CASE("D03: oblique impact of a disc against the converged equation")
{
    for (Row const& row : damped) {
        double const angle = row.angle * std::numbers::pi / 180.0;
        check("disc damped", row.angle, converged(angle, 0.5, 0.08, 0.5), 0.5, 0.08, 0.5);
        check("disc undamped", row.angle, converged(angle, 0.5, 0.0, 0.0), 0.5, 0.0, 0.0);
    }
}

TEST_CASE("D03: the equation integrated here reproduces the table of spheres")
{
    for (Row const& row : damped) {
        Rebound const r = converged(row.angle * std::numbers::pi / 180.0, 0.4, 0.08, 0.5);
        CHECK(std::abs(r.vn - row.vn) < 2e-6);
        CHECK(std::abs(r.vt - row.vt) < 2e-5);
        CHECK(std::abs(r.spin - row.spin) * sphere_radius < 2e-5);
    }
}

TEST_CASE("D03: a disc that slides throughout turns by 2 mu (1 + e) v_n / R")
{
    verification::Stopwatch watch;
    double const angle = 85.0 * std::numbers::pi / 180.0, e = 0.7871939281;
    double const dt = std::numbers::pi * std::sqrt(sphere_mass / stiffness) / 50.0;
    Rebound const r = impact(angle, 0.5, 0.08, 0.5, dt, 0.5);
    double const change = mu * (1.0 + e) * std::cos(angle);  // Delta v_t [m/s]
    double const spin = -2.0 * change / sphere_radius;
    CHECK(verification::report({"D03", "disc sliding, omega [rad/s], t_c/50", r.spin, spin,
                                std::abs(r.spin - spin) * sphere_radius, 0.005, watch.seconds()}));
    double const vt = std::sin(angle) - change;
    CHECK(verification::report(
        {"D03", "disc sliding, v_t [m/s], t_c/50", r.vt, vt, std::abs(r.vt - vt), 0.005, watch.seconds()}));
}
