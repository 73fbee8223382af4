#include "participants/dem/front.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/support/close_to.hpp"

namespace {

constexpr double pi = std::numbers::pi;

//! `count` spheres of radius 4 mm at even angles over `angle`, at the distance from the axis that `at(angle)` says.
template <class Distance>
dem::Grains<3> ring(int count, double angle, Distance at)
{
    dem::Grains<3> g;
    for (int k = 0; k < count; ++k) {
        double const a = (k + 0.5) / count * angle, r = at(a);
        g.add({r * std::cos(a), r * std::sin(a), 0.01 * (k % 3)}, 4e-3, 2650.0);
    }
    return g;
}

}  // namespace

TEST_CASE("front: of a round column the reach of the outermost grains, in a quarter and in a full circle")
{
    for (double const angle : {0.5 * pi, 2.0 * pi}) {
        auto g = ring(64, angle, [](double) { return 0.1; });
        auto const inner = ring(64, angle, [](double) { return 0.05; });
        for (auto const& place : inner.place) g.add(place.centre, place.radius, 2650.0);
        auto const reach = dem::reach_of(g, {16, angle, 90.0});
        REQUIRE(reach.size() == 16);
        for (double const r : reach) CHECK(r == close_to(0.104).epsilon(1e-12));
        CHECK(dem::front_of(reach, 90.0) == close_to(0.104).epsilon(1e-12));
    }
}

TEST_CASE("front: each sector has the reach of its own grains, and sector k begins at k times its width")
{
    auto const reach =
        dem::reach_of(ring(16, 2.0 * pi, [](double a) { return 0.05 + 0.01 * a; }), {16, 2.0 * pi, 90.0});
    for (int k = 0; k < 16; ++k)
        CHECK(reach[static_cast<std::size_t>(k)] ==
              close_to(0.05 + 0.01 * (k + 0.5) / 16 * 2.0 * pi + 4e-3).epsilon(1e-12));
}

TEST_CASE("front: a grain that rolls ahead alone is an outlier, and a sector without grains counts for nothing")
{
    auto g = ring(16, 0.5 * pi, [](double) { return 0.1; });
    g.add({0.5 * std::cos(0.7), 0.5 * std::sin(0.7), 4e-3}, 4e-3, 2650.0);
    dem::Sectors const sectors{16, 0.5 * pi, 90.0};
    CHECK(dem::front_of(dem::reach_of(g, sectors), 90.0) == close_to(0.104).epsilon(1e-12));
    CHECK(dem::front_of(dem::reach_of(g, sectors), 100.0) == close_to((15 * 0.104 + 0.504) / 16).epsilon(1e-12));

    auto const few = ring(4, 0.5 * pi, [](double) { return 0.2; });  // 12 sectors of 16 are empty
    auto const reach = dem::reach_of(few, sectors);
    CHECK(std::count(reach.begin(), reach.end(), 0.0) == 12);
    CHECK(dem::front_of(reach, 90.0) == close_to(0.204).epsilon(1e-12));
    CHECK(dem::front_of({0.0, 0.0}, 90.0) == 0.0);
}

TEST_CASE("front: the percentile is interpolated between ranks, as numpy does")
{
    // of 1, 2, ..., 16 numpy.percentile(..., 90) is 14.5: the mean of what is not above it is that of 1 to 14
    std::vector<double> reach;
    for (int k = 16; k >= 1; --k) reach.push_back(k);
    CHECK(dem::front_of(reach, 90.0) == close_to(7.5));
    CHECK(dem::front_of(reach, 100.0) == close_to(8.5));
    CHECK(dem::front_of(reach, 0.0) == 1.0);
}
