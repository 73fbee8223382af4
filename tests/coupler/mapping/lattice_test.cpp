#include <doctest/doctest.h>

#include "coupler/mapping/lattice_mapping.hpp"
#include "tests/coupler/mapping/cloud.hpp"
#include "tests/support/close_to.hpp"

using namespace sluice;
using namespace sluice::test;

namespace {

constexpr LatticeKernel kernels[] = {LatticeKernel::hat, LatticeKernel::three_point, LatticeKernel::four_point};

Lattice small_lattice(int d)
{
    return {d, {-0.3, 2.0, 11.0}, 0.25, {9, 6, 5}};
}

//! Random points in the lattice's box, and its corners, faces and cell centres, where rounding decides.
Cloud points_inside(Lattice const& lattice, unsigned seed)
{
    auto const d = static_cast<std::size_t>(lattice.dimension);
    Cloud cloud{lattice.dimension, {}};
    std::mt19937_64 random(seed);
    for (int i = 0; i < 600; ++i)
        for (std::size_t k = 0; k < d; ++k) {
            auto const n = static_cast<double>(lattice.cells[k]);
            double s = std::uniform_real_distribution<double>(0, n)(random);
            if (i % 4 == 1) s = std::round(s);                         // faces, corners of the box
            if (i % 4 == 2) s = std::min(std::floor(s), n - 1) + 0.5;  // centres
            if (i % 4 == 3) s = random() % 2 == 0 ? 0 : n;
            cloud.position.push_back(lattice.origin[k] + s * lattice.spacing);
        }
    return cloud;
}

Cloud centres(Lattice const& l)
{
    Cloud cloud{l.dimension, {}};
    for (std::size_t c = 0; c < l.size(); ++c) {
        auto rest = static_cast<std::int64_t>(c);
        for (std::size_t k = 0; k < static_cast<std::size_t>(l.dimension); rest /= l.cells[k++])
            cloud.position.push_back(l.origin[k] + (static_cast<double>(rest % l.cells[k]) + 0.5) * l.spacing);
    }
    return cloud;
}

//! The functions as their papers print them, r in spacings.
double printed(LatticeKernel kernel, double r)
{
    r = std::abs(r);
    if (kernel == LatticeKernel::hat) return std::max(0.0, 1 - r);
    if (kernel == LatticeKernel::three_point) {
        if (r <= 0.5) return (1 + std::sqrt(1 - 3 * r * r)) / 3;
        return r <= 1.5 ? (5 - 3 * r - std::sqrt(1 - 3 * (1 - r) * (1 - r))) / 6 : 0;
    }
    if (r <= 1) return (3 - 2 * r + std::sqrt(1 + 4 * r - 4 * r * r)) / 8;
    return r <= 2 ? (5 - 2 * r - std::sqrt(-7 + 12 * r - 4 * r * r)) / 8 : 0;
}

void for_every_map(std::function<void(LatticeMapping&, Lattice const&, Cloud const&, Border)> const& check)
{
    for (int const d : {2, 3})
        for (LatticeKernel const kernel : kernels)
            for (Border const border : {Border::mirror, Border::linear}) {
                CAPTURE(d);
                CAPTURE(static_cast<int>(kernel));
                CAPTURE(static_cast<int>(border));
                Lattice const lattice = small_lattice(d);
                Cloud const points = points_inside(lattice, 5);
                LatticeMapping map(lattice, kernel, border);
                map.place(points.position);
                check(map, lattice, points, border);
            }
}

}  // namespace

TEST_CASE("lattice: the weights are the product of the published functions")
{
    for (LatticeKernel const kernel : kernels) {
        Lattice const lattice{3, {1, 2, 3}, 0.5, {12, 12, 12}};
        Cloud const points = changed(uniform(3, 40, 3, 2.2, 3.8), [](double* x) { x[0] += 1, x[1] += 2, x[2] += 3; });
        LatticeMapping map(lattice, kernel);
        map.place(points.position);
        for (std::size_t p = 0; p < points.size(); ++p) {
            Values one(points.size(), 0.0), seen(lattice.size(), 0.0);
            one[p] = 1;
            map.spread(one, 1, seen);
            Cloud const cells = centres(lattice);
            double most = 0;
            for (std::size_t c = 0; c < lattice.size(); ++c) {
                double product = 1;
                for (int k = 0; k < 3; ++k) product *= printed(kernel, (points.at(p, k) - cells.at(c, k)) / 0.5);
                most = std::max(most, std::abs(seen[c] - product));
            }
            CHECK(most <= 1e-14);
        }
    }
}

// Roma et al. 1999, eq. 21: sum of squares 1/2. Peskin 2002, eqs. 6.15 and 6.17: even and odd cells get 1/2 each, sum
// of squares 3/8.
TEST_CASE("lattice: the published identities hold wherever the point is")
{
    for (int i = 0; i <= 50; ++i) {
        Values const at = {4 + i / 50.0, 4.5};  // the second axis at a centre
        auto const weights = [&](LatticeKernel kernel) {
            LatticeMapping map({2, {}, 1, {9, 9, 1}}, kernel);
            map.place(at);
            Values cells(81, 0.0), axis(9, 0.0);
            map.spread(Values{1}, 1, cells);
            for (std::size_t c = 0; c < 81; ++c) axis[c % 9] += cells[c];
            return axis;
        };
        Values const three = weights(LatticeKernel::three_point), four = weights(LatticeKernel::four_point);
        CHECK(dot(three, three) == close_to(0.5).epsilon(1e-14));
        CHECK(dot(four, four) == close_to(0.375).epsilon(1e-14));
        CHECK(sum(four, 2, 0) == close_to(0.5).epsilon(1e-14));
        CHECK(sum(four, 2, 1) == close_to(0.5).epsilon(1e-14));
    }
}

TEST_CASE("lattice: spread keeps sums to rounding for every point inside, up to corners")
{
    for_every_map([](LatticeMapping& map, Lattice const& lattice, Cloud const& points, Border) {
        CHECK(map.outside().empty());
        Values const force = random_values(3 * points.size(), 6);
        Values cells(3 * lattice.size(), 0.0);
        CHECK(map.spread(force, 3, cells) == Values{0, 0, 0});
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(std::abs(sum(cells, 3, c) - sum(force, 3, c)) <= 1e-13 * sum(force, 3, c, true));
    });
}

TEST_CASE("lattice: gather keeps constants, and with Border::linear linear fields and first moments up to the border")
{
    for_every_map([](LatticeMapping& map, Lattice const& lattice, Cloud const& points, Border border) {
        Values seen(points.size());
        map.gather(Values(lattice.size(), 1.0), 1, seen);
        CHECK(max_difference(seen, Values(points.size(), 1.0)) <= 1e-14);
        auto const field = [&](double const* x) {
            return 1 + 2 * x[0] - 3 * x[1] + (points.dimension == 3 ? x[2] : 0);
        };
        map.gather(sampled(centres(lattice), field), 1, seen);
        Values const force = random_values(points.size(), 7, 0, 1);
        Values cells(lattice.size(), 0.0);
        map.spread(force, 1, cells);
        double moments = 0;
        for (int k = 0; k < points.dimension; ++k)
            moments += std::abs(moment(centres(lattice), cells, 1, 0, k, 0) - moment(points, force, 1, 0, k, 0));
        if (border == Border::linear) {
            CHECK(max_difference(seen, sampled(points, field)) <= 1e-12);
            CHECK(moments <= 1e-12 * sum(force, 1, 0));
        } else {
            CHECK(max_difference(seen, sampled(points, field)) > 0.1);  // as documented: not at the border
            CHECK(std::ranges::min(cells) >= 0);                        // but never a negative mass
        }
    });
}

// Beyond the wall, cell -b stands for cell b - 1 (mirror) or for (1 + b) value(0) - b value(1) (linear): gathering from
// a lattice that has those cells must give the same.
TEST_CASE("lattice: a border is as if the lattice went on, mirrored or linearly")
{
    constexpr int n = 5, pad = 3, wide = n + 2 * pad;
    Values const small = random_values(n * n, 4);
    auto const continued = [&](Border border, int i, auto&& value) {
        if (i >= 0 && i < n) return value(i);
        int const b = i < 0 ? -i : i - n + 1, wall = i < 0 ? 0 : n - 1, step = i < 0 ? 1 : -1;
        return border == Border::mirror ? value(wall + step * (b - 1)) : (1 + b) * value(wall) - b * value(wall + step);
    };
    for (LatticeKernel const kernel : kernels)
        for (Border const border : {Border::mirror, Border::linear}) {
            Values large;
            for (int j = -pad; j < n + pad; ++j)
                for (int i = -pad; i < n + pad; ++i)
                    large.push_back(continued(border, j, [&](int row) {
                        return continued(border, i,
                                         [&](int k) { return small[static_cast<std::size_t>(row * n + k)]; });
                    }));
            Cloud const points = uniform(2, 500, 6, 0, n);
            Values seen(500), needed(500);
            LatticeMapping map({2, {}, 1, {n, n, 1}}, kernel, border);
            map.place(points.position);
            map.gather(small, 1, seen);
            LatticeMapping on({2, {-pad, -pad, 0}, 1, {wide, wide, 1}}, kernel, border);
            on.place(points.position);
            on.gather(large, 1, needed);
            CHECK(max_difference(seen, needed) <= 1e-13);
        }
}

TEST_CASE("lattice: spread is the transpose of gather")
{
    for_every_map([](LatticeMapping& map, Lattice const& lattice, Cloud const& points, Border) {
        for (std::size_t const width : {1, 2, 3, 4, 7}) {
            Values const x = random_values(width * lattice.size(), 8), y = random_values(width * points.size(), 9);
            Values gathered(y.size()), cells(x.size(), 0.0);
            map.gather(x, static_cast<int>(width), gathered);
            map.spread(y, static_cast<int>(width), cells);
            CHECK(std::abs(dot(gathered, y) - dot(x, cells)) <= 1e-13 * norm(x) * norm(y));
        }
    });
}

TEST_CASE("lattice: components are mapped as if alone")
{
    for_every_map([](LatticeMapping& map, Lattice const& lattice, Cloud const& points, Border) {
        for (std::size_t const width : {2, 3, 5}) {
            Values const x = random_values(width * lattice.size(), 8), y = random_values(width * points.size(), 9);
            Values gathered(y.size()), cells(x.size(), 0.0);
            map.gather(x, static_cast<int>(width), gathered);
            map.spread(y, static_cast<int>(width), cells);
            for (std::size_t c = 0; c < width; ++c) {
                Values one_x, one_y, seen(points.size()), one_cells(lattice.size(), 0.0);
                for (std::size_t i = c; i < x.size(); i += width) one_x.push_back(x[i]);
                for (std::size_t i = c; i < y.size(); i += width) one_y.push_back(y[i]);
                map.gather(one_x, 1, seen);
                map.spread(one_y, 1, one_cells);
                for (std::size_t i = 0; i < seen.size(); ++i)
                    CHECK(std::abs(gathered[i * width + c] - seen[i]) <= 1e-14);
                for (std::size_t i = 0; i < one_cells.size(); ++i)
                    CHECK(std::abs(cells[i * width + c] - one_cells[i]) <= 1e-12);
            }
        }
    });
}

TEST_CASE("lattice: what lies outside is listed and its sum handed back, so that the books close")
{
    for (LatticeKernel const kernel : kernels) {
        Lattice const lattice = small_lattice(3);
        Cloud const points = uniform(3, 3000, 4, -4, 14);
        LatticeMapping map(lattice, kernel);
        map.place(points.position);
        REQUIRE(map.outside().size() > 100);
        REQUIRE(map.outside().size() < 3000);
        for (std::size_t const p : map.outside()) {
            bool inside = true;
            for (int k = 0; k < 3; ++k) {
                double const s = (points.at(p, k) - lattice.origin[static_cast<std::size_t>(k)]) / lattice.spacing;
                inside = inside && s >= 0 && s <= static_cast<double>(lattice.cells[static_cast<std::size_t>(k)]);
            }
            CHECK(!inside);
        }
        Values const force = random_values(6000, 6);
        Values cells(2 * lattice.size(), 0.0), gathered(3000, 9.0);
        Values const lost = map.spread(force, 2, cells);
        for (std::size_t c = 0; c < 2; ++c)
            CHECK(std::abs(sum(cells, 2, c) + lost[c] - sum(force, 2, c)) <= 1e-13 * sum(force, 2, c, true));
        map.gather(Values(lattice.size(), 1.0), 1, gathered);
        CHECK(sum(gathered, 1, 0) == close_to(3000.0 - static_cast<double>(map.outside().size())).epsilon(1e-12));
    }
}

TEST_CASE("lattice: values of points outside never touch the lattice, not even NaN")
{
    LatticeMapping map({2, {}, 1, {4, 4, 1}}, LatticeKernel::four_point);
    map.place(Values{-3, 1, 2, 2});
    Values cells(16, 0.0);
    CHECK(std::isnan(map.spread(Values{std::nan(""), 1}, 1, cells)[0]));
    CHECK(sum(cells, 1, 0) == close_to(1).epsilon(1e-14));
    Values seen(2);
    cells.assign(16, std::nan(""));
    map.gather(cells, 1, seen);
    CHECK(seen[0] == 0);
    CHECK(std::isnan(seen[1]));
}

TEST_CASE("lattice: spread adds, so that several participants can share a lattice")
{
    LatticeMapping map({2, {}, 1, {8, 8, 1}}, LatticeKernel::three_point);
    map.place(Values{3.2, 4.1});
    Values cells(64, 1.0);
    map.spread(Values{2}, 1, cells);
    CHECK(sum(cells, 1, 0) == close_to(66).epsilon(1e-14));
}

TEST_CASE("lattice: the numbering of points does not matter, and equal input gives equal bits")
{
    for_every_map([](LatticeMapping& map, Lattice const& lattice, Cloud const& points, Border) {
        std::vector<std::size_t> order(points.size());
        std::iota(order.begin(), order.end(), 0UL);
        std::ranges::shuffle(order, std::mt19937_64(3));
        Values const x = random_values(lattice.size(), 8), y = random_values(points.size(), 9);
        Values gathered(y.size()), cells(x.size(), 0.0);
        map.gather(x, 1, gathered);
        map.spread(y, 1, cells);
        Values again(x.size(), 0.0);
        map.spread(y, 1, again);
        CHECK(again == cells);

        Cloud other{points.dimension, {}};
        Values other_y;
        for (std::size_t const i : order) {
            for (int k = 0; k < points.dimension; ++k) other.position.push_back(points.at(i, k));
            other_y.push_back(y[i]);
        }
        map.place(other.position);
        Values other_gathered(y.size()), other_cells(x.size(), 0.0);
        map.gather(x, 1, other_gathered);
        map.spread(other_y, 1, other_cells);
        for (std::size_t i = 0; i < order.size(); ++i) CHECK(other_gathered[i] == gathered[order[i]]);
        CHECK(max_difference(other_cells, cells) <= 1e-13 * norm(y));
    });
}

TEST_CASE("lattice: the number of points may change from window to window")
{
    Lattice const lattice = small_lattice(2);
    LatticeMapping map(lattice, LatticeKernel::four_point);
    for (std::size_t const count : {5, 900, 0, 17}) {
        Cloud const points = changed(uniform(2, count, 3), [](double* x) { x[1] += 2; });
        map.place(points.position);
        REQUIRE(map.points() == count);
        Values cells(lattice.size(), 0.0);
        map.spread(Values(count, 1.0), 1, cells);
        CHECK(std::abs(sum(cells, 1, 0) - static_cast<double>(count)) <= 1e-13 * static_cast<double>(count));
    }
}
