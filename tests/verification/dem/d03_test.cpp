#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <string>

#include "participants/dem/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D03: oblique impact of one body on a wall; mu = 0.5, kt = 2/7 kn, v0 = 1 m/s. The sphere rows are the converged
//! solutions of the benchmark files D03a (alpha_n = 0.08, alpha_t = 0.5) and D03b (undamped), run with I* = 2/5; the
//! disc rows (I* = 1/2) are integrated here, same model, 40000 midpoint steps a contact. Norm: the largest of |v' -
//! v'_ref|/v0 for v_n, v_t and omega R, worst of 8 phases of the first touch in a step. Marks of the benchmark: 0.005
//! at dt = t_c/50, 5e-4 at t_c/500.
namespace {

using namespace scenes;

constexpr double mu = 0.5, stiffness = 1e6;

struct Rebound
{
    double vn, vt, spin;  // [m/s], [m/s], [rad/s]
};
struct Row
{
    double angle, vn, vt, spin, vt_sliding;  // degrees from the normal; the last: gross sliding
};
constexpr Row damped[] = {
    {2, 0.7867143904, 0.02382567345, -6.92113953, -0.858153112},
    {5, 0.7841984171, 0.05949917106, -17.28535731, -0.8030408148},
    {10, 0.7752346831, 0.1206525573, -33.12226275, -0.7063730404},
    {20, 0.7397203249, 0.2497152131, -57.69058138, -0.4976863295},
    {30, 0.681729939, 0.3713672849, -80.39544691, -0.2738776714},
    {40, 0.6030255339, 0.4819808137, -100.5042475, -0.04174737883},
    {50, 0.5059985031, 0.578333959, -117.3190525, 0.1916513867},
    {60, 0.3935969638, 0.6578543138, -130.1069313, 0.4192269219},
    {70, 0.26923618, 0.7203435081, -137.0931954, 0.6340644591},
    {80, 0.136694791, 0.8296384572, -96.9808099, 0.8296362687},
};
constexpr Row undamped[] = {
    {2, 0.9993908268, 0.01495692716, -12.46410596, -0.9644913302},
    {5, 0.9961946979, 0.03735246118, -31.12705098, -0.9090389552},
    {10, 0.9848077528, 0.07442064758, -62.0172063, -0.8111595753},
    {20, 0.9396926206, 0.1465800614, -122.1500512, -0.5976724774},
    {30, 0.8660254036, 0.2142857143, -178.5714286, -0.3660254037},
    {40, 0.766044443, 0.2754804042, -229.5670034, -0.1232568334},
    {50, 0.6427876096, 0.3283047614, -273.5873011, 0.1232568335},
    {60, 0.4999999999, 0.3711537445, -309.294787, 0.3660254038},
    {70, 0.3420201433, 0.5976734366, -213.7619901, 0.5976724775},
    {80, 0.1736481776, 0.8111595754, -108.530111, 0.8111595754},
};

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

Rebound impact(double angle, double inertia_factor, double alpha_n, double alpha_t, double dt, double phase)
{
    dem::Setup s =
        setup({.stiffness = stiffness, .damping_ratio = alpha_n, .tangential_damping = alpha_t, .friction = mu});
    add_wall(s, {0.0, 0.0}, {0.0, 1.0});
    dem::Grains g;
    add_body(g, {0.0, sphere_radius + phase * dt * std::cos(angle)}, sphere_radius, sphere_mass, inertia_factor,
             {std::sin(angle), -std::cos(angle)});
    dem::Solver solver(s, g);
    solver.step(dt);
    while (solver.grains().y[0] < sphere_radius || solver.time() < 2.5 * dt) solver.step(dt);
    return {solver.grains().vy[0], solver.grains().vx[0], solver.grains().spin[0]};
}

//! Worst error over 8 phases.
double error_of(Rebound const& reference, double angle, double inertia_factor, double alpha_n, double alpha_t,
                double steps)
{
    double const dt = std::numbers::pi * std::sqrt(sphere_mass / stiffness) / steps;
    double worst = 0.0;
    for (int k = 0; k < 8; ++k) {
        Rebound const r = impact(angle, inertia_factor, alpha_n, alpha_t, dt, (k + 0.5) / 8.0);
        worst = std::max({worst, std::abs(r.vn - reference.vn), std::abs(r.vt - reference.vt),
                          std::abs(r.spin - reference.spin) * sphere_radius});
    }
    return worst;
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
