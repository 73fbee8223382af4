#include "participants/dem/neighbours.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "tests/participants/dem/scenes.hpp"

namespace {

//! Every pair by brute force, in the order of the list.
template <int D>
void check_against_all(dem::Grains<D> const& g, double reach)
{
    std::vector<std::uint32_t> first, other;
    dem::find_pairs(g, reach, first, other);
    REQUIRE(first.size() == g.size() + 1);
    std::vector<std::uint32_t> expected;
    for (std::size_t i = 0; i < g.size(); ++i) {
        CHECK(first[i] == expected.size());
        for (std::size_t j = i + 1; j < g.size(); ++j) {
            double const near = g.place[i].radius + g.place[j].radius + reach;
            auto const apart = g.place[i].centre - g.place[j].centre;
            if (dot(apart, apart) < near * near) expected.push_back(static_cast<std::uint32_t>(j));
        }
    }
    CHECK(other == expected);
}

//! Spheres of radii from 1 to `ratio` mm, evenly in their logarithm, anywhere in a box.
dem::Grains<3> spheres(int count, double ratio, std::uint64_t seed)
{
    dem::Random random(seed);
    dem::Grains<3> g;
    double const side = 2e-3 * ratio * 3.0;
    for (int k = 0; k < count; ++k) {
        auto const at = [&] { return random.uniform(-side, side); };
        g.add({at(), at(), at()}, 1e-3 * std::pow(ratio, random.uniform()), 2650.0);
    }
    return g;
}

}  // namespace

TEST_CASE("neighbours: the grid finds what all pairs find")
{
    check_against_all(unit::loose(15, 1), 2e-4);
    check_against_all(unit::loose(15, 2), 0.0);
    check_against_all(unit::loose(1, 1), 1e-3);
}

TEST_CASE("neighbours: a few grains flung far, coincident centres and a row")
{
    dem::Grains<2> g = unit::loose(8, 3);
    g.add({1e4, -2e4}, 1e-3, 2650.0);
    g.add({-3e5, 1.0}, 1e-3, 2650.0);
    g.add({g.place[0].centre.x, g.place[0].centre.y}, 1e-3, 2650.0);
    check_against_all(g, 1e-4);
    dem::Grains<2> row;
    for (int k = 0; k < 50; ++k) row.add({k * 1e-3, 0.0}, 0.5e-3, 2650.0);
    check_against_all(row, 1e-5);
    check_against_all(dem::Grains<2>{}, 1e-3);
}

TEST_CASE("neighbours: sizes that differ by a factor of ten")
{
    dem::Grains<2> g = unit::loose(10, 4);
    g.add({9e-3, 9e-3}, 8e-3, 2650.0);
    check_against_all(g, 2e-4);
}

TEST_CASE("neighbours: spheres, alike and of sizes that differ by a factor of twenty and of a hundred")
{
    check_against_all(spheres(400, 1.0, 1), 2e-4);
    check_against_all(spheres(400, 1.8, 2), 2e-4);
    check_against_all(spheres(1500, 20.0, 3), 2e-4);
    check_against_all(spheres(800, 100.0, 4), 0.0);
    dem::Grains<3> gap = spheres(400, 1.0, 5);  // and nothing between
    gap.add({}, 8e-3, 2650.0);
    check_against_all(gap, 2e-4);
}

TEST_CASE("neighbours: springs survive a rebuild, by pair and by wall")
{
    dem::Solver<2> solver = unit::box();
    for (int n = 0; n < 30000; ++n) solver.step(unit::step);
    auto const before = dem::records_of(solver.state());
    REQUIRE(before.size() > 50);
    dem::State<2> state = solver.state();
    dem::rebuild_lists(solver.setup(), state);
    auto const after = dem::records_of(state);
    REQUIRE(after.size() == before.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
        CHECK(after[k].first == before[k].first);
        CHECK(after[k].second == before[k].second);
        CHECK(after[k].friction == before[k].friction);
    }
}
