#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "participants/dem/solver.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! Two discs that fall one behind the other draft, kiss and tumble (Fortes, Joseph and Lundgren, J. Fluid Mech. 177
//! (1987) 467): DEM and LBM, ten steps of the grains in one of the fluid, as `kinematics` and a `load` that lags.
namespace {

constexpr double radius = 1e-3, diameter = 2 * radius;                               // m
constexpr double density = 1010, fluid_density = 1000, gravity = 9.81, step = 3e-4;  // kg/m3, m/s2, s
constexpr int substeps = 10;

struct Pair
{
    double drafted = -1, kissed = -1, tumbled = -1;  //!< when it began [s]; < 0: never
    double overlap = 0;                              //!< largest, over d
    double impulse = 0;                              //!< largest error of a window's, over that of the weight
};

Pair fall(double cells)
{
    lbm::Config c;
    c.cell = diameter / cells;
    c.size = {0.02, 0.08};
    c.density = fluid_density;
    c.viscosity = 1e-6;
    c.step = step * 20 / cells;
    c.collision = lbm::Operator::trt;
    lbm::Solver<2> fluid(c);

    double const share = 1 - fluid_density / density;  // of the weight: the fluid is without gravity
    dem::Setup<2> setup = scenes::setup<2>({.stiffness = 1000, .damping_ratio = 0.2}, {0, -share * gravity});
    scenes::add_wall<2>(setup, {0, 0}, {0, 1});
    dem::Grains<2> grains;
    grains.add({0.01, 0.068}, radius, density);
    grains.add({0.00999, 0.072}, radius, density);
    dem::Solver<2> solid(setup, grains);

    Pair got;
    double const weight = share * gravity * (grains.mass[0] + grains.mass[1]);
    std::vector<double> position(4), velocity(4), spin(2), size(2, radius);
    while (fluid.time() < 6 && (got.tumbled < 0 || fluid.time() < got.tumbled + 0.5)) {
        dem::Grains<2>& g = solid.grains();
        for (std::size_t i = 0; i < 2; ++i) {
            position[2 * i] = g.place[i].centre.x, position[2 * i + 1] = g.place[i].centre.y;
            velocity[2 * i] = g.motion[i].velocity.x, velocity[2 * i + 1] = g.motion[i].velocity.y;
            spin[i] = g.motion[i].spin;
        }
        fluid.set_bodies({position, velocity, spin, size});
        fluid.step();
        double const before = g.mass[0] * velocity[1] + g.mass[1] * velocity[3];
        double pushed = -weight;
        for (std::size_t i = 0; i < 2; ++i) {
            g.external[i] = {{fluid.loads().force[2 * i], fluid.loads().force[2 * i + 1]}, fluid.loads().torque[i]};
            pushed += fluid.loads().force[2 * i + 1];
        }
        solid.steps(c.step / substeps, substeps);
        double const after = g.mass[0] * g.motion[0].velocity.y + g.mass[1] * g.motion[1].velocity.y;
        dem::Vec2 const apart = g.place[1].centre - g.place[0].centre;
        double const gap = std::hypot(apart.x, apart.y) / diameter - 1, now = fluid.time();
        got.impulse = std::max(got.impulse, std::abs(after - before - c.step * pushed) / (c.step * weight));
        got.overlap = std::max(got.overlap, -gap);
        // the upper one is 5 % faster
        if (got.drafted < 0 && now > 0.1 && g.motion[1].velocity.y < 1.05 * g.motion[0].velocity.y) got.drafted = now;
        if (got.kissed < 0 && gap < 0.1) got.kissed = now;
        if (got.tumbled < 0 && got.kissed > 0 && std::abs(apart.x) > std::abs(apart.y)) got.tumbled = now;
    }
    std::printf("C10   d = %.0f dx: drafting from %.3f s, kiss at %.3f s, tumbled at %.3f s\n", cells, got.drafted,
                got.kissed, got.tumbled);
    return got;
}

}  // namespace

TEST_CASE("C10: two discs draft, kiss and tumble, the load's impulse is the same over the grains' steps")
{
    verification::Stopwatch const watch;
    Pair const got = fall(20);
    CHECK(got.drafted > 0);
    CHECK(got.drafted < got.kissed);
    CHECK(got.kissed < got.tumbled);
    // marks: kiss before 3 s, overlap at most 1 % of d (the file's)
    CHECK(verification::report(
        {"C10", "kiss (gap 0.1 d) at [s], at most", got.kissed, 3, got.kissed, 3, watch.seconds()}));
    CHECK(verification::report({"C10", "largest overlap / d", got.overlap, 0, got.overlap, 0.01, watch.seconds()}));
    // rounding of ten steps
    CHECK(verification::report(
        {"C10", "impulse of a window, error / weight's", got.impulse, 0, got.impulse, 1e-9, watch.seconds()}));
}
