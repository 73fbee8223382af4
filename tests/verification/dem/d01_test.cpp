#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "participants/dem/restitution.hpp"
#include "participants/dem/solver.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! D01: normal collision, linear spring and dashpot, force clamped at >= 0. Closed form of the benchmark file
//! D01_normal_collision.csv, columns e_clamped and tc_clamped_s (time from touch to zero force). Mark of the
//! benchmark: |e - e_ref| <= 0.003 at dt = t_c/50. Worst of 16 phases of the first touch within a step.
namespace {

using namespace scenes;

struct Row
{
    double alpha, e, tc_wall, tc_pair;
};
constexpr Row table[] = {
    {0.0, 1.0, 8.373501478e-05, 5.920959677e-05},
    {0.02, 0.9398413357, 8.268533509e-05, 5.846736115e-05},
    {0.05, 0.8587581018, 8.117006072e-05, 5.739590037e-05},
    {0.08, 0.7871939281, 7.972138135e-05, 5.637152936e-05},
    {0.0829086, 0.7807081649, 7.9584293e-05, 5.627459326e-05},
    {0.1, 0.7440793977, 7.87902947e-05, 5.571315167e-05},
    {0.2, 0.5717400276, 7.45064912e-05, 5.268404517e-05},
    {0.5, 0.2984360592, 6.445924443e-05, 4.557956885e-05},
};

struct Outcome
{
    double restitution, contact_time;  // [-], [s]
};

//! One collision at relative speed v; the first touch is `phase` of a step after a full step.
Outcome collide(bool pair, double alpha, double dt, double v, double phase)
{
    dem::Setup<2> s = setup<2>({.damping_ratio = alpha});
    dem::Grains<2> g;
    double const gap = phase * dt * v;
    if (pair) {
        add_body(g, {0.0, 0.0}, sphere_radius, sphere_mass, 0.4, {{0.5 * v, 0.0}, 0.0});
        add_body(g, {2.0 * sphere_radius + gap, 0.0}, sphere_radius, sphere_mass, 0.4, {{-0.5 * v, 0.0}, 0.0});
    } else {
        add_wall(s, {0.0, 0.0}, {1.0, 0.0});
        add_body(g, {sphere_radius + gap, 0.0}, sphere_radius, sphere_mass, 0.4, {{-v, 0.0}, 0.0});
    }
    dem::Solver<2> solver(s, g);
    double before = 0.0, force = 0.0, release = 0.0;
    bool touched = false;
    for (int n = 0; n < 4000 && release == 0.0; ++n) {
        solver.step(dt);
        double const last = before;
        before = force;
        force = std::abs(solver.grains().contact[0].force.x);
        touched = touched || force > 0.0;
        if (touched && force == 0.0)  // the line through the last two positive forces meets zero
            release = solver.time() - dt + dt * before / std::max(last - before, 1e-300) - phase * dt;
    }
    auto const vx = [&](std::size_t i) { return solver.grains().motion[i].velocity.x; };
    return {pair ? (vx(1) - vx(0)) / v : vx(0) / v, release};
}

struct Errors
{
    double restitution = 0.0, contact_time = 0.0, value = 0.0, mean_square = 0.0;
};

Errors worst(bool pair, Row const& row, double steps_per_contact, double v)
{
    double const reduced = pair ? 0.5 * sphere_mass : sphere_mass;
    double const dt = dem::contact_time(1e6, 0.0, reduced) / steps_per_contact, tc = pair ? row.tc_pair : row.tc_wall;
    Errors errors;
    constexpr int phases = 16;
    for (int k = 0; k < phases; ++k) {
        Outcome const o = collide(pair, row.alpha, dt, v, (k + 0.5) / phases);
        double const error = std::abs(o.restitution - row.e);
        if (error >= errors.restitution) errors.restitution = error, errors.value = o.restitution;
        errors.contact_time = std::max(errors.contact_time, std::abs(o.contact_time - tc) / tc);
        errors.mean_square += error * error / phases;
    }
    return errors;
}

std::string name(char const* what, bool pair, double alpha)
{
    char text[64];
    std::snprintf(text, sizeof text, "%s, %s, alpha = %.5g, t_c/50", what, pair ? "pair" : "wall", alpha);
    return text;
}

}  // namespace

TEST_CASE("D01: restitution and contact time of the clamped spring-dashpot")
{
    for (bool pair : {false, true})
        for (Row const& row : table) {
            verification::Stopwatch watch;
            Errors const e = worst(pair, row, 50.0, 0.1);
            CHECK(verification::report(
                {"D01", name("e", pair, row.alpha), e.value, row.e, e.restitution, 0.003, watch.seconds()}));
            double const tc = pair ? row.tc_pair : row.tc_wall;  // mark: half a step
            CHECK(verification::report({"D01", name("t_c [s]", pair, row.alpha), tc * (1.0 + e.contact_time), tc,
                                        e.contact_time, 0.01, watch.seconds()}));
            CHECK(dem::restitution(row.alpha) == close_to(row.e).epsilon(1e-8));
            CHECK(dem::release_time(row.alpha, 1e6, pair ? 0.5 * sphere_mass : sphere_mass) ==
                  close_to(tc).epsilon(1e-8));
        }
}

TEST_CASE("D01: restitution does not depend on the speed")
{
    verification::Stopwatch watch;
    double const dt = dem::contact_time(1e6, 0.0, sphere_mass) / 50.0;
    double const slow = collide(false, 0.08, dt, 0.1, 0.5).restitution,
                 fast = collide(false, 0.08, dt, 1.0, 0.5).restitution;
    CHECK(verification::report(
        {"D01", "e at 1 m/s against 0.1 m/s", fast, slow, std::abs(fast - slow), 1e-9, watch.seconds()}));
}

TEST_CASE("D01: the error of the restitution falls with the square of the step")
{
    verification::Stopwatch watch;
    Row const& row = table[6];  // alpha = 0.2
    std::vector<double> errors;
    for (double steps : {10.0, 20.0, 50.0, 100.0, 200.0}) {
        errors.push_back(std::sqrt(worst(true, row, steps, 0.1).mean_square));
        std::printf("D01   alpha = 0.2, pair: rms |de| = %.3e at t_c/%g\n", errors.back(), steps);
    }
    double const order = std::log(errors.front() / errors.back()) / std::log(20.0);
    CHECK(verification::report({"D01", "order of e in dt, t_c/10 to t_c/200 (>= 1.7)", order, 2.0,
                                std::max(0.0, 2.0 - order), 0.3, watch.seconds()}));
}
