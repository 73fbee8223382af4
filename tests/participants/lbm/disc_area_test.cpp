#include "participants/lbm/disc_area.hpp"

#include <doctest/doctest.h>

#include <numbers>
#include <random>

#include "participants/lbm/coverage.hpp"
#include "tests/participants/lbm/exact_area.hpp"
#include "tests/support/close_to.hpp"

namespace {

struct Raster
{
    lbm::DiscBox box;
    std::vector<double> fraction;
    std::vector<std::ptrdiff_t> columns;
};

Raster raster(double x, double y, double r)
{
    lbm::RasterScratch scratch;
    Raster out{lbm::disc_box(x, y, r), {}, {}};
    out.fraction.resize(static_cast<std::size_t>(out.box.width * out.box.height));
    out.columns.resize(static_cast<std::size_t>(2 * out.box.height));
    lbm::rasterise(x, y, r, out.box, out.fraction, out.columns, scratch);
    return out;
}

//! Largest difference from the exact area of any cell, and of the sum from pi r^2, relative.
void check(double x, double y, double r)
{
    CAPTURE(x);
    CAPTURE(y);
    CAPTURE(r);
    Raster const got = raster(x, y, r);
    double worst = 0, sum = 0;
    for (std::ptrdiff_t j = 0; j < got.box.height; ++j) {
        for (std::ptrdiff_t i = 0; i < got.box.width; ++i) {
            double const f = got.fraction[static_cast<std::size_t>(j * got.box.width + i)];
            double const x0 = static_cast<double>(got.box.x0 + i) - x, y0 = static_cast<double>(got.box.y0 + j) - y;
            worst = std::max(worst, std::abs(f - exact_area(x0, x0 + 1, y0, y0 + 1, r)));
            sum += f;
            bool const inside = i >= got.columns[static_cast<std::size_t>(2 * j)] &&
                                i < got.columns[static_cast<std::size_t>(2 * j + 1)];
            CHECK((inside || f == 0));
        }
    }
    CHECK(worst < 1e-12 * std::max(1.0, r * r));
    CHECK(sum == close_to(std::numbers::pi * r * r).epsilon(1e-12));
}

}  // namespace

TEST_CASE("disc_area: every cell is exact, the sum is pi r^2, for random discs of 0.2 to 60 cells")
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-3, 3), size(0.2, 60);
    for (int k = 0; k < 300; ++k)
        check(uniform(random), uniform(random), k % 3 == 0 ? 0.1 * size(random) : size(random));
}

TEST_CASE("disc_area: exact where the circle touches grid lines and corners")
{
    for (double const x : {0.0, 0.5, 1.0})
        for (double const y : {0.0, 0.5, -2.0})
            for (double const r : {0.5, 1.0, 5.0, 12.5}) check(x, y, r);
    check(0, 0, std::sqrt(2.0));
    check(3, 4, 5);
    check(0.3, 0.3, 0.1);
}

TEST_CASE("disc_area: the exact area itself: half a disc, a quarter, a whole")
{
    CHECK(exact_area(-9, 9, -9, 9, 2) == close_to(4 * std::numbers::pi));
    CHECK(exact_area(-9, 9, 0, 9, 2) == close_to(2 * std::numbers::pi));
    CHECK(exact_area(0, 9, -9, 0, 2) == close_to(std::numbers::pi));
    CHECK(exact_area(-1, 1, -1, 1, 2) == close_to(4));
    CHECK(exact_area(3, 4, 0, 1, 2) == 0);
}

TEST_CASE("coverage: discs across periodic sides keep their area, beyond walls it is cut off")
{
    for (bool const periodic : {true, false}) {
        sluice::Team team(2);
        lbm::Layout const layout({20, 16, 1});
        lbm::Domain<2> const domain(layout, nullptr);
        lbm::Coverage<2> coverage(domain, {periodic, periodic});
        std::vector<lbm::Body<2>> const discs = {{{-0.3, 15.7}, 4.2, {}}, {{39.9, 8.1}, 3, {}}};
        coverage.update(discs, team);
        double sum = 0;
        for (lbm::Strip<2> const& s : coverage.strips().first(coverage.of_body(0)[1]))
            for (std::ptrdiff_t k = 0; k < s.count; ++k) {
                REQUIRE((s.begin >= 0 && s.begin + s.count <= 20 && s.row >= 0 && s.row < 16));
                sum += s.fraction[k];
            }
        double const whole = std::numbers::pi * 4.2 * 4.2;
        CHECK(sum == close_to(periodic ? whole : exact_area(0.3, 99, -99, 0.3, 4.2)).epsilon(1e-12));
        std::size_t listed = 0;
        for (std::ptrdiff_t y = 0; y < 16; ++y) listed += coverage.row(y).size();
        CHECK(listed ==
              coverage.of_body(0)[1] - coverage.of_body(0)[0] + coverage.of_body(1)[1] - coverage.of_body(1)[0]);
        if (!periodic) CHECK(coverage.of_body(1)[0] == coverage.of_body(1)[1]);
    }
}
