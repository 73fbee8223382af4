#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

//! How far the solver is from a plain lattice that has taken the same steps.
struct Distance
{
    double population, load;
    double largest;  //!< population
};

inline Distance distance(std::vector<double> const& got, std::vector<double> const& plain, double load)
{
    REQUIRE(got.size() == plain.size());
    double worst = 0, largest = 0;
    for (std::size_t k = 0; k < got.size(); ++k) {
        worst = std::max(worst, std::abs(got[k] - plain[k]));
        largest = std::max(largest, std::abs(got[k]));
    }
    return {worst, load, largest};
}

//! Floats are rounded by 2^-24 at most when stored, and about as much when computed, at every of `steps` steps; a load
//! is twice the sum of some hundred cells' momentum, with an arm of some cells: a thousand populations, whose errors
//! are independent.
inline void check_floats(Distance const& rounded, int steps)
{
    double const rounding = steps * std::ldexp(rounded.largest, -23);
    CHECK(rounded.population > 1e-11);  // they are floats
    CHECK(rounded.population < rounding);
    CHECK(rounded.load < std::sqrt(1000.0) * rounding);
}
