#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "participants/mpm/measures.hpp"
#include "tests/support/turning.hpp"
#include "tests/verification/mpm/bars.hpp"

//! R01, R05, R06 and a column's stress in a frame that turns. Space: w e_y, motion in (x, z); in the plane the axis
//! points out of (x, y), so that the same motion has the other sign of w. Velocities are those of a time, places run
//! half a step ahead of them, as in every leapfrog: a run starts with places of dt/2, and ends with them.
using namespace verification;

namespace {

//! A block of 1 m that hangs together, at rest in space but for a velocity: in the frame it turns back by w.
template <int D>
mpm::Solver<D> free_block(sluice::Rotation const& turning, mpm::Vec<D> const& at, mpm::Vec<D> const& velocity,
                          double dt, double room)
{
    mpm::Config c;
    c.dimension = D;
    c.cell = 0.25;
    c.density = 1000;
    c.law = mpm::LinearElastic{{1e6, 0.3}};
    c.rotation = turning;
    mpm::BodyConfig body;
    double const half = 2 * c.cell;
    for (std::size_t k = 0; k < D; ++k) {
        bool const deep = D == 3 && k == 1;
        double const centre = at[static_cast<int>(k)];
        c.origin[k] = deep ? -1 : -room;
        c.size[k] = deep ? 2 : 2 * room;
        body.low[k] = centre - half, body.high[k] = centre + half;
    }
    c.bodies.push_back(body);
    auto solver = mpm::make_solver<D>(c);
    double const w = turning.coriolis ? turning.rate : 0;
    mpm::Vec<D> const lattice = mpm::centre_of_mass(solver.state());  // points are laid out by the grid
    for (auto& p : solver.points()) {
        mpm::Vec<D> const r = p.place - lattice;
        p.place = at + r;
        p.slope.setZero();
        p.slope(0, D - 1) = D == 2 ? w : -w, p.slope(D - 1, 0) = D == 2 ? -w : w;
        p.velocity = velocity + p.slope * r;
        p.place += 0.5 * dt * p.velocity;
    }
    solver.restore(solver.state());
    return solver;
}

template <int D>
mpm::Vec<D> speed(mpm::Solver<D> const& solver)
{
    mpm::Vec<D> sum = mpm::Vec<D>::Zero();
    double mass = 0;
    for (auto const& p : solver.state().points) sum += p.mass * p.velocity, mass += p.mass;
    return sum / mass;
}

template <int D>
double error_of_path(Path const& p, double end, double w_dt)
{
    double const dt = end / std::round(end * p.w / w_dt);
    auto solver = free_block<D>(rotation<D>(p.w, 0), in_plane<mpm::Vec<D>>(p.x0, p.z0),
                                in_plane<mpm::Vec<D>>(p.vx0, p.vz0), dt, 15);
    run(solver, end, dt);
    auto const [x, z] = p.place(end + 0.5 * dt);
    return (mpm::centre_of_mass(solver.state()) - in_plane<mpm::Vec<D>>(x, z)).norm() / std::hypot(x, z);
}

//! Marks of the file: 1e-4 at w dt = 1e-3, order 2.
template <int D>
void straight_lines(std::string const& body, double end)
{
    for (Path const& p : {Path{2, 0, 1, 0, 0}, Path{6, 0, 2, -0.5, 0.4}}) {
        Stopwatch const watch;
        double const error = error_of_path<D>(p, end, 1e-3), coarser = error_of_path<D>(p, end, 2e-3);
        auto const name = body + named(", w = %g: place at t = %g s", p.w, end);
        CHECK(report({"R01", name, error, 0, error, 1e-4, watch.seconds()}));
        double const order = std::log2(coarser / error);
        CHECK(report({"R01", name + ", order", order, 2, std::abs(2 - order), 0.1, watch.seconds()}));
    }
}

}  // namespace

TEST_CASE("R01: a free block, a straight line in space")
{
    straight_lines<2>("plane", 1);
    straight_lines<3>("space", 0.2);
}

TEST_CASE("R01: each part alone")
{
    Stopwatch const watch;
    double const w = 3.0, dt = 1e-3 / w, pi = std::numbers::pi;
    auto outward = free_block<2>(rotation<2>(w, 0, {.coriolis = false}), {0.2, 1}, {-0.3, 0.5}, dt, 6);
    run(outward, 2.0 / w, dt);
    double const t = 2.0 + 0.5e-3, grown = std::cosh(t), pushed = std::sinh(t) / w;
    mpm::Vec<2> const expected(0.2 * grown - 0.3 * pushed, grown + 0.5 * pushed);
    double const error = (mpm::centre_of_mass(outward.state()) - expected).norm() / expected.norm();
    CHECK(report({"R01", "centrifugal alone: cosh, sinh", error, 0, error, 1e-4, watch.seconds()}));
    auto circling = free_block<2>(rotation<2>(w, 0, {.centrifugal = false}), {0, 0}, {0.3, 0.4}, dt, 6);
    auto const begin = mpm::centre_of_mass(circling.state());
    run(circling, 0.5 * pi / w, dt);
    double const across = (mpm::centre_of_mass(circling.state()) - begin).norm();
    CHECK(report({"R01", "Coriolis alone: diameter v/w", across, 0.5 / w, std::abs(across * w / 0.5 - 1), 1e-4,
                  watch.seconds()}));
    run(circling, 0.5 * pi / w, dt);
    double const gap = (mpm::centre_of_mass(circling.state()) - begin).norm() * w / 0.5;
    CHECK(report({"R01", "Coriolis alone: closed after pi/w", gap, 0, gap, 1e-4, watch.seconds()}));
    // rounding of a step: the turn's sine and cosine, and the sums over some hundred points
    double const kept = speed(circling).norm();
    CHECK(report({"R05", "Coriolis alone: speed after a circle", kept, 0.5, std::abs(kept / 0.5 - 1),
                  1000 * pi * 100 * 0x1p-53, watch.seconds()}));
}

//! Points with velocities of their own, which the grid does not see: Coriolis does no work on them either. Energies
//! against the same run without a frame, in which nothing but the transfer and the stress act.
TEST_CASE("R05: Coriolis does no work on a body that shakes")
{
    Stopwatch const watch;
    auto const left = [](double rate) {
        mpm::Config c;
        c.cell = 0.1;
        c.size = {4, 4, 0};
        c.density = 1000;
        c.flip = 1;
        c.affine = false;
        c.law = mpm::LinearElastic{{1e-3, 0}};  // nothing but motion
        c.rotation = sluice::Rotation{{2, 2, 0}, {0, 0, 1}, rate, 0, false, true, false};
        c.bodies.push_back({.low = {1.5, 1.5, 0}, .high = {2.5, 2.5, 0}});
        auto solver = mpm::make_solver<2>(c);
        int k = 0;
        for (auto& p : solver.points()) p.velocity = {k % 2 ? 0.1 : -0.1, k % 3 ? 0.05 : -0.1}, ++k;
        double const first = solver.energies().kinetic;
        for (int step = 0; step < 500; ++step) solver.step(1e-3);
        return solver.energies().kinetic / first;
    };
    double const still = left(0), turned = left(3);
    CHECK(report({"R05", "kinetic energy kept by a shaking body, w = 3/s by w = 0", turned, still,
                  std::abs(turned - still), 1e-5, watch.seconds()}));
}

//! R06: at the edge of a model L = 0.8 m wide with its base Rc = 2 m below the axis the pull has a part across of
//! (L/2)/Rc = 20 % of w^2 Rc. A block dropped there starts with it.
TEST_CASE("R06: the horizontal part of the pull")
{
    Stopwatch const watch;
    double const Rc = 2, w = std::sqrt(15 * 9.81 / Rc), dt = 1e-4;
    auto const share = [&]<int D>() {
        auto solver = free_block<D>(rotation<D>(w, Rc, {.coriolis = false}), in_plane<mpm::Vec<D>>(0.4, 0),
                                    in_plane<mpm::Vec<D>>(0, 0), dt, 3);
        solver.step(dt);
        return speed(solver)[0] / dt / (w * w * Rc);
    };
    double const plane = share.operator()<2>(), space = share.operator()<3>();
    CHECK(report(
        {"R06", "plane: part across at L/2 [w2 Rc]", plane, 0.2, std::abs(plane / 0.2 - 1), 1e-9, watch.seconds()}));
    CHECK(report(
        {"R06", "space: part across at L/2 [w2 Rc]", space, 0.2, std::abs(space / 0.2 - 1), 1e-9, watch.seconds()}));
}

namespace {

//! Largest error of the vertical stress of a column of 0.5 m in a centrifuge of radius 2 m, by that at its foot.
template <int D>
double stress_error(int cells, bool starts_with_it)
{
    double const height = 0.5, Rc = 2, w = std::sqrt(15 * 9.81 / Rc), density = 2000;
    mpm::Config c;
    c.dimension = D;
    c.cell = height / cells;
    c.density = density;
    c.law = mpm::LinearElastic{{1e8, 0.3}};
    c.damping = starts_with_it ? 0 : 400;  // 1/s; its slowest mode has 820
    c.rotation = rotation<D>(w, Rc);
    mpm::BodyConfig body;
    for (std::size_t k = 0; k < D; ++k) {
        bool const up = k + 1 == D;
        c.size[k] = (up ? cells + 2 : 1) * c.cell;
        body.high[k] = up ? height : c.cell;
        for (int side : {-1, 1})
            c.walls.push_back({.axis = static_cast<int>(k), .side = side, .place = side < 0 ? 0 : c.size[k]});
    }
    c.bodies.push_back(body);
    if (starts_with_it) c.geostatic = mpm::GeostaticConfig{.surface = height, .k0 = 0.3 / 0.7};
    auto solver = mpm::make_solver<D>(c);
    auto const exact = [&](double y) {
        return -0.5 * density * w * w * (std::pow(Rc - y, 2) - std::pow(Rc - height, 2));
    };
    double const foot = -exact(0);
    while (solver.time() < 0.05) solver.step(solver.longest_step());
    double worst = 0;
    for (auto const& p : solver.state().points)
        worst = std::max(worst, std::abs(p.matter.stress(D - 1, D - 1) - exact(p.place[D - 1])) / foot);
    return worst;
}

}  // namespace

//! A column in the field of a centrifuge, whose pull grows with the depth: closed form -rho w^2 [(Rc - y)^2 - (Rc -
//! H)^2]/2. Under a uniform N g it would be 14 % more at the foot. Mark: both points of a cell have its one stress,
//! hence that of a quarter of a cell further off, at the foot 8/7 of the mean pull; and the column is 1e-3 shorter.
TEST_CASE("R06: stress of a column in a centrifuge")
{
    for (bool const starts : {false, true}) {
        Stopwatch const watch;
        std::string const name = starts ? "from its stress" : "from none, damped";
        double const plane = stress_error<2>(16, starts), finer = stress_error<2>(32, starts);
        double const space = stress_error<3>(16, starts), mark = 8.0 / 7 / 64 + 1e-3, half = 8.0 / 7 / 128 + 1e-3;
        CHECK(report({"R06", name + ", plane: stress, by that at the foot", plane, 0, plane, mark, watch.seconds()}));
        CHECK(report({"R06", name + ", plane, 32 cells", finer, 0, finer, half, watch.seconds()}));
        CHECK(report({"R06", name + ", space: stress, by that at the foot", space, 0, space, mark, watch.seconds()}));
    }
}
