#include "participants/dem/measures.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

TEST_CASE("measures: the front is that of the main mass, the foremost grain that of all")
{
    dem::Setup<2> s = setup(0.0);
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    for (int k = 0; k < 5; ++k) g.add({(2 * k + 1) * 0.9999e-3, 0.9999e-3}, 1e-3, density);
    g.add({0.05, 2e-3}, 1e-3, density, {{0.3, 0.0}, 0.0});
    dem::Solver<2> const solver(s, g);
    dem::Measures<2> const m = dem::measure(solver);
    CHECK(m.front == close_to(9 * 0.9999e-3 + 1e-3));
    CHECK(m.foremost == close_to(0.051));
    CHECK(m.height == close_to(1.9999e-3));
    CHECK(m.kinetic == close_to(0.5 * g.mass[5] * 0.09));
    CHECK(m.contacts == 9);  // 4 pairs, 5 on the floor
    CHECK(m.rattlers == 1);
    CHECK(m.coordination == close_to((2 + 3 + 3 + 3 + 2) / 5.0));
    CHECK(m.largest_overlap == close_to(1e-4).epsilon(1e-6));
    CHECK(dem::wall_reaction(solver, 0).y == close_to(5 * stiffness * 1e-7).epsilon(1e-6));
}

TEST_CASE("measures: packing fraction clips discs at the edges")
{
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1.0, density);
    CHECK(dem::packing_fraction<2>(g, {-1.0, -1.0}, {1.0, 1.0}) == close_to(std::numbers::pi / 4.0).epsilon(2e-3));
    CHECK(dem::packing_fraction<2>(g, {0.0, 0.0}, {2.0, 2.0}) == close_to(std::numbers::pi / 16.0).epsilon(2e-3));
    CHECK(dem::packing_fraction<2>(g, {5.0, 0.0}, {6.0, 1.0}) == 0.0);
}

TEST_CASE("measures: grains by their number of contacts, with and without walls")
{
    dem::Setup<2> s = setup(0.0);
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    dem::Grains<2> g;
    for (int k = 0; k < 5; ++k) g.add({(2 * k + 1) * 0.9999e-3, 0.9999e-3}, 1e-3, density);
    g.add({0.05, 2e-3}, 1e-3, density);
    dem::Solver<2> const solver(s, g);
    auto const with = [&](dem::Partners partners, std::size_t most) {
        return dem::coordination_of(dem::contacts_of_grains(solver.setup(), solver.state(), partners), most);
    };
    auto const all = with(dem::Partners::grains_and_walls, 4);
    CHECK(all.grains == std::vector{1.0, 0.0, 2.0, 3.0, 0.0});
    CHECK(all.mean == close_to(13.0 / 6.0));
    CHECK(all.bearing == close_to(13.0 / 5.0));
    CHECK(all.rattlers == 1);
    auto const pairs = with(dem::Partners::grains, 4);
    CHECK(pairs.grains == std::vector{1.0, 2.0, 3.0, 0.0, 0.0});
    CHECK(pairs.mean == close_to(8.0 / 6.0));
    CHECK(pairs.bearing == close_to(2.0));
    CHECK(pairs.rattlers == 3);
    CHECK(with(dem::Partners::grains_and_walls, 2).grains == std::vector{1.0, 0.0, 5.0});  // the last: 2 or more
}
