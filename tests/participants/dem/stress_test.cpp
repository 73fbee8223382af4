#include "participants/dem/stress.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "participants/dem/measures.hpp"
#include "participants/dem/steady_shear.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

constexpr double pi = std::numbers::pi;

template <int D>
dem::Setup<D> periodic(dem::Vec<D> extent, dem::ContactConfig const& contact)
{
    dem::Setup<D> s;
    s.law = dem::contact_law(contact);
    s.skin = 2e-4;
    s.features = {.friction = true, .periodic = true};
    s.periodic.axis.fill(true);
    s.periodic.extent = extent;
    return s;
}

//! Grains of 1 mm radius on a rectangular array that fills a cell: `count` along each axis, `edge` apart [m].
template <int D>
dem::Solver<D> array(dem::Vec<D> edge, int count)
{
    dem::Grains<D> g;
    int const all = D == 2 ? count * count : count * count * count;
    for (int n = 0; n < all; ++n) {
        dem::Vec<D> at;
        for (int k = 0, rest = n; k < D; ++k, rest /= count)
            dem::component<D>(at, k) = (rest % count + 0.3) * dem::component(edge, k);
        g.add(at, 1e-3, density);
    }
    return {periodic<D>(static_cast<double>(count) * edge, contact(0.5)), g};
}

}  // namespace

TEST_CASE("stress: of a regular array it is force over area, in the cell and in a box of whole meshes anywhere")
{
    dem::Vec2 const edge{1.99e-3, 1.98e-3};  // pressed by 10 and 20 um
    dem::Solver<2> const solver = array<2>(edge, 4);
    auto const check = [&](dem::Averages<2> const& a) {
        CHECK(a.contact[0].x == close_to(stiffness * 10e-6 / edge.y));
        CHECK(a.contact[1].y == close_to(stiffness * 20e-6 / edge.x));
        CHECK(std::abs(a.contact[0].y) < 1e-9 * a.contact[0].x);
        CHECK(std::abs(a.contact[1].x) < 1e-9 * a.contact[0].x);
        CHECK(a.fabric[0].x == close_to(0.5));
        CHECK(a.fabric[1].y == close_to(0.5));
    };
    auto const cell = dem::averages(solver.setup(), solver.state());
    check(cell);
    CHECK(cell.packing_fraction == close_to(pi * 1e-6 / (edge.x * edge.y)));
    CHECK(cell.kinetic[0].x == 0.0);
    for (dem::Vec2 const low : {dem::Vec2{0.0, 0.0}, dem::Vec2{0.4e-3, 1.7e-3}, dem::Vec2{3.1e-3, 0.2e-3}}) {
        auto const box = dem::averages<2>(solver.setup(), solver.state(), dem::Box<2>{low, low + 2.0 * edge});
        check(box);
        CHECK(box.packing_fraction == close_to(cell.packing_fraction).epsilon(5e-3));  // clipped in 64 strips
    }
}

TEST_CASE("stress: of spheres on a regular array")
{
    dem::Vec3 const edge{1.99e-3, 1.98e-3, 1.96e-3};
    dem::Solver<3> const solver = array<3>(edge, 3);
    auto const a = dem::averages(solver.setup(), solver.state());
    CHECK(a.contact[0].x == close_to(stiffness * 10e-6 / (edge.y * edge.z)));
    CHECK(a.contact[1].y == close_to(stiffness * 20e-6 / (edge.x * edge.z)));
    CHECK(a.contact[2].z == close_to(stiffness * 40e-6 / (edge.x * edge.y)));
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(a.fabric[k].z - (k == 2 ? 1.0 / 3.0 : 0.0)) < 1e-12);
    CHECK(a.packing_fraction == close_to(4.0 / 3.0 * pi * 1e-9 / (edge.x * edge.y * edge.z)));
    dem::Vec3 const low{1e-3, 0.1e-3, 2.5e-3};
    auto const box = dem::averages<3>(solver.setup(), solver.state(), dem::Box<3>{low, low + edge});
    CHECK(box.contact[2].z == close_to(a.contact[2].z));
}

TEST_CASE("stress: times the area it is what a wall feels, also under weight")
{
    // 3 columns of 5 discs on a floor; the contact below disc k carries 5 - k discs
    dem::Setup<2> s = setup(0.5, {0.0, -9.81});
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    double const weight = density * pi * 1e-6 * 9.81, width = 3 * 3e-3;
    for (int column = 0; column < 3; ++column) {
        double y = 1e-3 - 5.0 * weight / stiffness;
        for (int k = 0; k < 5; ++k) {
            g.add({3e-3 * column + 1.5e-3, y}, 1e-3, density);
            y += 2e-3 - (4.0 - k) * weight / stiffness;
        }
    }
    dem::Solver<2> const solver(s, g);
    auto const within = [&](double low, double high) {
        return dem::averages<2>(solver.setup(), solver.state(), dem::Box<2>{{0.0, low}, {width, high}}).contact[1].y;
    };
    CHECK(dem::wall_reaction(solver, 0).y == close_to(15.0 * weight));
    CHECK(within(0.0, 0.5e-3) * width == close_to(dem::wall_reaction(solver, 0).y));
    CHECK(within(3.2e-3, 4.8e-3) * width == close_to(3.0 * 3.0 * weight));                // between discs 1 and 2
    CHECK(within(1.5e-3, 4.5e-3) * width == close_to(3.0 * 3.5 * weight).epsilon(1e-3));  // half 4, half 3
}

TEST_CASE("stress: the kinetic part counts what is beyond the mean flow, and beyond the shear")
{
    dem::Setup<2> s = periodic<2>({0.02, 0.02}, contact(0.5));
    dem::Grains<2> g;
    double const mass = density * pi * 1e-6;
    for (int k = 0; k < 4; ++k) {
        double const sign = k % 2 ? 1.0 : -1.0;
        g.add({2.5e-3 + 5e-3 * k, 0.01}, 1e-3, density, {{3.0 + sign * 0.2, 7.0 + sign * 0.1}, 5.0});
    }
    auto const a = dem::averages(s, dem::Solver<2>(s, g).state());
    CHECK(a.kinetic[0].x == close_to(4 * mass * 0.04 / 4e-4));
    CHECK(a.kinetic[0].y == close_to(4 * mass * 0.02 / 4e-4));
    CHECK(a.kinetic[1].y == close_to(4 * mass * 0.01 / 4e-4));
    CHECK(a.contacts == 0.0);
    auto along_x = s;  // one axis has no images: a box sees each grain once
    along_x.periodic.axis = {true, false};
    along_x.periodic.extent = {0.02, 0.0};
    auto const box =
        dem::averages<2>(along_x, dem::Solver<2>(along_x, g).state(), dem::Box<2>{{0.0, 0.0}, {0.02, 0.02}});
    CHECK(box.kinetic[0].x == close_to(a.kinetic[0].x));
    CHECK(box.packing_fraction == close_to(a.packing_fraction).epsilon(1e-3));  // by strips
    s.periodic.shear.rate = 50.0;
    for (std::size_t k = 0; k < 4; ++k) {
        g.place[k].centre.y = 2e-3 + 5e-3 * static_cast<double>(k);
        g.motion[k].velocity = {50.0 * g.place[k].centre.y - 0.3, 0.1};
    }
    auto const flow = dem::averages(s, dem::Solver<2>(s, g).state());
    CHECK(std::abs(flow.kinetic[0].x) < 1e-12 * a.kinetic[0].x);
    CHECK(std::abs(flow.kinetic[1].y) < 1e-12 * a.kinetic[0].x);
}

TEST_CASE("stress: pair by pair it is the virial of the forces that act on the grains")
{
    // without dashpots the forces depend on the places and the springs alone
    dem::ContactConfig c = contact(0.5, 0.0);
    c.tangential_damping = 0.0;
    dem::Setup<2> s = periodic<2>({8 * 2.02e-3, 8 * 2.02e-3}, c);
    s.periodic.shear = {.along = 0, .across = 1, .rate = 30.0};
    dem::Random random(7);
    dem::Grains<2> g;
    for (int k = 0; k < 64; ++k)
        g.add({(k % 8 + 0.5) * 2.02e-3, (k / 8 + 0.5) * 2.02e-3}, random.uniform(0.95e-3, 1.02e-3), density,
              {{random.uniform(-0.3, 0.3), 0.0}, 0.0});
    dem::Solver<2> solver(s, g);
    for (int n = 0; n < 3000; ++n) solver.step(2e-6);
    auto const a = dem::averages(solver.setup(), solver.state());
    REQUIRE(a.contacts > 5.0);
    double drift = 0.0, mass = 0.0, bulk = 0.0;  // the mean motion across counts in the one only
    auto const& now = solver.grains();
    for (std::size_t i = 0; i < now.size(); ++i) drift += now.mass[i] * now.motion[i].velocity.y, mass += now.mass[i];
    bulk = drift * drift / mass / a.volume;
    CHECK(dem::stress_across(solver.setup(), solver.state()) - bulk == close_to(a.stress(1, 1)).epsilon(1e-9));
}

TEST_CASE("stress: the friction angle of a tensor, and means and spreads over a steady part")
{
    dem::Averages<2> a;
    a.contact = {dem::Vec2{3.0, 0.0}, dem::Vec2{0.0, 1.0}};
    CHECK(dem::friction_angle(a, 0, 1) == close_to(pi / 6.0));  // (3 - 1)/(3 + 1) = sin 30 deg
    a.contact = {dem::Vec2{2.0, -1.0}, dem::Vec2{-1.0, 2.0}};
    CHECK(dem::friction_angle(a, 0, 1) == close_to(pi / 6.0));  // the same, turned by 45 deg

    dem::Setup<2> s = array<2>({1.99e-3, 1.98e-3}, 4).setup();
    s.periodic.shear = {.along = 0, .across = 1, .rate = 1e-3, .steady_from = 0.0};
    dem::Solver<2> const solver(s, array<2>({1.99e-3, 1.98e-3}, 4).grains());
    dem::SteadyShear steady;
    CHECK(steady.facts().size() == 1);  // the strain
    for (int n = 0; n < 3; ++n) steady.sample(solver);
    sluice::State state;
    steady.keep(state);
    auto const facts = dem::SteadyShear::kept(state).facts();
    CHECK(facts == steady.facts());
    auto const of = [&](std::string const& name) {
        for (auto const& [key, value] : facts)
            if (key == name) return value;
        return std::nan("");
    };
    double const x = stiffness * 10e-6 / 1.98e-3, y = stiffness * 20e-6 / 1.99e-3;
    CHECK(of("friction angle [deg]") == close_to(std::asin((y - x) / (y + x)) * 180.0 / pi));
    CHECK(of("friction angle, spread [deg]") < 1e-6);
    CHECK(of("normal stress [Pa]") == close_to(y));
    CHECK(of("inertial number") == close_to(1e-3 * 2e-3 * std::sqrt(density / y)));
}
