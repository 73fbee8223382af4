#include <doctest/doctest.h>

#include <limits>

#include "coupler/base/error.hpp"
#include "coupler/mapping/lattice_mapping.hpp"
#include "tests/coupler/mapping/cloud.hpp"
#include "tests/support/close_to.hpp"

using namespace sluice;
using namespace sluice::test;

namespace {

constexpr double nan_ = std::numeric_limits<double>::quiet_NaN();
constexpr double inf_ = std::numeric_limits<double>::infinity();

void check_partition(Mapping const& map)
{
    Values const one = map.consistent(Values(map.sources(), 1.0), 1);
    CHECK(max_difference(one, Values(map.targets(), 1.0)) <= 1e-13);
    Values const force = random_values(map.targets(), 3);
    CHECK(std::abs(sum(map.conservative(force, 1), 1, 0) - sum(force, 1, 0)) <= 1e-13 * sum(force, 1, 0, true));
}

}  // namespace

TEST_CASE("degenerate: targets without sources are an error, no targets are not")
{
    for (int const d : {2, 3})
        for (Method const& method : methods()) {
            CAPTURE(method.name);
            CHECK_THROWS_WITH_AS(method.build(Cloud{d, {}}, uniform(d, 4, 1)),
                                 ("mapping " + method.name + ": no sources for 4 targets (at least 1).").c_str(),
                                 Error);
            Mapping const none = method.build(uniform(d, 4, 1), Cloud{d, {}});
            CHECK(none.consistent(Values(4), 1).empty());
            CHECK(none.conservative(Values{}, 1) == Values(4, 0.0));
            CHECK(method.build(Cloud{d, {}}, Cloud{d, {}}).targets() == 0);
        }
    std::vector<std::int64_t> const nobody, one = {1};
    CHECK_THROWS_WITH_AS(map_by_id(nobody, one, Missing::report),
                         "mapping by id: no sources for 1 targets (at least 1).", Error);
    CHECK(map_by_id(one, nobody).conservative(Values{}, 1) == Values{0});
}

TEST_CASE("degenerate: a position that is not finite is an error with the point's number")
{
    for (double const bad : {nan_, inf_, -inf_, 1e101})
        for (Method const& method : methods()) {
            Cloud const good = uniform(2, 5, 1);
            Cloud wrong = good;
            wrong.position[7] = bad;
            std::string const text =
                "mapping " + method.name + ": a position of point 3 is not finite (needed: below 1e100 m).";
            CHECK_THROWS_WITH_AS(method.build(wrong, good), text.c_str(), Error);
            CHECK_THROWS_WITH_AS(method.build(good, wrong), text.c_str(), Error);
        }
    LatticeMapping map({2, {}, 1, {8, 8, 1}}, LatticeKernel::hat);
    for (double const bad : {nan_, inf_, -inf_})
        CHECK_THROWS_WITH_AS(map.place(Values{1, 1, 2, bad}), "lattice mapping: a position of point 1 is not finite.",
                             Error);
}

TEST_CASE("degenerate: one source gives its value everywhere and takes every load")
{
    for (int const d : {2, 3})
        for (Method const& method : methods()) {
            Mapping const map = method.build(uniform(d, 1, 1), uniform(d, 9, 2, -50, 50));
            CHECK(max_difference(map.consistent(Values{4.25}, 1), Values(9, 4.25)) <= 1e-14);
            CHECK(map.conservative(Values(9, 1.0), 1)[0] == close_to(9).epsilon(1e-14));
        }
}

TEST_CASE("degenerate: coincident sources share")
{
    for (Method const& method : methods()) {
        CAPTURE(method.name);
        Cloud const heap = changed(uniform(3, 60, 1), [](double* x) { x[0] = 1, x[1] = 2, x[2] = 3; });
        Mapping const map = method.build(heap, uniform(3, 9, 2));
        check_partition(map);
        CHECK(map.consistent(Values(60, 2.0), 1)[0] == close_to(2).epsilon(1e-14));
    }
    Cloud const pairs{2, {0, 0, 0, 0, 1, 0, 0, 1}};
    Values const load = map_rbf(pairs, Cloud{2, {0, 0}}).conservative(Values{2}, 1);
    CHECK(load[0] == close_to(1).epsilon(1e-13));
    CHECK(load[1] == close_to(1).epsilon(1e-13));
}

TEST_CASE("degenerate: sources on a line: linear along it, constant across it")
{
    for (int const d : {2, 3})
        for (Method const& method : methods()) {
            CAPTURE(d);
            CAPTURE(method.name);
            Cloud const line = changed(uniform(d, 80, 1), [d](double* x) { x[1] = 0.5 * x[0], x[d - 1] = 0.5 * x[0]; });
            Cloud const targets = uniform(d, 50, 2);
            Mapping const map = method.build(line, targets);
            check_partition(map);
            if (!method.linear_exact) continue;
            Values const seen = map.consistent(sampled(line, [](double const* x) { return 3 * x[0] - 1; }), 1);
            for (std::size_t t = 0; t < targets.size(); ++t) {
                double along = 0, square = 0;  // direction (1, 1/2) or (1, 1/2, 1/2)
                for (int k = 0; k < d; ++k) {
                    double const e = k == 0 ? 1 : 0.5;
                    along += e * targets.at(t, k);
                    square += e * e;
                }
                if (along / square < 0.95) CHECK(std::abs(seen[t] - (3 * along / square - 1)) <= 1e-9);
            }
        }
}

TEST_CASE("degenerate: sources on a plane in 3D: linear in it, constant across it")
{
    Cloud const plane = changed(uniform(3, 300, 1), [](double* x) { x[2] = 0.25; });
    Cloud const targets = uniform(3, 50, 2, 0.1, 0.9);
    auto const field = [](double const* x) { return 1 + 2 * x[0] - x[1]; };
    for (Mapping const& map : {map_linear(plane, targets), map_rbf(plane, targets)}) {
        check_partition(map);
        CHECK(max_difference(map.consistent(sampled(plane, field), 1), sampled(targets, field)) <= 1e-11);
    }
}

TEST_CASE("degenerate: targets far outside get a bounded value, and are counted")
{
    for (int const d : {2, 3})
        for (double const distance : {10.0, 1e6, 1e30})
            for (Method const& method : methods()) {
                CAPTURE(d);
                CAPTURE(distance);
                CAPTURE(method.name);
                Cloud const sources = uniform(d, 300, 1);
                Cloud const targets = changed(uniform(d, 20, 2), [&](double* x) { x[0] += distance; });
                Mapping const map = method.build(sources, targets);
                check_partition(map);
                Values const x = sampled(sources, [](double const* p) { return p[0]; });
                for (double const v : map.consistent(x, 1)) {  // sources have 0 to 1; from 1e30 all look equally far
                    CHECK(v > (distance < 1e9 ? 0.5 : -0.001));
                    CHECK(v < 4);
                }
                CHECK(map.out_of_reach() == (method.name == "nearest" ? 0 : 20));
            }
    CHECK(map_linear(uniform(2, 300, 1), uniform(2, 100, 2, 0.1, 0.9)).out_of_reach() == 0);
    CHECK(map_rbf(uniform(2, 300, 1), uniform(2, 100, 2, 0.1, 0.9)).out_of_reach() == 0);
}

TEST_CASE("degenerate: at equal distance nearest takes the smaller x, however the sources are numbered")
{
    Cloud const targets{2, {0.5, 0.5, 0.5, 0}};
    CHECK(map_nearest(Cloud{2, {0, 0, 1, 0, 0, 1, 1, 1}}, targets).consistent(Values{1, 2, 3, 4}, 1) == Values{1, 1});
    CHECK(map_nearest(Cloud{2, {1, 1, 0, 1, 1, 0, 0, 0}}, targets).consistent(Values{4, 3, 2, 1}, 1) == Values{1, 1});
}

TEST_CASE("degenerate: linear looks further where its neighbours lie on one line")
{
    Cloud sources{2, {}};  // two dense lines far apart: the nearest dozens are all on one of them
    for (int i = 0; i < 60; ++i)
        for (double const y : {0.0, 1.0}) sources.position.insert(sources.position.end(), {0.01 * i, y});
    Cloud const targets = changed(uniform(2, 50, 3), [](double* x) { x[0] = 0.1 + 0.4 * x[0]; });
    auto const field = [](double const* x) { return 2 * x[0] + 7 * x[1]; };
    Mapping const map = map_linear(sources, targets);
    CHECK(map.out_of_reach() == 0);
    CHECK(max_difference(map.consistent(sampled(sources, field), 1), sampled(targets, field)) <= 1e-11);
}

TEST_CASE("degenerate: what does not fit is an error")
{
    Cloud const flat = uniform(2, 4, 1), solid = uniform(3, 4, 1);
    CHECK_THROWS_AS(map_nearest(flat, solid), Error);
    CHECK_THROWS_AS(map_nearest(Points{flat.position, 4}, Points{flat.position, 4}), Error);
    CHECK_THROWS_AS(map_nearest(Points{Values{1, 2, 3}, 2}, flat), Error);
    for (double const radius : {0.0, -1.0, nan_, inf_}) CHECK_THROWS_AS(map_kernel(flat, flat, radius), Error);
    CHECK_THROWS_AS(map_rbf(flat, flat, {.patch_points = -1}), Error);
    CHECK_THROWS_AS(map_rbf(flat, flat, {.overlap = 0}), Error);
    CHECK_THROWS_AS(map_rbf(flat, flat, {.support = nan_}), Error);
    std::vector<std::int64_t> const twice = {5, 6, 5};
    CHECK_THROWS_WITH_AS(map_by_id(twice, twice), "mapping by id: two sources have id 5.", Error);
    Mapping const map = map_nearest(flat, flat);
    CHECK_THROWS_AS(map.consistent(Values(7), 2), Error);
    CHECK_THROWS_AS(map.conservative(Values(4), 0), Error);
    CHECK_THROWS_AS(map.lost(Values(3), 1), Error);

    auto const lattice = [](Lattice l, LatticeKernel k = LatticeKernel::four_point) { return LatticeMapping(l, k); };
    CHECK_THROWS_WITH_AS(lattice({2, {}, 1, {8, 3, 1}}),
                         "lattice mapping: 3 cells along axis 1 (needed: 4 for this kernel).", Error);
    CHECK_NOTHROW(lattice({2, {}, 1, {8, 3, 1}}, LatticeKernel::three_point));
    CHECK_THROWS_AS(lattice({4, {}, 1, {8, 8, 8}}), Error);
    CHECK_THROWS_AS(lattice({2, {}, 0, {8, 8, 1}}), Error);
    CHECK_THROWS_AS(lattice({2, {0, nan_, 0}, 1, {8, 8, 1}}), Error);
    CHECK_THROWS_AS(lattice({3, {}, 1, {1 << 30, 1 << 30, 1 << 30}}), Error);
    LatticeMapping small = lattice({2, {}, 1, {8, 8, 1}});
    CHECK_THROWS_AS(small.place(Values{1, 2, 3}), Error);
    small.place(Values{1, 2});
    Values cells(64), point(1), wrong(2);
    CHECK_THROWS_AS(small.gather(cells, 1, wrong), Error);
    CHECK_THROWS_AS(small.gather(cells, 2, wrong), Error);
    CHECK_THROWS_AS(small.spread(point, 1, wrong), Error);
    CHECK_THROWS_AS(small.spread(point, -1, cells), Error);
}
