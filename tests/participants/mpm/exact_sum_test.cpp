#include "participants/mpm/exact_sum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

double sum_of(std::vector<double> const& terms)
{
    mpm::ExactSum sum;
    for (double const term : terms) sum.add(term);
    return sum.value();
}

}  // namespace

TEST_CASE("exact_sum: what doubles hold exactly comes out, of any size and sign")
{
    CHECK(sum_of({}) == 0);
    for (double const x : {1.0, -1.0, 0.1, -3e-20, 1.0 / 3, 7e60, -0x1.fffffffffffffp243, 0x1p-256, 0x1.8p-255})
        CHECK(sum_of({x}) == x);
    CHECK(sum_of({0x1p243, 1, -0x1p243}) == 1);
    CHECK(sum_of({1e30, 0x1p-200, -1e30, -0x1p-200}) == 0);
    CHECK(sum_of({-0x1p-200, 1e-70, -1e-70}) == -0x1p-200);
    CHECK(sum_of({0x1p-257, -0x1p-257, 0x1p-1074}) == 0);  // below what it holds
    for (double const x : {0x1p244, -HUGE_VAL, std::nan("")}) CHECK(std::isnan(sum_of({1, x})));
}

TEST_CASE("exact_sum: it is rounded once, to the nearest number, ties to even")
{
    CHECK(sum_of({1, 0x1p-53}) == 1);
    CHECK(sum_of({1, 0x1p-53, 0x1p-250}) == 1 + 0x1p-52);
    CHECK(sum_of({1, 0x1p-53, -0x1p-250}) == 1);
    CHECK(sum_of({-1, -0x1p-52, -0x1p-53, 0x1p-120}) == -1 - 0x1p-52);
    CHECK(sum_of({0x1p31, 0x1p-22, 0x1p-70}) == 0x1p31 + 0x1p-21);
    CHECK(sum_of({0x1.fffffffffffffp243, 0x1.fffffffffffffp243}) == 0x1.fffffffffffffp244);
}

TEST_CASE("exact_sum: it is within a rounding of the sum, in any order and in parts")
{
    std::vector<double> terms;
    for (int k = 0; k < 1000; ++k) terms.push_back(std::sin(17.0 * k) * std::exp2(60 * std::cos(3.0 * k)));
    double const sum = sum_of(terms);
    long double longer = 0;  // terms fall off by size: 64 bits are enough to see an error of the other
    std::ranges::sort(terms, {}, [](double x) { return std::abs(x); });
    for (double const term : terms) longer += term;
    CHECK(std::abs(sum - static_cast<double>(longer)) <= 0x1p-52 * std::abs(sum));
    CHECK(sum_of(terms) == sum);
    mpm::ExactSum one, other;
    for (std::size_t k = 0; k < terms.size(); ++k) (k % 3 == 0 ? one : other).add(terms[k]);
    other.add(one);
    CHECK(other.value() == sum);
}
