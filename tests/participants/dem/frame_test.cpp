#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "participants/dem/packing_file.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

//! Grains in a frame that turns; free bodies, sliders and drops with their closed forms are R01 to R09 of the
//! verification.
namespace {

constexpr double rate = 7.0;

dem::Vec3 turned(dem::Vec3 v, dem::Vec3 axis, double angle)  // Rodrigues
{
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + (1 - std::cos(angle)) * dot(axis, v) * axis;
}

//! A sphere that knows of nothing but the frame.
dem::Solver<3> alone(sluice::Rotation const& rotation, dem::Vec3 at, dem::Motion<3> const& motion, double weight = 1.0)
{
    dem::Setup<3> s;
    s.skin = 0.1;
    s.weight = weight;
    s.frame.emplace(rotation);
    dem::Grains<3> g;
    g.add(at, 0.5, 1000.0, motion);
    return {s, g};
}

//! The box of 144 discs in a centrifuge that is spun up within its first part, the axis 0.3 m above.
dem::Solver<2> spun_box(bool euler, double dt_of_ramp)
{
    dem::Solver<2> const still = box(true);
    dem::Setup<2> s = still.setup();
    s.frame.emplace(sluice::Rotation{{0.01, 0.3, 0}, {0, 0, 1}, 20.0, dt_of_ramp, true, true, euler});
    return {s, loose(12, 5, 0.3)};
}

}  // namespace

TEST_CASE("frame: the spin of a free sphere stays as it is in space, turned and slowed as seen in the frame")
{
    dem::Vec3 const axis{0.6, 0.0, 0.8}, spin{3.0, -2.0, 5.0};
    double const time = 0.25, ramp = 0.2;
    sluice::Rotation const steady{{}, {axis.x, axis.y, axis.z}, rate};
    auto solver = alone(steady, {}, {{}, spin});
    for (int k = 0; k < 1000; ++k) solver.step(time / 1000);
    CHECK(norm(solver.grains().motion[0].spin - turned(spin, axis, -rate * time)) < 1e-12 * norm(spin));
    auto ramped = steady;
    ramped.ramp = ramp;
    auto slowed = alone(ramped, {}, {{}, spin});  // the frame is at rest at first: spin is that in space
    for (int k = 0; k < 1000; ++k) slowed.step(time / 1000);
    auto const expected = turned(spin, axis, -rate * (time - ramp / 2)) - rate * axis;
    // kicks along the axis commute with turns about it; the end of the ramp lies on a step: rounding
    CHECK(norm(slowed.grains().motion[0].spin - expected) < 1e-11 * norm(spin));
}

TEST_CASE("frame: what is at rest in space while the frame is spun up goes back by its angle, to second order")
{
    dem::Vec3 const at{0.4, 0.3, -0.2}, axis{0.0, 1.0, 0.0}, point{0.1, 7.0, 0.2};
    double const time = 0.3, ramp = 0.2;
    auto const error = [&](int steps) {
        auto solver = alone({{point.x, point.y, point.z}, {0, 1, 0}, rate, ramp}, at, {});
        for (int k = 0; k < steps; ++k) solver.step(time / steps);
        auto const expected = point + turned(at - point, axis, -rate * (time - ramp / 2));
        return norm(solver.grains().place[0].centre - expected) / norm(at - point);
    };
    double const coarse = error(300), fine = error(600);
    CHECK(coarse < 1e-4);  // (w dt)^2 = 5e-5
    CHECK(std::log2(coarse / fine) > 1.9);
}

TEST_CASE("frame: a grain as heavy as the fluid floats in the centrifuge, and keeps its inertia")
{
    sluice::Rotation const rotation{{}, {0, 0, 1}, rate, 0, true, false, true};
    auto floating = alone(rotation, {1.0, 0.0, 0.0}, {}, 0.0), half = alone(rotation, {1.0, 0.0, 0.0}, {}, 0.5);
    for (int k = 0; k < 1000; ++k) {
        floating.step(1e-4);
        half.step(1e-4);
    }
    CHECK(floating.grains().place[0].centre == dem::Vec3{1.0, 0.0, 0.0});
    // x'' = w^2/2 x; the step's error is (w dt)^2 = 5e-7
    CHECK(half.grains().place[0].centre.x == close_to(std::cosh(std::sqrt(0.5) * rate * 0.1)).epsilon(1e-6));
}

TEST_CASE("frame: the ledger closes while a box of grains is spun up, by potential and work of the frame")
{
    // what the step's length leaves is of second order: without the frame 1e-6 of what moves (README, Limits)
    for (bool const euler : {true, false}) {
        auto solver = spun_box(euler, 0.02);
        double const start = solver.energies().balance();
        for (int k = 0; k < 20000; ++k) solver.step(step);
        auto const e = solver.energies();
        CHECK(e.field_work != 0.0);
        CHECK(std::abs(e.field_work) > 0.1 * e.lost());
        CHECK(std::abs(e.balance() - start) < 1e-5 * (e.lost() + std::abs(e.field_work)));
    }
}

TEST_CASE("frame: a restored solver continues bit for bit in the middle of the spin-up")
{
    auto a = spun_box(true, 0.02);
    for (int n = 0; n < 5000; ++n) a.step(step);
    auto const at_half = kept(a);
    for (int n = 0; n < 5000; ++n) a.step(step);
    dem::Solver<2> b(a.setup(), {});
    b.restore(dem::kept_state<2>(at_half, b.setup(), 144));
    for (int n = 0; n < 5000; ++n) b.step(step);
    CHECK(kept(a) == kept(b));
}

TEST_CASE("frame: a column is prepared in the field of the centrifuge, which its walls then carry")
{
    // 15 g at the floor, the axis 0.5 m above: at half a column's height the field is 2 % less
    double const top = 0.5, rate = std::sqrt(15 * 9.81 / top);
    dem::Config c = dem::read_config(sluice::read_yaml(scene, "grains.yaml"), 2, {},
                                     sluice::Rotation{{0.004, top, 0}, {0, 0, 1}, rate, 0, true, true, true});
    CHECK(dem::settling_gravity(c).y == close_to(-15 * 9.81));
    CHECK(dem::packing_file_name(c) != dem::packing_file_name(config()));
    auto const packing = dem::pour_packing<2>(c);
    CHECK(packing.kinetic_ratio <= dem::settled_kinetic_ratio);
    for (auto& wall : c.walls) wall.removed_at = std::numeric_limits<double>::infinity();  // the gate stays
    auto solver = dem::make_solver<2>(c, packing);
    for (int k = 0; k < 2000; ++k) solver.step(c.step);
    dem::Vec2 carried{}, field{};
    for (auto const& wall : solver.state().walls) carried += wall.force;
    auto const& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i)
        field += (g.mass[i] * rate * rate) * (g.place[i].centre - dem::Vec2{0.004, top});
    CHECK(norm(carried + field) < 1e-3 * norm(field));  // the mark of D07 for a bed's weight
}

TEST_CASE("gravity that grows: a fall by its closed form, and a ledger that closes")
{
    dem::Setup<2> s = setup(0.5, {0.0, -9.81}, true);
    s.first_gravity = {2.0, 0.0};
    s.gravity_ramp = 0.1;
    dem::Solver<2> alone(s, [] {
        dem::Grains<2> g;
        g.add({0.0, 0.0}, 0.01, density);
        return g;
    }());
    for (int k = 0; k < 2000; ++k) alone.step(1e-4);  // half of it at the full gravity
    // a = (2 (1 - t/T), -9.81 t/T): both halves of a step take it at its ends, the trapezium is exact for velocities
    auto const velocity = alone.grains().motion[0].velocity;
    CHECK(velocity.x == close_to(0.5 * 2.0 * 0.1).epsilon(1e-12));
    CHECK(velocity.y == close_to(-9.81 * (0.05 + 0.1)).epsilon(1e-12));
    double const fall = -9.81 * (0.1 * 0.1 / 6 + 0.05 * 0.1 + 0.1 * 0.1 / 2);
    CHECK(alone.grains().place[0].centre.y == close_to(fall).epsilon(1e-6));  // (dt / T)^2

    dem::Setup<2> falling = box(true).setup();
    falling.first_gravity = {1.0, 3.0};
    falling.gravity_ramp = 0.02;
    dem::Solver<2> solver(falling, loose(12, 5, 0.3));
    double const start = solver.energies().balance();
    for (int k = 0; k < 20000; ++k) solver.step(step);
    auto const e = solver.energies();
    CHECK(std::abs(e.field_work) > 0.1 * e.lost());
    CHECK(std::abs(e.balance() - start) < 1e-5 * (e.lost() + std::abs(e.field_work)));
}

TEST_CASE("walls: a velocity from knot to knot is the derivative of the shift, which ends where the areas say")
{
    dem::WallMotion<2> m;
    m.knots = {{0.1, {0.0, 0.0}}, {0.12, {0.5, -1.0}}, {0.16, {0.0, 0.0}}, {0.2, {0.0, 2.0}}};
    CHECK(m.moves());
    CHECK(m.shift(0.05) == dem::Vec2{});
    CHECK(m.speed(0.05) == dem::Vec2{});
    CHECK(m.speed(0.12).x == close_to(0.5));
    CHECK(m.speed(0.14).y == close_to(-0.5));
    CHECK(m.speed(0.2) == dem::Vec2{});
    CHECK(m.shift(0.12).x == close_to(0.5 * 0.02 * 0.5));
    CHECK(m.shift(0.3).x == close_to(0.5 * 0.06 * 0.5));
    CHECK(m.shift(0.3).y == close_to(-0.5 * 0.06 + 0.5 * 0.04 * 2.0));
    for (double t : {0.105, 0.13, 0.15, 0.17, 0.19}) {
        dem::Vec2 const slope = (1.0 / 2e-6) * (m.shift(t + 1e-6) - m.shift(t - 1e-6));
        CHECK(norm(slope - m.speed(t)) < 1e-8);
    }
}
