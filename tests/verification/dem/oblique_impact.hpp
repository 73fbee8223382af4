#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "participants/dem/solver.hpp"
#include "tests/verification/dem/scenes.hpp"

//! The tables of D03, oblique impact of a sphere on a wall at v0 = 1 m/s: benchmark files D03a (alpha_n = 0.08, alpha_t
//! = 0.5) and D03b (undamped), converged solutions.
namespace scenes {

inline constexpr double mu = 0.5, stiffness = 1e6;

struct Rebound
{
    double vn, vt, spin;  // [m/s], [m/s], [rad/s]
};
struct Row
{
    double angle, vn, vt, spin, vt_sliding;  // degrees from the normal; the last: gross sliding
};
inline constexpr Row damped[] = {
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
inline constexpr Row undamped[] = {
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

//! A body of inertia factor I* that meets a wall at 1 m/s, `angle` off the normal [rad], `phase` of a step after its
//! start.
inline Rebound impact(double angle, double inertia_factor, double alpha_n, double alpha_t, double dt, double phase,
                      dem::Scheme scheme = dem::Scheme::predicted)
{
    dem::Setup<2> s =
        setup<2>({.stiffness = stiffness, .damping_ratio = alpha_n, .tangential_damping = alpha_t, .friction = mu});
    s.features.scheme = scheme;
    add_wall(s, {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    add_body(g, {0.0, sphere_radius + phase * dt * std::cos(angle)}, sphere_radius, sphere_mass, inertia_factor,
             {{std::sin(angle), -std::cos(angle)}, 0.0});
    dem::Solver<2> solver(s, g);
    solver.step(dt);
    while (solver.grains().place[0].centre.y < sphere_radius || solver.time() < 2.5 * dt) solver.step(dt);
    return {solver.grains().motion[0].velocity.y, solver.grains().motion[0].velocity.x, solver.grains().motion[0].spin};
}

//! Largest of |v' - v'_ref|/v0 for v_n, v_t and omega R, worst of 8 phases of the first touch in a step.
inline double error_of(Rebound const& reference, double angle, double inertia_factor, double alpha_n, double alpha_t,
                       double steps, dem::Scheme scheme = dem::Scheme::predicted)
{
    double const dt = std::numbers::pi * std::sqrt(sphere_mass / stiffness) / steps;
    double worst = 0.0;
    for (int k = 0; k < 8; ++k) {
        Rebound const r = impact(angle, inertia_factor, alpha_n, alpha_t, dt, (k + 0.5) / 8.0, scheme);
        worst = std::max({worst, std::abs(r.vn - reference.vn), std::abs(r.vt - reference.vt),
                          std::abs(r.spin - reference.spin) * sphere_radius});
    }
    return worst;
}

}  // namespace scenes
