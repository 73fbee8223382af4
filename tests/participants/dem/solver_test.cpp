#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

template <int D>
bool same(dem::Grains<D> const& a, dem::Grains<D> const& b)
{
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a.place[i].centre != b.place[i].centre || a.motion[i].velocity != b.motion[i].velocity ||
            a.motion[i].spin != b.motion[i].spin)
            return false;
    return a.size() == b.size();
}

}  // namespace

TEST_CASE("solver: the same input gives the same bits")
{
    dem::Solver<2> a = box(), b = box();
    for (int n = 0; n < 20000; ++n) a.step(step), b.step(step);
    CHECK(same(a.grains(), b.grains()));
}

TEST_CASE("solver: the ledger and the reach of the neighbour list do not change a bit")
{
    dem::Solver<2> a = box(), with_ledger = box(true), long_list = box(false, 6e-4);
    for (int n = 0; n < 20000; ++n) a.step(step), with_ledger.step(step), long_list.step(step);
    CHECK(a.state().rebuilds > long_list.state().rebuilds);
    CHECK(same(a.grains(), with_ledger.grains()));
    CHECK(same(a.grains(), long_list.grains()));
}

TEST_CASE("solver: a copy continues on its own")
{
    dem::Solver<2> a = box();
    for (int n = 0; n < 5000; ++n) a.step(step);
    dem::Solver<2> b = a;
    for (int n = 0; n < 5000; ++n) a.step(step);
    CHECK_FALSE(same(a.grains(), b.grains()));
    for (int n = 0; n < 5000; ++n) b.step(step);
    CHECK(same(a.grains(), b.grains()));
}

TEST_CASE("solver: many steps at once are those one by one, to the last bit")
{
    auto const check = [](auto at_once, double dt) {
        auto one_by_one = at_once;
        for (int const count : {1, 700, 2, 297, 2000}) {
            at_once.steps(dt, count);
            for (int n = 0; n < count; ++n) one_by_one.step(dt);
            REQUIRE(same(at_once.grains(), one_by_one.grains()));
            REQUIRE(at_once.time() == one_by_one.time());
        }
        CHECK(at_once.state().rebuilds > 1);
        CHECK(at_once.state().rebuilds == one_by_one.state().rebuilds);
    };
    dem::Solver<2> const still = box();
    dem::Setup<2> s = still.setup();
    s.walls[2].removed_at = 1500.5 * step;
    s.gravity_ramp = 2100 * step;
    check(dem::Solver<2>(s, still.grains()), step);
    s.frame.emplace(sluice::Rotation{{0.01, 0.3, 0}, {0, 0, 1}, 20.0, 500 * step, true, true, true});
    check(dem::Solver<2>(s, still.grains()), step);
    s.features.ledger = true;
    check(dem::Solver<2>(s, still.grains()), step);
    s.features.ledger = false;
    s.sleep = {1e-4, 100 * step};
    check(dem::Solver<2>(s, still.grains()), step);
    for (int const threads : {1, 3})
        check(tumbling(dem::Rolling::elastic_plastic, dem::Scheme::predicted, false, false, threads), 5e-6);
    check(tumbling(dem::Rolling::constant, dem::Scheme::liggghts, false), 5e-6);
}

TEST_CASE("solver: external force and torque act in both half kicks")
{
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1e-3, density);
    dem::Solver<2> solver(setup(0.0, {0.0, 0.0}), g);
    double const m = g.mass[0], dt = 1e-3;
    solver.grains().external[0].force.x = 2.0 * m;
    solver.grains().external[0].torque = 3.0 * g.inertia[0];
    for (int n = 0; n < 4; ++n) solver.step(dt / 4.0);
    CHECK(solver.grains().motion[0].velocity.x == close_to(2.0 * dt));
    CHECK(solver.grains().place[0].centre.x == close_to(dt * dt));  // a t^2 / 2, exact for a constant force
    CHECK(solver.grains().motion[0].spin == close_to(3.0 * dt));
}

TEST_CASE("solver: the work of external forces is in the ledger, rotation included")
{
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1e-3, density, {{0.1, -0.2}, 4.0});
    dem::Solver<2> solver(setup(0.0, {0.0, -9.81}, true), g);
    double const start = solver.energies().balance();
    for (int n = 0; n < 100; ++n) {
        solver.grains().external[0].force.x = 0.01 * std::sin(0.1 * n);
        solver.grains().external[0].force.y = 0.02;
        solver.grains().external[0].torque = 1e-7 * n;
        solver.step(1e-4);
    }
    CHECK(std::abs(solver.energies().external_work) > 1e-6);
    CHECK(solver.energies().balance() == close_to(start).epsilon(1e-12));
}

TEST_CASE("solver: a gate is removed at its time, and its elastic energy is booked")
{
    dem::Setup<2> s = setup(0.5, {0.0, 0.0}, true);
    add_wall(s, "gate", {0.0, 0.0}, {-1.0, 0.0});
    s.walls[0].removed_at = 3.0 * step;
    dem::Grains<2> g;
    g.add({-0.99e-3, 0.0}, 1e-3, density);  // pressed by 10 um
    dem::Solver<2> solver(s, g);
    double const start = solver.energies().balance();
    for (int n = 0; n < 3; ++n) solver.step(step);
    double const v = solver.grains().motion[0].velocity.x;
    CHECK(v < 0.0);
    solver.step(step);
    CHECK(solver.grains().motion[0].velocity.x == v);  // no force any more
    CHECK(solver.energies().removed_walls > 0.0);
    CHECK(solver.energies().balance() == close_to(start).epsilon(1e-5));
}

TEST_CASE(
    "solver: grains that overlap part without NaN and release what the springs held, a centre within one is refused")
{
    for (double overlap : {0.01, 0.05, 0.2, 0.499, 0.501, 1.0}) {
        dem::Setup<2> s = setup(0.0, {0.0, 0.0});
        s.law = dem::contact_law(contact(0.0, 0.0));
        dem::Grains<2> g;
        g.add({0.0, 0.0}, 1e-3, density);
        g.add({2e-3 * (1.0 - overlap), 0.0}, 1e-3, density);
        if (overlap > 0.5) {
            CHECK_THROWS_WITH_AS(dem::Solver<2>(s, g), doctest::Contains("the centre of grain 1 lies within grain 0"),
                                 sluice::Error);
            continue;
        }
        dem::Solver<2> solver(s, g);
        double const held = solver.energies().elastic_normal;
        CHECK(held == close_to(0.5 * stiffness * std::pow(2e-3 * overlap, 2)));
        for (int n = 0; n < 200; ++n) solver.step(step);
        CHECK(solver.energies().kinetic() == close_to(held).epsilon(0.01));
        CHECK(solver.grains().motion[0].velocity.x == -solver.grains().motion[1].velocity.x);
    }
}

TEST_CASE("solver: what a moving wall gives in an impact is in the ledger, whenever in a step it begins")
{
    for (int phase = 0; phase < 8; ++phase) {
        dem::Setup<2> s = setup(0.5, {0.0, 0.0}, true);
        add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
        s.walls[0].motion.velocity = {0.7, 1.5};
        dem::Grains<2> g;
        g.add({0.0, 1e-3 + (10 + phase / 8.0) * 2.5 * step}, 1e-3, density, {{0.0, -1.0}, 0.0});
        dem::Solver<2> solver(s, g);
        double const start = solver.energies().balance();
        for (int n = 0; n < 200; ++n) solver.step(step);
        CHECK(solver.grains().motion[0].velocity.y > 1.5);  // it flies ahead of the wall
        CHECK(solver.energies().wall_work > 0.5 * start);
        CHECK(solver.energies().balance() == close_to(start).epsilon(1e-3));  // C08's mark of a gas
    }
}

TEST_CASE("solver: a grain behind a wall is refused")
{
    dem::Setup<2> s = setup(0.0);
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    g.add({0.0, -1e-3}, 1e-3, density);
    CHECK_THROWS_WITH_AS(dem::Solver<2>(s, g), doctest::Contains("behind wall \"floor\""), sluice::Error);
}

TEST_CASE("solver: a step that would jump over a contact, or a number that is not finite, ends the run")
{
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1e-3, density, {{1000.0, 0.0}, 0.0});
    dem::Solver<2> fast(setup(0.0), g);
    CHECK_THROWS_WITH_AS(fast.step(step), doctest::Contains("grain 0 moves by more than the smallest radius"),
                         sluice::Error);
    dem::Solver<2> broken = box();
    broken.grains().external[7].force.x = std::numeric_limits<double>::quiet_NaN();
    try {
        broken.step(step);
        FAIL("no error");
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::numerical);
        CHECK(std::string(e.what()).find("grain 7") != std::string::npos);
    }
}

TEST_CASE("solver: buoyancy lessens the weight and not the inertia")
{
    std::string const text =
        "density: 2500\ncontact: {normal_stiffness: 1e6, restitution: 0.8, friction: 0.4}\n"
        "buoyancy: {density: 1000}\ngrains:\n  - {position: [0, 1], radius: 0.001}\n";
    dem::Solver<2> solver = dem::make_solver<2>(config(text));
    for (int n = 0; n < 100; ++n) solver.step(1e-5);
    CHECK(solver.grains().motion[0].velocity.y == close_to(-9.81 * 0.6 * 1e-3));
    CHECK(solver.grains().mass[0] == close_to(2500.0 * std::numbers::pi * 1e-6));
}

TEST_CASE("solver: walls have friction of their own")
{
    dem::Setup<2> s = setup(0.5);
    add_wall(s, "smooth", {0.0, 0.0}, {0.0, 1.0});
    s.walls[0].law.tangential = {};
    dem::Grains<2> g;
    g.add({0.0, 1e-3}, 1e-3, density, {{0.1, 0.0}, 0.0});
    dem::Solver<2> solver(s, g);
    for (int n = 0; n < 5000; ++n) solver.step(step);
    CHECK(solver.grains().motion[0].velocity.x == 0.1);
    CHECK(solver.grains().motion[0].spin == 0.0);
}

TEST_CASE("solver: a grain that is pressed through a wall ends the run")
{
    dem::Setup<2> s = setup(0.0, {0.0, 0.0});
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    g.add({0.0, 1e-3}, 1e-3, density, {{0.0, -200.0}, 0.0});
    dem::Solver<2> solver(s, g);
    CHECK_THROWS_WITH_AS(
        [&] {
            for (int n = 0; n < 10; ++n) solver.step(step);
        }(),
        doctest::Contains("grain 0 is behind wall \"floor\""), sluice::Error);
}

TEST_CASE("solver: a wall that moves carries a grain along by friction, and its work is in the ledger")
{
    dem::Setup<2> s = setup(0.5, {0.0, -9.81}, true);
    add_wall(s, "belt", {0.0, 0.0}, {0.0, 1.0});
    s.walls[0].motion.velocity = {0.1, 0.0};
    s.walls[0].motion.end = 0.2;
    dem::Grains<2> g;
    double const mass = density * std::numbers::pi * 1e-6;
    g.add({0.0, 1e-3 - mass * 9.81 / stiffness}, 1e-3, density);
    dem::Solver<2> solver(s, g);
    double const start = solver.energies().balance();
    while (solver.time() < 0.19) solver.step(step);
    auto const& m = solver.grains().motion[0];
    CHECK(m.velocity.x - 1e-3 * -m.spin == close_to(0.1).epsilon(1e-6));  // sticks: the surface moves with the belt
    CHECK(m.velocity.x == close_to(0.1 / 3.0).epsilon(1e-3));             // a third of it, as a disc on a rug
    CHECK(solver.energies().wall_work == close_to(mass * 0.1 * 0.1 / 3.0).epsilon(2e-2));  // = M v / 3 . v
    CHECK(std::abs(solver.energies().balance() - start) < 1e-6 * mass * 0.1 * 0.1);
    while (solver.time() < 0.4) solver.step(step);
    CHECK(std::abs(m.velocity.x) < 1e-6);  // the belt has stopped, and the grain with it
    CHECK(solver.state().walls[0].shift.x == close_to(0.02));
}

TEST_CASE("solver: a wall that swings pushes a grain in front of it, and the lists follow")
{
    dem::Setup<2> s = setup(0.0, {0.0, 0.0}, true);
    add_wall(s, "piston", {0.0, 0.0}, {1.0, 0.0});
    s.walls[0].motion.amplitude = {5e-3, 0.0};
    s.walls[0].motion.frequency = 10.0;
    dem::Grains<2> g;
    g.add({3e-3, 0.0}, 1e-3, density);  // further away than the lists reach
    dem::Solver<2> solver(s, g);
    while (solver.time() < 0.05) solver.step(step);
    double const v = solver.grains().motion[0].velocity.x;
    CHECK(v > 0.25);  // the piston goes at up to 0.31 m/s, and e = 0.57
    CHECK(v < 0.32 * 1.6);
    CHECK(solver.energies().kinetic() == close_to(0.5 * g.mass[0] * v * v));
    CHECK(std::abs(solver.energies().balance()) < 1e-5 * solver.energies().kinetic());
}

TEST_CASE("solver: a grain swings in a cylinder as a pendulum does")
{
    // rolling without slip in a circle: omega^2 = g / ((1 + I*)(Rc - R)), I* = 1/2 (disc), 2/5 (sphere); small swings
    auto const period = [](auto make, double inertia) {
        constexpr double radius = 0.05, grain = 5e-3, start = 0.02;
        auto [s, g] = make(radius, grain, start);
        dem::Solver solver(s, g);
        double const t_c = dem::contact_time(stiffness, 0.0, g.mass[0]);
        double crossed = 0.0, before = solver.grains().place[0].centre.x;
        int crossings = 0;
        while (crossings < 3 && solver.time() < 3.0) {
            solver.step(t_c / 20.0);
            double const now = solver.grains().place[0].centre.x;
            if ((before > 0.0) != (now > 0.0)) {
                ++crossings;
                if (crossings == 1) crossed = -solver.time();
                if (crossings == 3) crossed += solver.time();
            }
            before = now;
        }
        double const theory = 2.0 * std::numbers::pi * std::sqrt((1.0 + inertia) * (radius - grain) / 9.81);
        CHECK(crossed == close_to(theory).epsilon(2e-3));
    };
    period(
        [&](double radius, double grain, double start) {
            dem::Setup<2> s = setup(0.8);
            s.walls.push_back(
                {.name = "bowl", .shape = dem::Cylinder<2>{{}, {}, radius, true}, .motion = {}, .law = s.law});
            dem::Grains<2> g;
            double const r = radius - grain;
            g.add({r * std::sin(start), -r * std::cos(start)}, grain, density);
            return std::pair(s, g);
        },
        0.5);
    period(
        [&](double radius, double grain, double start) {
            dem::Setup<3> s;
            s.gravity = {0.0, 0.0, -9.81};
            s.law = dem::contact_law(contact(0.8));
            s.skin = 2e-4;
            s.features = {.friction = true};
            s.walls.push_back(
                {.name = "pipe", .shape = dem::Cylinder<3>{{}, {0, 1, 0}, radius, true}, .motion = {}, .law = s.law});
            dem::Grains<3> g;
            double const r = radius - grain;
            g.add({r * std::sin(start), 0.0, -r * std::cos(start)}, grain, density);
            return std::pair(s, g);
        },
        0.4);
}

TEST_CASE("solver: spheres keep momentum and angular momentum through contacts with friction and rolling resistance")
{
    dem::ContactConfig const c = rolling_contact(0.5, dem::Rolling::elastic_plastic);
    dem::Setup<3> s;
    s.law = dem::contact_law(c);
    s.skin = 2e-4;
    s.features = {.friction = true, .rolling = c.rolling};
    dem::Random random(3);
    dem::Grains<3> g;
    for (int k = 0; k < 6 * 6 * 6; ++k) {
        auto const about = [&](double scale) { return random.uniform(-scale, scale); };
        auto const at = [&](int n) { return (n + 0.5) * 2.1e-3 + about(1e-4); };
        dem::Motion<3> motion{};
        motion.velocity = {about(1.0), about(1.0), about(1.0)};
        motion.spin = {about(1000.0), about(1000.0), about(1000.0)};
        g.add({at(k % 6), at(k / 6 % 6), at(k / 36)}, random.uniform(0.8e-3, 1e-3), density, motion);
    }
    dem::Solver<3> solver(s, g);
    auto const sums = [&] {
        dem::Vec3 p{}, l{};
        double scale = 0.0;
        for (std::size_t i = 0; i < g.size(); ++i) {
            auto const& m = solver.grains().motion[i];
            p += g.mass[i] * m.velocity;
            l += g.mass[i] * cross(solver.grains().place[i].centre, m.velocity) + g.inertia[i] * m.spin;
            scale += g.mass[i] * norm(m.velocity);
        }
        return std::tuple(p, l, scale);
    };
    auto const [p0, l0, scale] = sums();
    for (int n = 0; n < 5000; ++n) solver.step(1e-6);
    auto const [p1, l1, rest] = sums();
    CHECK(rest < 0.9 * scale);             // they have met
    CHECK(norm(p1 - p0) < 1e-13 * scale);  // rounding
    CHECK(norm(l1 - l0) < 1e-12 * scale * 6.3e-3);
}
