#include "participants/dem/profile.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "participants/dem/random.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

TEST_CASE("profile: a grain is cut by the planes between slices, disc and sphere by their closed forms")
{
    dem::Grains<2> disc;
    disc.add({1.0, 3.0}, 0.5, density);
    auto const cut = dem::profile_of(disc, {1.0, false});
    REQUIRE(cut.position == std::vector{0.5, 1.5});
    CHECK(cut.mass[0] == close_to(0.5 * disc.mass[0]).epsilon(1e-14));
    CHECK(cut.mass[1] == close_to(0.5 * disc.mass[0]).epsilon(1e-14));
    CHECK(cut.surface == std::vector{3.5, 3.5});

    dem::Grains<3> sphere;
    sphere.add({0.75, 0.0, 2.0}, 0.5, density);  // the plane x = 1 is half a radius beyond the centre
    auto const cap = dem::profile_of(sphere, {1.0, false});
    double const h = 0.25, volume = std::numbers::pi * h * h * (3 * 0.5 - h) / 3;  // of the cap beyond it
    REQUIRE(cap.mass.size() == 2);
    CHECK(cap.mass[1] == close_to(density * volume).epsilon(1e-13));
    CHECK(cap.mass[0] + cap.mass[1] == close_to(sphere.mass[0]).epsilon(1e-14));
    CHECK(cap.surface[0] == close_to(2.5));
    CHECK(cap.surface[1] == close_to(2.0 + std::sqrt(0.25 - 0.0625)));
}

TEST_CASE("profile: slices add up to the mass of all grains, wherever they lie and whatever the width")
{
    dem::Random random(3);
    dem::Grains<3> g;
    for (int k = 0; k < 300; ++k)
        g.add({random.uniform(-0.1, 0.2), random.uniform(0.0, 0.3), random.uniform(0.0, 0.1)},
              random.uniform(1e-3, 8e-3), density);
    double const mass = std::accumulate(g.mass.begin(), g.mass.end(), 0.0);
    for (bool const radial : {false, true})
        for (double const width : {1e-3, 7e-3, 0.05, 10.0}) {
            auto const p = dem::profile_of(g, {width, radial});
            CHECK(std::accumulate(p.mass.begin(), p.mass.end(), 0.0) == close_to(mass).epsilon(1e-13));
            CHECK(p.position.size() == p.mass.size());
            CHECK(p.position[0] > (radial ? 0.0 : -0.11 - width));
        }
}

TEST_CASE("profile: rings about the axis hold a disc of even mass in proportion to their area")
{
    dem::Grains<3> g;
    for (int i = -200; i <= 200; ++i)  // a plate of small spheres on a square grid, radius 0.2
        for (int k = -200; k <= 200; ++k)
            if (std::hypot(i, k) <= 200.0) g.add({i * 1e-3, k * 1e-3, 0.0}, 0.5e-3, density);
    auto const p = dem::profile_of(g, {0.05, true});
    for (std::size_t k = 0; k < 4; ++k) {
        double const area = std::numbers::pi * 0.0025 * (2.0 * static_cast<double>(k) + 1.0);
        CHECK(p.mass[k] == close_to(g.mass[0] * area / 1e-6).epsilon(0.01));  // of the grid
    }
}

TEST_CASE("profile: the surface is that of the main mass, not of a grain in flight")
{
    dem::Grains<2> g;
    for (int k = 0; k < 20; ++k) g.add({(2 * k + 1) * 1e-3, 1e-3}, 1e-3, density);
    g.add({0.01, 0.05}, 1e-3, density);
    auto const p = dem::profile_of(g, {4e-3, false});
    REQUIRE(p.surface.size() >= 10);
    for (std::size_t k = 0; k < 10; ++k) CHECK(p.surface[k] == close_to(2e-3));
    CHECK(p.mass[2] == close_to(3 * g.mass[0]).epsilon(1e-12));  // two in the row and the one above
}
