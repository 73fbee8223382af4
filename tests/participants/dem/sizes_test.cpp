#include "participants/dem/sizes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

constexpr double low = 1e-3, high = 4e-3;  // m
constexpr int count = 20000;

std::vector<double> drawn(dem::Sizes const& sizes)
{
    dem::Random random(12345);
    std::vector<double> diameters(count);
    for (double& d : diameters) d = sizes.draw(random);
    return diameters;
}

//! The sample is of the law whose part finer than d, by number, is `finer`: Kolmogorov-Smirnov at 1 %, whose limit is
//! 1.628 / sqrt(n) (Smirnov 1948). sizes.finer() says the same.
void check_law(dem::Sizes const& sizes, std::function<double(double)> const& finer)
{
    auto diameters = drawn(sizes);
    std::sort(diameters.begin(), diameters.end());
    double worst = 0.0, apart = 0.0;
    for (int k = 0; k < count; ++k) {
        double const f = finer(diameters[static_cast<std::size_t>(k)]);
        worst = std::max({worst, std::abs(f - k / double(count)), std::abs(f - (k + 1) / double(count))});
        apart = std::max(apart, std::abs(f - sizes.finer(diameters[static_cast<std::size_t>(k)])));
    }
    CHECK(worst < 1.628 / std::sqrt(double(count)));
    CHECK(apart < 1e-9);
    CHECK(diameters.front() >= sizes.low());
    CHECK(diameters.back() <= sizes.high());
    CHECK(sizes.finer(0.999 * sizes.low()) == 0.0);
    CHECK(sizes.finer(1.001 * sizes.high()) == 1.0);
}

//! Means of powers of d: what Sizes says is the integral over `density`, the law by number, and the sample's lie within
//! four of their deviations.
void check_moments(dem::Sizes const& sizes, std::function<double(double)> const& density)
{
    auto const integral = [&](int power) {
        constexpr int steps = 200000;  // midpoints: their error is 1e-10 or less, but where the density jumps
        double sum = 0.0, width = (sizes.high() - sizes.low()) / steps;
        for (int k = 0; k < steps; ++k) {
            double const d = sizes.low() + (k + 0.5) * width;
            sum += density(d) * std::pow(d, power) * width;
        }
        return sum;
    };
    auto const diameters = drawn(sizes);
    for (int const power : {1, 2, 3}) {
        double const exact = integral(power) / integral(0), second = integral(2 * power) / integral(0);
        CHECK(sizes.moment(power) == close_to(exact).epsilon(1e-4));
        double mean = 0.0;
        for (double const d : diameters) mean += std::pow(d, power) / count;
        CHECK(std::abs(mean - exact) < 4.0 * std::sqrt((second - exact * exact) / count));
    }
}

//! Part by mass of the sample that is finer than d.
double finer_by_mass(std::vector<double> const& diameters, double limit, int dimension)
{
    double finer = 0.0, all = 0.0;
    for (double const d : diameters) {
        all += std::pow(d, dimension);
        if (d <= limit) finer += std::pow(d, dimension);
    }
    return finer / all;
}

}  // namespace

TEST_CASE("sizes: uniform by number")
{
    auto const sizes = dem::Sizes::uniform_number(low, high);
    check_law(sizes, [](double d) { return (d - low) / (high - low); });
    check_moments(sizes, [](double) { return 1.0; });
}

TEST_CASE("sizes: uniform by mass, of discs and of spheres")
{
    auto const discs = dem::Sizes::uniform_mass(low, high, 2), spheres = dem::Sizes::uniform_mass(low, high, 3);
    check_law(discs, [](double d) { return (1 / low - 1 / d) / (1 / low - 1 / high); });
    check_law(spheres,
              [](double d) { return (1 / (low * low) - 1 / (d * d)) / (1 / (low * low) - 1 / (high * high)); });
    check_moments(discs, [](double d) { return std::pow(d, -2); });
    check_moments(spheres, [](double d) { return std::pow(d, -3); });
}

TEST_CASE("sizes: fractal, with the exponents where its integrals are logarithms, too")
{
    for (double const exponent : {2.6, 0.0, 1.0, 2.0, 3.0, -0.5}) {
        auto const sizes = dem::Sizes::fractal(low, high, exponent);
        check_law(sizes, [&](double d) {
            if (exponent == 0.0) return std::log(d / low) / std::log(high / low);
            return (std::pow(low, -exponent) - std::pow(d, -exponent)) /
                   (std::pow(low, -exponent) - std::pow(high, -exponent));
        });
        check_moments(sizes, [&](double d) { return std::pow(d, -exponent - 1.0); });
    }
}

TEST_CASE("sizes: lognormal, cut off on both sides")
{
    double const mean = 2e-3, deviation = 1e-3;
    auto const sizes = dem::Sizes::lognormal(mean, deviation, low, high);
    double const variance = std::log(1.0 + 0.25), middle = std::log(mean) - variance / 2.0;
    auto const whole = [&](double d) {
        return 0.5 + 0.5 * std::erf((std::log(d) - middle) / std::sqrt(2.0 * variance));
    };
    check_law(sizes, [&](double d) { return (whole(d) - whole(low)) / (whole(high) - whole(low)); });
    check_moments(sizes, [&](double d) { return std::exp(-std::pow(std::log(d) - middle, 2) / (2 * variance)) / d; });
    CHECK(sizes.kept() == close_to(whole(high) - whole(low)));
    // mean and deviation are those of d where next to nothing is cut
    auto const wide = dem::Sizes::lognormal(mean, deviation, 1e-6, 1.0);
    CHECK(wide.moment(1) == close_to(mean).epsilon(1e-9));
    CHECK(wide.moment(2) == close_to(mean * mean + deviation * deviation).epsilon(1e-9));
}

TEST_CASE("sizes: a grading curve by mass, with a gap, of discs and of spheres")
{
    std::vector<std::pair<double, double>> const curve{{1e-3, 0.0}, {1.5e-3, 0.3}, {2.5e-3, 0.3}, {4e-3, 1.0}};
    for (int const dimension : {2, 3}) {
        auto const sizes = dem::Sizes::grading(curve, dimension);
        // mass is spread evenly in ln d on each piece: density by number g / d^(D+1), g = share / ln(high/low)
        auto const g = [&](double d) {
            return d < 1.5e-3 ? 0.3 / std::log(1.5) : d < 2.5e-3 ? 0.0 : 0.7 / std::log(1.6);
        };
        auto const power = [&](double d) { return std::pow(d, -dimension); };
        double const fine = g(1.2e-3) * (power(1e-3) - power(1.5e-3)), coarse = g(3e-3) * (power(2.5e-3) - power(4e-3));
        check_law(sizes, [&](double d) {
            double sum = g(1.2e-3) * (power(1e-3) - power(std::min(d, 1.5e-3)));
            if (d > 2.5e-3) sum += g(3e-3) * (power(2.5e-3) - power(d));
            return sum / (fine + coarse);
        });
        check_moments(sizes, [&](double d) { return g(d) * std::pow(d, -dimension - 1); });
        // and the sample's own curve by mass passes the points: the coarse grains are few, each weighs more; four
        // deviations of a sum of masses
        auto const diameters = drawn(sizes);
        double const square = sizes.moment(2 * dimension), mean = sizes.moment(dimension);
        double const deviation = std::sqrt(square / (count * mean * mean));
        CHECK(std::abs(finer_by_mass(diameters, 2e-3, dimension) - 0.3) < 4.0 * deviation);
        CHECK(std::abs(finer_by_mass(diameters, std::sqrt(2.5e-3 * 4e-3), dimension) - 0.65) < 4.0 * deviation);
    }
}

TEST_CASE("sizes: uniform by number draws what it always has, and the seed decides")
{
    dem::Random a(3), b(3), c(3), d(4);
    auto const uniform = dem::Sizes::uniform_number(low, high);
    for (int k = 0; k < 100; ++k) CHECK(uniform.draw(a) == b.uniform(low, high));
    auto const fractal = dem::Sizes::fractal(low, high, 2.5);
    CHECK(fractal.draw(c) != fractal.draw(d));
}

namespace {

dem::Config with_diameter(std::string const& diameter)
{
    std::string text = scene;
    std::string const usual = "{min: 1.0e-3, max: 1.8e-3}";
    text.replace(text.find(usual), usual.size(), diameter);
    return config(text);
}

}  // namespace

TEST_CASE("config: laws of size, their column's width, and mistakes in them")
{
    CHECK(with_diameter("{min: 1.0e-3, max: 1.8e-3}").sizes.is_uniform_number());
    auto const mass = with_diameter("{min: 1.0e-3, max: 1.8e-3, law: uniform_mass}");
    CHECK(mass.sizes.numbers() == dem::Sizes::uniform_mass(1e-3, 1.8e-3, 2).numbers());
    // of discs that are uniform by mass the mean of d^2 is d_min d_max
    CHECK(dem::column_width(mass) == close_to(std::sqrt(60 / 0.82 * std::numbers::pi / 4 * 1.8e-6 / 0.8)));
    auto const graded = with_diameter(
        "{grading: [{diameter: 1e-3, finer: 0}, {diameter: 1.2e-3, finer: 0.4}, {diameter: 2e-3, finer: 1}]}");
    CHECK(graded.diameter_max == 2e-3);
    CHECK(graded.sizes.numbers() == dem::Sizes::grading({{1e-3, 0}, {1.2e-3, 0.4}, {2e-3, 1}}, 2).numbers());
    auto const check = [](std::string const& diameter, char const* message) {
        CHECK_THROWS_WITH_AS(with_diameter(diameter), doctest::Contains(message), sluice::Error);
    };
    check("{min: 1e-3, max: 2e-3, law: lognormal, mean: 1e-3}", "deviation is missing");
    check("{min: 1e-3, max: 2e-3, law: lognormal, mean: 0.1, deviation: 0.01}", "less than a hundredth of this law");
    check("{min: 1e-3, max: 2e-3, law: fractal}", "fractal_dimension is missing");
    check("{min: 1e-3, max: 2e-3, law: uniform}", "law");
    check("{min: 1e-3, max: 2e-3, mean: 1e-3}", "mean is not a key");
    check("{grading: [{diameter: 1e-3, finer: 0}]}", "must be two points or more");
    check("{grading: [{diameter: 1e-3, finer: 0}, {diameter: 2e-3, finer: 0.9}]}", "from finer: 0 to finer: 1");
    check("{grading: [{diameter: 2e-3, finer: 0}, {diameter: 1e-3, finer: 1}]}", "must ascend");
    check("{grading: [{diameter: 1e-3, finer: 0}, {diameter: 0.1, finer: 1}]}", "more than 50 times");
}
