#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/dem/neighbours.hpp"
#include "participants/dem/periodic_cell.hpp"
#include "participants/dem/stress.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/periodic_scenes.hpp"
#include "tests/support/close_to.hpp"

using unit::cell, unit::cube, unit::gas, unit::sheared;

namespace {

using dem::Vec2;
using dem::Vec3;

constexpr double dt = unit::periodic_step;

template <int D>
bool same(dem::State<D> const& a, dem::State<D> const& b)
{
    for (std::size_t i = 0; i < a.grains.size(); ++i)
        if (a.grains.place[i].centre != b.grains.place[i].centre ||
            a.grains.motion[i].velocity != b.grains.motion[i].velocity ||
            a.grains.motion[i].spin != b.grains.motion[i].spin)
            return false;
    return a.pairs.history.friction == b.pairs.history.friction && a.pairs.history.rolling == b.pairs.history.rolling &&
           a.cell.pull == b.cell.pull && a.cell.offset == b.cell.offset && a.cell.extent == b.cell.extent;
}

}  // namespace

TEST_CASE("periodic: the lists hold the nearest images of all pairs, and no other")
{
    auto const check = [](auto solver) {
        auto const& s = solver.state();
        auto const& g = s.grains;
        std::size_t found = 0;
        for (std::uint32_t i = 0; i < g.size(); ++i)
            for (std::uint32_t j = i + 1; j < g.size(); ++j) {
                std::vector<std::uint32_t> near;
                for (std::uint32_t image = 0; image < s.cell.images.size(); ++image) {
                    auto const apart = g.place[i].centre - (g.place[j].centre + s.cell.images[image].shift);
                    double const reach = g.place[i].radius + g.place[j].radius + solver.setup().skin;
                    if (dot(apart, apart) < reach * reach) near.push_back(image);
                }
                REQUIRE(near.size() <= 1);
                auto const begin = s.pairs.other.begin() + s.pairs.first[i],
                           end = s.pairs.other.begin() + s.pairs.first[i + 1];
                auto const at = std::find(begin, end, j);
                REQUIRE((at != end) == (near.size() == 1));
                if (at == end) continue;
                ++found;
                CHECK(s.pairs.image[static_cast<std::size_t>(at - s.pairs.other.begin())] == near[0]);
            }
        CHECK(found == s.pairs.other.size());
        CHECK(std::ranges::count_if(s.pairs.image, [&](auto image) { return image != s.cell.images.size() / 2; }) > 10);
    };
    auto const wide = [](auto setup) {
        setup.skin = 1e-3;
        return setup;
    };
    check(dem::Solver<2>(wide(cell<2>(cube<2>(8))), gas<2>(8, 0.0)));
    check(dem::Solver<3>(wide(cell<3>(cube<3>(5))), gas<3>(5, 0.0)));
    auto const all = gas<2>(8, 0.0);
    dem::Grains<2> three;  // rows, in a cell as high, but some of them a few cells up or down
    for (std::size_t i = 0; i < 24; ++i)
        three.add(all.place[i].centre + dem::Vec2{0.0, (static_cast<double>(i % 5) - 2) * 3 * 2.1e-3},
                  all.place[i].radius, unit::density);
    check(dem::Solver<2>(wide(cell<2>({2.1e-3 * 8, 2.1e-3 * 3})), three));
    dem::Setup<3> sheared = wide(cell<3>(cube<3>(5)));
    sheared.periodic.shear.rate = 1e-3;
    dem::State<3> state = dem::Solver<3>(sheared, gas<3>(5, 0.0)).state();
    for (double const share : {0.2, 0.49, 0.51, 0.9, 3.3}) {
        state.cell.offset = share * 2.1e-3 * 5;
        dem::rebuild_lists(sheared, state);
        CHECK(std::abs(state.cell.offset) <= 0.5 * 2.1e-3 * 5);
        dem::Solver<3> solver(sheared, gas<3>(5, 0.0));
        solver.restore(state);
        check(solver);
    }
}

TEST_CASE("periodic: momentum is kept to rounding, and grains come back on the other side")
{
    auto const check = [](auto solver) {
        auto const start = solver.grains();
        auto sum = [&] {
            auto p = start.motion[0].velocity - start.motion[0].velocity;
            for (std::size_t i = 0; i < start.size(); ++i) p += start.mass[i] * solver.grains().motion[i].velocity;
            return p;
        };
        double scale = 0.0;
        for (std::size_t i = 0; i < start.size(); ++i) scale += start.mass[i] * norm(start.motion[i].velocity);
        auto const before = sum();
        int crossed = 0;
        for (int n = 0; n < 10000; ++n) {
            auto const places = solver.grains().place;
            solver.step(dt);
            for (std::size_t i = 0; i < places.size(); ++i)
                crossed += std::abs(solver.grains().place[i].centre.x - places[i].centre.x) > 5e-3;
        }
        CHECK(crossed > 3);
        CHECK(norm(sum() - before) < 1e-13 * scale);
        for (auto const& place : solver.grains().place) {  // outside by half a skin at most, until the lists are built
            CHECK(place.centre.x > -1.1e-4);
            CHECK(place.centre.x < solver.setup().periodic.extent.x + 1.1e-4);
        }
    };
    check(dem::Solver<2>(cell<2>(cube<2>(8)), gas<2>(8, 1.0)));
    check(dem::Solver<3>(cell<3>(cube<3>(5)), gas<3>(5, 1.0)));
}

TEST_CASE("periodic: two grains that meet across a side do as two that meet within")
{
    dem::Setup<3> const s = cell<3>({0.01, 0.01, 0.01});
    auto const meet = [&](Vec3 middle) {
        dem::Grains<3> g;
        auto const wrapped = [](Vec3 at) {
            dem::each_number(at, [](double& x) { x -= 0.01 * std::floor(x / 0.01); });
            return at;
        };
        g.add(wrapped(middle - Vec3{0.8e-3, 0.5e-3, 0.2e-3}), 1e-3, unit::density, {{0.3, 0.2, 0.1}, {50, -30, 80}});
        g.add(wrapped(middle + Vec3{0.8e-3, 0.7e-3, 0.1e-3}), 0.9e-3, unit::density, {{-0.4, 0.0, 0.2}, {0, 90, 10}});
        dem::Solver<3> solver(s, g);
        double pressed = 0.0;
        for (int n = 0; n < 1500; ++n) {
            solver.step(dt);
            pressed = std::max(pressed, norm(solver.grains().contact[0].force));
        }
        CHECK(pressed > 0.1);
        return solver.grains().motion;
    };
    auto const within = meet({0.005, 0.005, 0.005});
    for (Vec3 const at : {Vec3{0.0, 0.005, 0.005}, Vec3{0.01, 0.01, 0.005}, Vec3{0.0, 0.01, 0.0}}) {
        auto const across = meet(at);
        for (std::size_t i = 0; i < 2; ++i) {
            CHECK(norm(across[i].velocity - within[i].velocity) < 1e-10);
            CHECK(norm(across[i].spin - within[i].spin) < 1e-7);
        }
    }
}

TEST_CASE("periodic: a system that is moved as a whole does the same to rounding")
{
    auto const run = [](Vec2 by) {
        dem::Grains<2> g = gas<2>(8, 0.5);
        for (auto& place : g.place) place.centre += by;  // put back by the solver
        dem::Solver<2> solver(cell<2>(cube<2>(8)), g);
        for (int n = 0; n < 3000; ++n) solver.step(dt);
        return solver.grains();
    };
    auto const a = run({}), b = run({3.3e-3, 11e-3});
    double worst = 0.0, changed = 0.0;
    auto const start = gas<2>(8, 0.5);
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, norm(a.motion[i].velocity - b.motion[i].velocity));
        changed += norm(a.motion[i].velocity - start.motion[i].velocity) > 0.1;
    }
    CHECK(changed > 32);  // they have met
    CHECK(worst < 1e-9);
}

TEST_CASE("periodic: without sides near, the images change no bit")
{
    dem::Setup<3> within = cell<3>({0.1, 0.1, 0.1}), open = within;
    within.periodic.low = {-0.05, -0.05, -0.05};
    open.features.periodic = false;
    dem::Solver<3> a(within, gas<3>(5, 1.0)), b(open, gas<3>(5, 1.0));
    for (int n = 0; n < 2000; ++n) a.step(dt), b.step(dt);
    for (std::size_t i = 0; i < a.grains().size(); ++i) {
        CHECK(a.grains().place[i].centre == b.grains().place[i].centre);
        CHECK(a.grains().motion[i].velocity == b.grains().motion[i].velocity);
    }
}

TEST_CASE("periodic: packs, threads and ledger change no bit, at rest and under shear")
{
    auto const check = [](std::function<dem::Solver<3>(bool ledger, bool plain, int threads)> make, int steps) {
        dem::Solver<3> packed = make(false, false, 1), plain = make(false, true, 1), two = make(false, false, 2),
                       five = make(false, false, 5), booked = make(true, false, 1), plainly = make(true, true, 1),
                       by_two = make(true, false, 2);
        REQUIRE(two.state().pairs.ranges.size() == 2);
        for (int n = 0; n < steps; ++n) {
            for (auto* solver : {&packed, &plain, &two, &five, &booked, &plainly, &by_two}) solver->step(dt);
            if (n % 500 == 0) REQUIRE(same(packed.state(), plain.state()));
        }
        CHECK(unit::same_books(booked.state(), plainly.state()));
        CHECK(unit::same_books(booked.state(), by_two.state()));
        CHECK(same(packed.state(), plain.state()));
        CHECK(same(packed.state(), two.state()));
        CHECK(same(packed.state(), five.state()));
        CHECK(same(packed.state(), booked.state()));
        CHECK(packed.state().rebuilds > 5);
    };
    check(
        [](bool ledger, bool plain, int threads) {
            dem::Setup<3> s = cell<3>(cube<3>(5), 0.5, ledger);
            s.plain = plain;
            s.threads = threads;
            return dem::Solver<3>(s, gas<3>(5, 1.0));
        },
        2000);
    check(sheared<3>, 3000);
    dem::Solver<2> a = sheared<2>(), b = sheared<2>(true);
    for (int n = 0; n < 5000; ++n) a.step(dt), b.step(dt);
    CHECK(same(a.state(), b.state()));
}

TEST_CASE("periodic: a restored solver continues bit for bit")
{
    auto const check = [](auto make) {
        for (bool const ledger : {false, true}) {
            auto a = make(ledger);
            for (int n = 0; n < 3000; ++n) a.step(dt);
            auto const bytes = unit::kept(a).encode();
            for (int n = 0; n < 3000; ++n) a.step(dt);
            decltype(a) b(a.setup(), {});
            b.restore(dem::kept_state(sluice::State::decode(bytes, "state"), b.setup(), a.grains().size()));
            for (int n = 0; n < 3000; ++n) b.step(dt);
            CHECK(unit::kept(a) == unit::kept(b));
            CHECK(same(a.state(), b.state()));
        }
    };
    check([](bool ledger) { return sheared<2>(ledger); });
    check([](bool ledger) { return sheared<3>(ledger); });
}

TEST_CASE("periodic: the ledger closes, at rest and while images move and grains cross")
{
    auto const check = [](auto solver, double work) {
        double const start = solver.energies().balance(), kinetic = solver.energies().kinetic();
        double worst = 0.0;
        for (int n = 0; n < 20000; ++n) {
            solver.step(dt);
            worst = std::max(worst, std::abs(solver.energies().balance() - start));
        }
        CHECK(solver.energies().lost() > 0.3 * kinetic);
        CHECK(std::abs(solver.energies().wall_work) >= work * kinetic);
        CHECK(worst < 1e-4 * kinetic);  // the mark of C08 for a collapse
    };
    check(dem::Solver<2>(cell<2>(cube<2>(8), 0.5, true), gas<2>(8, 1.0)), 0.0);
    check(sheared<2>(true), 0.1);
    check(sheared<3>(true), 0.05);
    dem::Setup<2> chute = cell<2>(cube<2>(8), 0.5, true);  // gravity along a periodic axis, a floor below
    chute.gravity = {5.0, -9.81};
    chute.periodic.axis = {true, false};
    unit::add_wall(chute, "floor", {0.0, 0.0}, {0.0, 1.0});
    check(dem::Solver<2>(chute, gas<2>(8, 1.0)), 5e-4);
}

TEST_CASE("periodic: two grains that meet across a sheared side do as two in the open")
{
    double const rate = 40.0, height = 0.01;
    dem::Setup<2> s = cell<2>({0.02, height});
    s.periodic.shear = {.along = 0, .across = 1, .rate = rate};
    dem::Grains<2> g;
    g.add({5e-3, height - 0.9e-3}, 1e-3, unit::density, {{0.0, 0.3}, 20.0});
    g.add({4.6e-3, 1.2e-3}, 1e-3, unit::density, {{-rate * height + 0.1, -0.2}, 0.0});
    dem::Solver<2> across(s, g);
    dem::Setup<2> open = s;
    open.features.periodic = false;
    open.periodic = {};
    g.place[1].centre.y += height;
    g.motion[1].velocity.x += rate * height;
    dem::Solver<2> within(open, g);
    double pressed = 0.0;
    for (int n = 0; n < 1500; ++n) {
        across.step(dt);
        within.step(dt);
        pressed = std::max(pressed, norm(across.grains().contact[0].force));
    }
    CHECK(pressed > 1.0);
    for (std::size_t i = 0; i < 2; ++i) {
        // a grain that has been put back since has the velocity of its image
        double const n = std::round((within.grains().place[i].centre.y - across.grains().place[i].centre.y) / height);
        Vec2 const seen = across.grains().motion[i].velocity + Vec2{n * rate * height, 0.0};
        CHECK(norm(seen - within.grains().motion[i].velocity) < 1e-10);
        CHECK(std::abs(across.grains().motion[i].spin - within.grains().motion[i].spin) < 1e-7);
    }
}

TEST_CASE("periodic: under shear the momentum beyond that of the flow is kept to rounding")
{
    dem::Setup<3> s = cell<3>(cube<3>(6));
    s.periodic.shear = {.along = 2, .across = 0, .rate = 40.0};
    dem::Grains<3> g = gas<3>(6, 0.5);
    Vec3 drift{};
    double mass = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) drift += g.mass[i] * g.motion[i].velocity, mass += g.mass[i];
    for (auto& motion : g.motion) motion.velocity -= (1.0 / mass) * drift;
    dem::Solver<3> solver(s, g);
    auto const beyond = [&] {
        Vec3 sum{};
        auto const& now = solver.grains();
        for (std::size_t i = 0; i < g.size(); ++i) {
            sum += g.mass[i] * now.motion[i].velocity;
            sum.z -= g.mass[i] * 40.0 * now.place[i].centre.x;
        }
        return sum;
    };
    Vec3 const before = beyond();
    for (auto const& motion : g.motion) scale += g.mass[0] * norm(motion.velocity);
    for (int n = 0; n < 5000; ++n) solver.step(dt);
    CHECK(solver.state().cell.strain == close_to(0.4));
    CHECK(norm(beyond() - before) < 1e-12 * scale);
}

TEST_CASE("periodic: the height follows a pressure")
{
    // one column of grains that touch: pressure times breadth is the force in it
    dem::Setup<2> s = cell<2>({5e-3, 3 * 2e-3});
    s.periodic.shear = {.along = 0, .across = 1, .rate = 1e-9, .pressure = 20.0, .impedance = 1e5};
    dem::Grains<2> g;
    for (int k = 0; k < 3; ++k) g.add({1e-3, (2 * k + 1) * 1e-3}, 1e-3, unit::density);
    dem::Solver<2> solver(s, g);
    for (int n = 0; n < 15000; ++n) solver.step(dt);
    CHECK(dem::stress_across(solver.setup(), solver.state()) == close_to(20.0).epsilon(1e-6));
    double const overlap = 20.0 * 5e-3 / unit::stiffness;
    CHECK(solver.state().cell.extent.y == close_to(3 * (2e-3 - overlap)).epsilon(1e-9));
}

TEST_CASE("periodic: a cell that has become too small for one image of each grain ends the run")
{
    dem::Setup<2> s = cell<2>({6e-3, 6e-3});
    s.periodic.shear = {.along = 0, .across = 1, .rate = 1e-9, .pressure = 1e3, .impedance = 1e3};
    dem::Grains<2> g;
    g.add({3e-3, 3e-3}, 1e-3, unit::density);
    dem::Solver<2> solver(s, g);
    CHECK_THROWS_WITH_AS(
        [&] {
            for (int n = 0; n < 1000; ++n) solver.step(dt);
        }(),
        doctest::Contains("m along y at t = "), sluice::Error);
}
