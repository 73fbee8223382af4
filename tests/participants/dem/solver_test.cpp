#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/scenes.hpp"

using namespace unit;

namespace {

bool same(dem::Grains<2> const& a, dem::Grains<2> const& b)
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

TEST_CASE("solver: external force and torque act in both half kicks")
{
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1e-3, density);
    dem::Solver<2> solver(setup(0.0, {0.0, 0.0}), g);
    double const m = g.mass[0], dt = 1e-3;
    solver.grains().external[0].force.x = 2.0 * m;
    solver.grains().external[0].torque = 3.0 * g.inertia[0];
    for (int n = 0; n < 4; ++n) solver.step(dt / 4.0);
    CHECK(solver.grains().motion[0].velocity.x == doctest::Approx(2.0 * dt));
    CHECK(solver.grains().place[0].centre.x == doctest::Approx(dt * dt));  // a t^2 / 2, exact for a constant force
    CHECK(solver.grains().motion[0].spin == doctest::Approx(3.0 * dt));
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
    CHECK(solver.energies().balance() == doctest::Approx(start).epsilon(1e-12));
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
    CHECK(solver.energies().balance() == doctest::Approx(start).epsilon(1e-5));
}

TEST_CASE("solver: overlaps and coincident centres part without NaN and release what the springs held")
{
    for (double overlap : {0.01, 0.05, 0.2, 0.5, 1.0}) {
        dem::Setup<2> s = setup(0.0, {0.0, 0.0});
        s.law = dem::contact_law(contact(0.0, 0.0));
        dem::Grains<2> g;
        g.add({0.0, 0.0}, 1e-3, density);
        g.add({2e-3 * (1.0 - overlap), 0.0}, 1e-3, density);
        dem::Solver<2> solver(s, g);
        double const held = solver.energies().elastic_normal;
        CHECK(held == doctest::Approx(0.5 * stiffness * std::pow(2e-3 * overlap, 2)));
        for (int n = 0; n < 200; ++n) solver.step(step);
        CHECK(solver.energies().kinetic() == doctest::Approx(held).epsilon(0.01));
        CHECK(solver.grains().motion[0].velocity.x == -solver.grains().motion[1].velocity.x);
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
    CHECK(solver.grains().motion[0].velocity.y == doctest::Approx(-9.81 * 0.6 * 1e-3));
    CHECK(solver.grains().mass[0] == doctest::Approx(2500.0 * std::numbers::pi * 1e-6));
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
