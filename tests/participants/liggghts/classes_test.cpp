#include "participants/liggghts/classes.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/close_to.hpp"

using liggghts::classes_of;

TEST_CASE("classes: grains of few masses have a class each, exactly")
{
    std::vector<double> const mass{3.0, 1.0, 3.0, 2.0}, radius{0.3, 0.1, 0.3, 0.2};
    auto const found = classes_of(mass, radius, 3);
    REQUIRE(found.classes.size() == 3);
    CHECK(found.spread == 0.0);
    for (std::size_t i = 0; i < mass.size(); ++i) {
        CHECK(found.classes[found.of[i]].mass == mass[i]);
        CHECK(found.classes[found.of[i]].radius == radius[i]);
    }
}

TEST_CASE("classes: grains of many masses share classes of one ratio, which says how far dashpots are off")
{
    std::vector<double> mass, radius;
    for (int k = 0; k < 500; ++k) {  // 1 to 1.8 mm, as a column's
        radius.push_back(0.5e-3 + 0.4e-3 * k / 499.0);
        mass.push_back(radius.back() * radius.back());
    }
    auto const found = classes_of(mass, radius, 32);
    REQUIRE(found.classes.size() == 32);
    double const half = std::log(1.8 * 1.8) / 64.0;  // half a class, of the logarithm of the mass
    CHECK(found.spread > 0.0);
    CHECK(found.spread < std::exp(0.5 * half * 1.3) - 1.0);  // means of classes are not quite in their middle
    for (std::size_t i = 0; i < mass.size(); ++i)
        CHECK(std::abs(std::log(mass[i] / found.classes[found.of[i]].mass)) < 1.3 * half);
}

TEST_CASE("classes: a class that nobody is in has a mass all the same")
{
    std::vector<double> const mass{1.0, 1.001, 1.002, 8.0}, radius{1.0, 1.0, 1.0, 2.0};
    for (auto const& [m, r] : classes_of(mass, radius, 3).classes) {
        CHECK(m >= 1.0);
        CHECK(r == close_to(std::cbrt(m)).epsilon(1e-2));
    }
}
