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
    std::vector<double> listed;
    std::vector<lbm::RowCover> rows;
};

Raster raster(double x, double y, double r)
{
    lbm::RasterScratch scratch;
    Raster out{lbm::disc_box(x, y, r), {}, {}};
    out.listed.resize(lbm::most_listed(r) + lbm::RowCover::slack);
    out.rows.resize(static_cast<std::size_t>(out.box.height));
    lbm::rasterise(x, y, r, out.box, out.listed, out.rows, scratch);
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
    std::size_t listed = 0;
    for (std::ptrdiff_t j = 0; j < got.box.height; ++j) {
        lbm::RowCover const& row = got.rows[static_cast<std::size_t>(j)];
        for (std::ptrdiff_t i = 0; i < got.box.width; ++i) {
            double const f = row.covers(i) ? row.fraction(i - row.begin) : 0.0;
            double const x0 = static_cast<double>(got.box.x0 + i) - x, y0 = static_cast<double>(got.box.y0 + j) - y;
            worst = std::max(worst, std::abs(f - exact_area(x0, x0 + 1, y0, y0 + 1, r)));
            sum += f;
        }
        listed += static_cast<std::size_t>(row.left + row.right);
    }
    CHECK(listed <= lbm::most_listed(r));
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

TEST_CASE("coverage: parts of a row's fractions, and all written at once, are those of its cells")
{
    std::vector<double> const listed = {0.25, 0.5, 0.75, 0.625, 0.125, 0, 0, 0, 0};
    for (std::int32_t const left : {0, 2, 3, 5})
        for (std::int32_t const between : {0, 1, 9, 17}) {
            if (left == 5 && between > 0) continue;
            lbm::RowCover const whole{7, 5 + between, left, 5 - left, listed.data()};
            for (std::ptrdiff_t first = 0; first < whole.count; ++first)
                for (std::ptrdiff_t end = first + 1; end <= whole.count; ++end) {
                    lbm::RowCover const part = whole.part(first, end);
                    std::vector<float> written(static_cast<std::size_t>(part.whole_lanes() + lbm::strip_lanes), 9);
                    part.write(written.data());
                    CHECK((part.begin == 7 + first && part.count == end - first));
                    for (std::ptrdiff_t k = 0; k < part.whole_lanes(); ++k) {
                        double const right = k < part.count ? whole.fraction(first + k) : 0.0;
                        CHECK((k >= part.count || part.fraction(k) == right));
                        CHECK(static_cast<double>(written[static_cast<std::size_t>(k)]) == right);
                    }
                }
        }
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
                REQUIRE((s.begin >= 0 && s.begin + s.count <= 20 && s.row < 16));
                sum += s.fraction(k);
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
