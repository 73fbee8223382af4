#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/verification/mpm/bars.hpp"

//! Plates: walls anywhere that move as they are told. Closed forms.
using namespace verification;

namespace {

constexpr double g = 9.81;

mpm::Config block(double cell)
{
    mpm::Config c;
    c.cell = cell;
    c.size = {5, 5, 0};
    c.flip = 1;
    c.density = 2000;
    c.gravity = {0, -g, 0};
    c.law = mpm::LinearElastic{{1e7, 0.3}};
    return c;
}

//! How far a tilted block of 1 m x 0.5 m goes in a second on a rough plate that is as inclined.
double slid(double angle, double friction)
{
    mpm::Config c = block(0.05);
    c.origin = {-1, -4, 0};
    c.bodies.push_back({.low = {0, 0, 0}, .high = {1, 0.5, 0}});
    mpm::Vec3 const normal(std::sin(angle), std::cos(angle), 0);
    c.plates.push_back({.point = mpm::Vec3::Zero(), .normal = normal, .friction = friction});
    auto setup = mpm::make_setup<2>(c);
    auto state = mpm::make_state<2>(c);
    mpm::Mat<2> turn;
    turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
    for (auto& p : state.points) p.place = turn * p.place;
    mpm::Solver<2> solver(setup, state);
    auto const along = [&] {
        return mean(solver.state(), [&](auto const& p) { return p.place.dot(mpm::Vec<2>(normal[1], -normal[0])); });
    };
    double const start = along();
    while (solver.time() < 1 - 1e-12) solver.step(std::min(solver.longest_step(), 1 - solver.time()));
    return along() - start;
}

}  // namespace

//! The case of M05 on a plate across the grid; mark as there. Gravity begins at once: the block shakes by its weight.
TEST_CASE("M05: a tilted block slides on an inclined plate")
{
    double const degree = std::numbers::pi / 180;
    for (auto const& [angle, friction, reference] :
         {std::tuple{30.0, 0.3, 1.178143618}, std::tuple{20.0, 0.2, 0.755837}, std::tuple{45.0, 0.5, 1.734179381}}) {
        Stopwatch const watch;
        double const got = slid(angle * degree, friction);
        CHECK(report({"M05", named("plate, theta = %.0f, mu = %.1f: way in 1 s [m]", angle, friction), got, reference,
                      std::abs(got / reference - 1), 0.02, watch.seconds()}));
    }
}

//! A plate that starts at once at v into a bar: the stress behind the wave is rho c v, until it comes back from the far
//! end. Its impulse and its work in the ledger; half of the work moves, half is stored. Marks of M02: 2 %.
TEST_CASE("M02: a plate drives a bar")
{
    Stopwatch const watch;
    double const length = 10, density = 1000, modulus = 1e7, speed = 0.1, sound = std::sqrt(modulus / density);
    mpm::Config c = bar(length, 100, 2, 0);
    c.density = density;
    c.law = mpm::LinearElastic{{modulus, 0}};
    for (auto& wall : c.walls)
        if (wall.axis == 0) wall.kind = mpm::WallKind::open;
    c.plates.push_back({.point = mpm::Vec3::Zero(), .normal = mpm::Vec3::UnitX()});
    c.plates[0].motion.velocity = {speed, 0, 0};
    auto solver = mpm::make_solver<2>(c);
    double const end = 0.9 * length / sound, pressure = density * sound * speed;
    double impulse = 0;
    while (solver.time() < end) {
        solver.step(solver.longest_step());
        impulse -= solver.grains().plate_impulses()[0][0] / c.cell;
    }
    double const t = solver.time(), work = solver.energies().booked.external_work / c.cell;
    auto const check = [&](char const* what, double value, double reference) {
        CHECK(report({"M02", what, value, reference, std::abs(value / reference - 1), 0.02, watch.seconds()}));
    };
    check("plate: its impulse [N s/m2]", impulse, pressure * t);
    check("plate: its work [J/m2]", work, pressure * speed * t);
    check("plate: kinetic energy by work", solver.energies().kinetic / c.cell / work, 0.5);
    check("plate: elastic energy by work", solver.energies().elastic / c.cell / work, 0.5);
    double const momentum = mean(solver.state(), [](auto const& p) { return p.velocity[0]; }) * density * length;
    CHECK(report({"M02", "plate: momentum of the bar by the impulse", momentum / impulse, 1,
                  std::abs(momentum / impulse - 1), 1e-12, watch.seconds()}));
}

//! A block on a plate that gets a pulse: from rest to 1 m/s in 0.1 s, more than friction can follow. The block slides
//! behind at mu g until it has the plate's velocity. Marks of M05: 2 %.
TEST_CASE("M05: a plate that gets a pulse takes a block along")
{
    Stopwatch const watch;
    double const friction = 0.3, v = 1, rise = 0.1, end = 0.5;
    mpm::Config c = block(0.025);
    c.size = {1.5, 0.3, 0};
    c.origin = {0, -0.0725, 0};  // not on a grid line
    c.bodies.push_back({.low = {0.5, -0.01, 0}, .high = {0.9, 0.09, 0}});
    c.plates.push_back({.point = {0, -0.01, 0}, .normal = {0, 1, 0}, .friction = friction});
    using Knot = motion::Knot<mpm::Vec3>;
    c.plates[0].motion.knots = {Knot{0, {0, 0, 0}}, Knot{rise, {v, 0, 0}}, Knot{1, {v, 0, 0}}};
    c.geostatic = mpm::GeostaticConfig{.surface = 0.09, .k0 = 0};  // it shakes little: mu g H / c = 7 mm/s
    auto solver = mpm::make_solver<2>(c);
    auto const place = [&] { return mean(solver.state(), [](auto const& p) { return p.place[0]; }); };
    double const start = place(), mass = c.density * 0.04;
    while (solver.time() < end - 1e-12) solver.step(std::min(solver.longest_step(), end - solver.time()));
    double const follows = v / (friction * g);  // when it has caught up
    double const behind = v * follows - 0.5 * v * rise - 0.5 * v * follows, way = v * end - 0.5 * v * rise - behind;
    auto const check = [&](char const* what, double value, double reference) {
        CHECK(report({"M05", what, value, reference, std::abs(value / reference - 1), 0.02, watch.seconds()}));
    };
    check("pulse: way of the block [m]", place() - start, way);
    auto const& booked = solver.energies().booked;
    check("pulse: friction on the plate [J/m]", booked.sliding, friction * mass * g * behind);
    check("pulse: work of the plate [J/m]", booked.external_work, friction * mass * g * (v * follows - 0.5 * v * rise));
}
