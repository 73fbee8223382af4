#include "participants/mpm/solver.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/participants/mpm/scenes.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

//! Of pure FLIP.
template <int D>
mpm::Config box(double size, std::array<double, 3> low, std::array<double, 3> high)
{
    mpm::Config c = unit::box<D>(size, low, high);
    c.flip = 1;
    return c;
}

//! Random velocities of 0.5 m/s: a body that shakes.
template <int D>
mpm::Solver<D> shaken(mpm::Config const& c)
{
    auto solver = mpm::make_solver<D>(c);
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0, 0.5);
    for (auto& p : solver.points())
        for (int k = 0; k < D; ++k) p.velocity[k] = normal(random);
    return solver;
}

std::string error_of(auto&& run)
{
    try {
        run();
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::numerical);
        return e.what();
    }
    return "";
}

template <int D>
void check_momentum(mpm::BasisKind basis, mpm::Scheme scheme, double flip, bool affine)
{
    mpm::Config c = box<D>(1.2, {0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
    c.basis = basis;
    c.scheme = scheme;
    c.flip = flip;
    c.affine = affine;
    auto solver = shaken<D>(c);
    mpm::Vec<D> const before = unit::momentum(solver.state());
    double scale = 0;
    for (auto const& p : solver.state().points) scale += p.mass * p.velocity.norm();
    for (int k = 0; k < 20; ++k) solver.step(0.1 * solver.limit());
    CHECK((unit::momentum(solver.state()) - before).norm() < 1e-13 * scale);
    CHECK(solver.energies().elastic > 0);
}

}  // namespace

TEST_CASE("solver: momentum is conserved to rounding, every basis, scheme and blend, plane and space")
{
    for (auto basis : {mpm::BasisKind::gimp, mpm::BasisKind::linear, mpm::BasisKind::spline, mpm::BasisKind::cpdi})
        for (auto scheme : {mpm::Scheme::musl, mpm::Scheme::usl})
            for (double flip : {1.0, 0.9, 0.0})
                for (bool affine : {true, false}) {
                    check_momentum<2>(basis, scheme, flip, affine);
                    check_momentum<3>(basis, scheme, flip, affine);
                }
}

TEST_CASE("solver: with the affine transfer a linear field of velocities comes back as it was, at free surfaces too")
{
    for (auto basis : {mpm::BasisKind::gimp, mpm::BasisKind::linear, mpm::BasisKind::spline, mpm::BasisKind::cpdi}) {
        mpm::Config c = box<2>(1.2, {0.4, 0.4, 0}, {0.8, 0.8, 0});
        c.basis = basis;
        c.law = mpm::LinearElastic{{1e-9, 0}};  // nothing but motion
        auto solver = mpm::make_solver<2>(c);
        mpm::Mat<2> slope;
        slope << 0.3, -2, 1.5, -0.1;
        for (auto& p : solver.points()) {
            p.velocity = slope * p.place;
            p.slope = slope;
        }
        double const dt = 0.01;
        solver.step(dt);
        mpm::Mat<2> const moved = mpm::Mat<2>::Identity() + dt * slope;
        for (auto const& p : solver.state().points) {
            CHECK((p.slope - slope * moved.inverse()).norm() < 1e-12);
            CHECK((p.velocity - slope * moved.inverse() * p.place).norm() < 1e-12);
            CHECK((p.matter.gradient.topLeftCorner<2, 2>() - moved).norm() < 1e-12);
        }
    }
}

TEST_CASE("solver: a free body falls as a stone does")
{
    mpm::Config c = box<2>(3, {1, 2.0, 0}, {1.5, 2.5, 0});
    c.gravity = {0, -9.81, 0};
    auto solver = mpm::make_solver<2>(c);
    auto const start = solver.state().points[0].place;
    double const dt = 1e-3;
    int const steps = 500;
    for (int k = 0; k < steps; ++k) solver.step(dt);
    auto const& p = solver.state().points[0];
    CHECK(p.velocity[1] == close_to(-9.81 * dt * steps).epsilon(1e-12));
    CHECK(std::abs(p.velocity[0]) < 1e-12);
    CHECK((p.place - start)[1] == close_to(-9.81 * dt * dt * steps * (steps + 1) / 2).epsilon(1e-12));
    CHECK(p.matter.stress.norm() < 1e-6);
    CHECK(solver.energies().balance() == close_to(mpm::make_solver<2>(c).energies().balance()).epsilon(1e-12));
}

TEST_CASE("solver: a body that turns keeps its size and makes no stress beyond the centrifugal one")
{
    for (auto scheme : {mpm::Scheme::musl, mpm::Scheme::usl}) {
        mpm::Config c = box<2>(1.2, {0.4, 0.4, 0}, {0.8, 0.8, 0});
        c.law = mpm::LinearElastic{{1e6, 0.3}};
        c.scheme = scheme;
        auto solver = mpm::make_solver<2>(c);
        double const rate = 2;
        for (auto& p : solver.points()) p.velocity = {-rate * (p.place[1] - 0.6), rate * (p.place[0] - 0.6)};
        double const pressure = 1000 * rate * rate * 0.08;  // rho w^2 R^2, the scale of the centrifugal stress
        while (solver.time() < 2 * std::numbers::pi / rate) solver.step(solver.longest_step());
        double largest = 0, ratio = 0;
        for (auto const& p : solver.state().points) {
            largest = std::max(largest, p.matter.stress.norm());
            ratio = std::max(ratio, std::abs(p.matter.ratio - 1));
        }
        CHECK(largest < 4 * pressure);  // a rate without spin makes E: 1e6 Pa
        CHECK(ratio < 4 * pressure / 1e6);
    }
}

TEST_CASE("solver: damping takes twice its rate of the kinetic energy, and nothing of what walls bear")
{
    mpm::Config c = box<2>(1.2, {0.2, 0, 0}, {1, 0.8, 0});
    c.gravity = {0, -9.81, 0};
    c.flip = 1;
    c.damping = 5;  // 1/s; the gravest mode has 23
    c.walls.push_back({.axis = 1, .side = -1, .kind = mpm::WallKind::fixed});
    for (bool const one_at_a_time : {false, true}) {
        auto setup = mpm::make_setup<2>(c);
        setup.one_at_a_time = one_at_a_time;
        mpm::Solver<2> solver(setup, mpm::make_state<2>(c));
        double taken = 0;
        for (double before = 0; solver.time() < 1; before = solver.energies().kinetic) {
            double const dt = solver.longest_step();
            solver.step(dt);
            taken += c.damping * dt * (before + solver.energies().kinetic);
        }
        // the nodes at the ends stand for half a cell each: their kinetic energy is that of the points to a cell of 8
        CHECK(std::abs(solver.energies().booked.damping / taken - 1) < 1.0 / 8);
    }
}

TEST_CASE("solver: energies balance while a body shakes, falls on a rough floor and yields")
{
    mpm::Elasticity const soft{1e5, 0.3}, stiff{3e6, 0.3};
    mpm::Law const yielding = mpm::MohrCoulomb{
        stiff, mpm::MohrCoulombSurface(stiff, {.friction_angle = 0.4, .cohesion = 100, .tension = 50})};
    for (mpm::Law const& law : {mpm::Law(mpm::LinearElastic{stiff}), mpm::Law(mpm::NeoHookean{soft}), yielding}) {
        mpm::Config c = box<2>(1.2, {0.4, 0.1, 0}, {0.8, 0.5, 0});
        c.gravity = {2, -9.81, 0};
        c.law = law;
        c.damping = 0.2;
        for (int axis : {0, 1})
            for (int side : {-1, 1})
                c.walls.push_back({.axis = axis,
                                   .side = side,
                                   .place = side < 0 ? 0.0 : 1.2,
                                   .kind = mpm::WallKind::rough,
                                   .friction = 0.4});
        auto solver = mpm::make_solver<2>(c);
        auto const start = solver.energies();
        double moved = 0;
        while (solver.time() < 0.5) {
            solver.step(0.2 * solver.limit());
            moved = std::max(moved, solver.energies().kinetic);
        }
        auto const e = solver.energies();
        CHECK(e.booked.sliding > 0);
        CHECK(e.booked.damping > 0);
        CHECK((e.booked.plastic > 0.1 * moved) == std::holds_alternative<mpm::MohrCoulomb>(law));
        // a wall that may be left gives no energy: only what is lost between points and grid, or at an impact
        CHECK(e.booked.numerical > 0);
        // law: of rates, energy and work differ by a third of the strain; the trapezoid of the work, where stress turns
        // at the surface
        CHECK(std::abs(e.balance() - start.balance()) < 0.02 * moved);
    }
}

TEST_CASE("solver: energies balance in a frame that spins up, plane and space")
{
    auto const check = [&]<int D>() {
        mpm::Config c = box<D>(3, {1, 1, 1}, {1.5, 1.5, 1.5});
        c.law = mpm::LinearElastic{{1e6, 0.3}};
        c.rotation = sluice::Rotation{{0.3, 0.1, 0}, {0, 0, 1}, 4, 0.1, true, true, true};
        auto solver = mpm::make_solver<D>(c);
        double const start = solver.energies().balance();
        while (solver.time() < 0.15) solver.step(0.5 * solver.limit());
        auto const e = solver.energies();
        CHECK(e.kinetic > 1);
        CHECK(e.balance() == close_to(start).scale(e.kinetic).epsilon(1e-3));  // law of rates: a third of the strain
        // a body at rest in space moves back as the frame turns, -w x r: kinetic and centrifugal energy cancel at any
        // rate, but for half a step between them
        CHECK(std::abs(e.booked.field_work) < solver.limit() / 0.1 * e.kinetic);
        double const w = 4, mass = 1000 * std::pow(0.5, D), offset = std::hypot(1.25 - 0.3, 1.25 - 0.1);
        CHECK(e.kinetic == close_to(0.5 * mass * w * w * (offset * offset + 0.25 / 6)).epsilon(0.01));
    };
    check.operator()<2>();
    check.operator()<3>();
}

TEST_CASE("solver: a plate takes matter along, may be left, vanishes, and its work is in the balance, plane and space")
{
    auto const check = [&]<int D>() {
        mpm::Config c = box<D>(2, {0.5, 0.5, 0.5}, {1.0, 1.0, 1.0});
        mpm::Plate<3> plate{.point = {0.47, 0, 0}, .normal = {1, 0, 0}, .friction = 0.5};  // off the grid
        plate.motion.velocity = {0.5, 0, 0};
        plate.motion.end = 0.2;
        c.plates = {plate};
        auto solver = mpm::make_solver<D>(c);
        auto const start = solver.energies();
        double impulse = 0;
        while (solver.time() < 0.4) {
            solver.step(0.2 * solver.limit());
            impulse -= solver.grains().plate_impulses()[0][0];
        }
        CHECK(impulse > 0);
        CHECK(unit::momentum(solver.state())[0] == close_to(impulse).epsilon(1e-12));
        CHECK(solver.energies().booked.external_work > 0);
        CHECK(solver.energies().balance() == close_to(start.balance()).scale(solver.energies().kinetic).epsilon(0.02));
        double back = 2;  // it stays where it is since 0.2 s, the block goes on
        for (auto const& p : solver.state().points) back = std::min(back, p.place[0]);
        CHECK(back > 0.47 + 0.1 + 0.05);
        c.plates[0].removed_at = 0;
        auto free = mpm::make_solver<D>(c);
        while (free.time() < 0.1) free.step(0.2 * free.limit());
        CHECK(free.energies().kinetic == 0);
        c.plates[0].removed_at = HUGE_VAL;
        c.plates[0].point = {0.6, 0, 0};
        try {
            mpm::make_solver<D>(c);
            FAIL("points behind a plate");
        } catch (sluice::Error const& e) {
            CHECK(contains(e.what(), "behind a plate"));
        }
        c.plates[0].point = {0.47, 0, 0};
        c.plates[0].motion.velocity = {1e3, 0, 0};
        CHECK(mpm::make_solver<D>(c).limit() < 1.01e-4);
    };
    check.operator()<2>();
    check.operator()<3>();
}

TEST_CASE("solver: loads and tractions do the work that is booked")
{
    mpm::Config c = box<2>(2, {0.5, 0.5, 0}, {1.0, 1.0, 0});
    auto setup = mpm::make_setup<2>(c);
    auto state = mpm::make_state<2>(c);
    double area = 0;
    for (std::size_t p = 0; p < state.points.size(); ++p)
        if (state.points[p].place[0] < 0.55) {
            setup.tractions.push_back({.point = p, .axis = 0, .side = -1, .stress = {20, 0}});
            area += 0.05;
        }
    CHECK(area == close_to(0.5));
    mpm::Solver<2> solver(setup, state);
    std::vector<mpm::Vec<2>> loads(state.points.size(), mpm::Vec<2>(0, 0.5));
    solver.set_loads(loads);
    double const dt = 0.2 * solver.limit();
    for (int k = 0; k < 50; ++k) solver.step(dt);
    auto const p = unit::momentum(solver.state());
    CHECK(p[0] == close_to(20 * 0.5 * 50 * dt).epsilon(1e-10));
    CHECK(p[1] == close_to(0.5 * 100 * 50 * dt).epsilon(1e-10));
    auto const e = solver.energies();
    CHECK(e.booked.external_work > 0);
    CHECK(std::abs(e.balance()) < 1e-3 * e.booked.external_work);
}

TEST_CASE("solver: copies and runs from the same state go on alike, bit for bit")
{
    mpm::Config const c = box<2>(1.2, {0.4, 0.4, 0}, {0.8, 0.8, 0});
    auto solver = shaken<2>(c);
    for (int k = 0; k < 5; ++k) solver.step(solver.longest_step());
    auto copy = solver;
    auto fresh = mpm::make_solver<2>(c);
    fresh.restore(solver.state());
    for (int k = 0; k < 5; ++k)
        for (auto* s : {&solver, &copy, &fresh}) s->step(s->longest_step());
    for (std::size_t p = 0; p < solver.state().points.size(); ++p)
        for (auto* s : {&copy, &fresh}) {
            CHECK(s->state().points[p].place == solver.state().points[p].place);
            CHECK(s->state().points[p].matter.stress == solver.state().points[p].matter.stress);
        }
}

TEST_CASE("solver: what blows up is named, with point, place and time")
{
    mpm::Config const c = box<2>(1.2, {0.4, 0.4, 0}, {0.8, 0.8, 0});
    auto solver = mpm::make_solver<2>(c);
    CHECK(contains(error_of([&] { solver.step(0.61 * solver.limit()); }), "0.6 cells at"));
    CHECK(error_of([&] { solver.step(0.6 * solver.limit()); }) == "");
    mpm::Grain<2> grain;  // faster than any wave
    grain.velocity = {1e4, 0}, grain.radius = 0.2;
    solver.set_grains({grain});
    CHECK(contains(error_of([&] { solver.step(0.61 * solver.limit()); }), "0.6 cells at 10000 m/s"));
    solver.set_grains({});

    mpm::Config leaving = c;
    leaving.bodies[0].velocity = {50, 0, 0};
    auto gone = mpm::make_solver<2>(leaving);
    auto const left = error_of([&] {
        for (int k = 0; k < 1000; ++k) gone.step(gone.longest_step());
    });
    CHECK(contains(left, "has left the domain"));
    CHECK(contains(left, ": point 7 at (1.2"));

    auto crushed = mpm::make_solver<2>(c);
    for (auto& p : crushed.points()) p.velocity = {p.place[0] < 0.6 ? 30.0 : -30.0, 0};
    auto const inside_out = error_of([&] {
        for (int k = 0; k < 100; ++k) crushed.step(0.6 * crushed.limit());
    });
    CHECK(contains(inside_out, "J = -"));

    auto broken = mpm::make_solver<2>(c);
    broken.points()[3].velocity[0] = NAN;
    CHECK(contains(error_of([&] { broken.step(1e-4); }), "not a number"));
}

TEST_CASE("solver: a wall stops points before they are half a cell into it, an open side lets none pass")
{
    for (auto kind : {mpm::WallKind::rough, mpm::WallKind::roller, mpm::WallKind::fixed, mpm::WallKind::open}) {
        mpm::Config c = box<2>(1.2, {0.4, 0, 0}, {0.8, 0.1, 0});
        c.law = mpm::LinearElastic{{1e3, 0}};  // hardly resists
        c.bodies[0].velocity = {0, -0.5, 0};
        c.walls.push_back({.axis = 1, .side = -1, .place = 0, .kind = kind, .friction = 0.3});
        auto solver = mpm::make_solver<2>(c);
        double lowest = 1;
        auto const fall = [&] {
            while (solver.time() < 0.5) {
                solver.step(solver.longest_step());
                for (auto const& p : solver.state().points) lowest = std::min(lowest, p.place[1]);
            }
        };
        if (kind == mpm::WallKind::open) {
            CHECK(contains(error_of(fall), "has left the domain"));
            continue;
        }
        fall();
        CHECK(lowest > -0.05);
    }
}

TEST_CASE("solver: nodes of almost no mass do not blow up strain, and are counted")
{
    for (auto scheme : {mpm::Scheme::usl, mpm::Scheme::musl}) {
        mpm::Config c = box<2>(1.2, {0.4, 0.4, 0}, {0.8, 0.8, 0});
        c.scheme = scheme;
        c.basis = mpm::BasisKind::linear;
        c.affine = false;
        auto solver = mpm::make_solver<2>(c);
        for (auto& p : solver.points()) {
            p.place[0] += 0.025 + 1e-11;  // just beyond a grid line
            p.matter.stress = -1e3 * mpm::Mat3::Identity();
        }
        solver.step(1e-4);
        CHECK(solver.light_nodes() > 0);
        for (auto const& p : solver.state().points) {
            CHECK(std::abs(p.matter.ratio - 1) < 1e-3);
            CHECK(p.velocity.norm() < 0.1);
        }
    }
}

TEST_CASE("solver: a gate holds until it is removed")
{
    mpm::Config c = box<2>(1.2, {0, 0, 0}, {0.4, 0.4, 0});
    c.gravity = {0, -9.81, 0};
    mpm::Elasticity const elastic{1e6, 0.3};
    c.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, {.friction_angle = 0.3})};
    c.walls = {
        {.axis = 0, .side = -1}, {.axis = 1, .side = -1}, {.axis = 0, .side = 1, .place = 0.4, .removed_at = 0.1}};
    auto solver = mpm::make_solver<2>(c);
    auto const front = [&] {
        double most = 0;
        for (auto const& p : solver.state().points) most = std::max(most, p.place[0]);
        return most;
    };
    double const start = front();
    while (solver.time() < 0.1) solver.step(solver.longest_step());
    CHECK(front() - start < 0.002);
    while (solver.time() < 0.3) solver.step(solver.longest_step());
    CHECK(front() - start > 0.05);
}
