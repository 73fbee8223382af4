#include "participants/dem/voronoi.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "participants/dem/solver.hpp"
#include "tests/participants/dem/periodic_scenes.hpp"
#include "tests/support/close_to.hpp"

//! Cells of regular packings, whose packing fractions have closed forms, and cells that must fill their container.
//! voro++ works to 1e-11 of a diameter: a sum of volumes of cells is good to 1e-9.
namespace {

using dem::Vec2;
using dem::Vec3;
constexpr double pi = std::numbers::pi;

template <int D>
void add_wall(dem::Setup<D>& s, dem::Shape<D> const& shape, double removed_at = 1e9)
{
    s.walls.push_back({.name = "w", .shape = shape, .motion = {}, .law = s.law, .removed_at = removed_at});
}

//! No weight, no friction.
template <int D>
dem::Setup<D> still()
{
    dem::Setup<D> s;
    s.law = dem::contact_law(unit::contact(0.0));
    s.skin = 1e-4;
    return s;
}

//! The walls of a box from the origin to `size`.
dem::Setup<3> box(Vec3 size)
{
    auto s = still<3>();
    for (int k = 0; k < 3; ++k) {
        Vec3 normal{}, far{};
        dem::component<3>(normal, k) = 1.0;
        dem::component<3>(far, k) = dem::component<3>(size, k);
        add_wall<3>(s, dem::Plane<3>{{}, normal});
        add_wall<3>(s, dem::Plane<3>{far, -normal});
    }
    return s;
}

template <int D>
dem::Tessellation cells(dem::Setup<D> const& setup, dem::Grains<D> const& grains)
{
    dem::Solver<D> const solver(setup, grains);
    return dem::tessellate(solver.setup(), solver.state());
}

double sum(std::vector<double> const& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0);
}

//! Every cell whose grain lies deeper than `margin` within the packing's outermost centres is closed and has this
//! packing fraction; returns how many there are. (Nearer cells may be closed and large: edges have notches.)
template <int D>
int check_inner(dem::Grains<D> const& g, dem::Tessellation const& t, double margin, double fraction)
{
    dem::Vec<D> low = g.place[0].centre, high = low;
    for (auto const& place : g.place)
        for (int k = 0; k < D; ++k) {
            dem::component<D>(low, k) = std::min(dem::component<D>(low, k), dem::component<D>(place.centre, k));
            dem::component<D>(high, k) = std::max(dem::component<D>(high, k), dem::component<D>(place.centre, k));
        }
    int inner = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        bool deep = true;
        for (int k = 0; k < D; ++k) {
            double const at = dem::component<D>(g.place[i].centre, k);
            deep = deep && at > dem::component<D>(low, k) + margin && at < dem::component<D>(high, k) - margin;
        }
        if (!deep) continue;
        ++inner;
        CHECK(t.closed[i]);
        CHECK(t.fraction[i] == close_to(fraction).epsilon(1e-8));
    }
    return inner;
}

}  // namespace

TEST_CASE("voronoi: a simple cubic packing in a box has the packing fraction pi/6 in every cell")
{
    double const r = 1e-3;
    dem::Grains<3> g;
    for (int k = 0; k < 5 * 5 * 5; ++k)
        g.add({(2 * (k % 5) + 1) * r, (2 * (k / 5 % 5) + 1) * r, (2 * (k / 25) + 1) * r}, r, 2650.0);
    auto const t = cells(box({10 * r, 10 * r, 10 * r}), g);
    CHECK(check_inner(g, t, -r, pi / 6) == 125);
    CHECK(sum(t.volume) == close_to(1000 * r * r * r).epsilon(1e-9));
    auto const p = dem::packed_of(g, t, {4 * r, false});
    CHECK(p.fraction == close_to(pi / 6).epsilon(1e-9));
    CHECK(p.closed == 125);
    REQUIRE(p.position.size() == 3);  // 0 to 4 r, 4 to 8 r, 8 to 12 r
    for (double const fraction : p.fractions) CHECK(fraction == close_to(pi / 6).epsilon(1e-9));
}

TEST_CASE("voronoi: inside a face-centred cubic packing every cell has pi/sqrt(18), whose neighbours are twelve")
{
    double const r = 1e-3, edge = std::sqrt(8.0) * r;
    dem::Grains<3> g;
    Vec3 const basis[] = {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
    for (int k = 0; k < 4 * 4 * 4; ++k)
        for (Vec3 const& b : basis)
            g.add(edge * (b + Vec3{1.0 * (k % 4), 1.0 * (k / 4 % 4), 1.0 * (k / 16)}), r, 2650.0);
    CHECK(check_inner(g, cells(still<3>(), g), 0.75 * edge, pi / std::sqrt(18.0)) == 32);
}

TEST_CASE("voronoi: inside hexagonally packed discs every cell has pi/sqrt(12)")
{
    double const r = 1e-3;
    dem::Grains<2> g;
    for (int row = 0; row < 9; ++row)
        for (int k = 0; k < 9; ++k) g.add({(2 * k + row % 2) * r, row * std::sqrt(3.0) * r}, r, 2650.0);
    CHECK(check_inner(g, cells(still<2>(), g), 1.5 * r, pi / std::sqrt(12.0)) == 49);
}

TEST_CASE("voronoi: touching discs of two sizes part at their point of contact (radical planes)")
{
    double const r = 1e-3, large = 3e-3, height = 6e-3;
    auto s = still<2>();
    add_wall<2>(s, dem::Plane<2>{{0, 0}, {0, 1}});
    add_wall<2>(s, dem::Plane<2>{{0, height}, {0, -1}});
    add_wall<2>(s, dem::Plane<2>{{0, 0}, {1, 0}});
    add_wall<2>(s, dem::Plane<2>{{2 * (r + large), 0}, {-1, 0}});
    dem::Grains<2> g;
    g.add({r, 3e-3}, r, 2650.0);
    g.add({2 * r + large, 3e-3}, large, 2650.0);
    auto const t = cells(s, g);
    CHECK(t.volume[0] == close_to(2 * r * height).epsilon(1e-9));
    CHECK(t.volume[1] == close_to(2 * large * height).epsilon(1e-9));
    CHECK(t.fraction[1] == close_to(pi * large * large / (2 * large * height)).epsilon(1e-9));
    CHECK(t.closed == std::vector{true, true});
}

TEST_CASE("voronoi: the cells of grains of many sizes fill a box, a cylinder with floor and lid, and a circle")
{
    dem::Random random(9);
    dem::Grains<3> loose, round;
    dem::Grains<2> discs;
    for (int k = 0; k < 6 * 6 * 6; ++k) {
        auto const place = [&](int n) { return (n + random.uniform(0.35, 0.65)) * 1e-2; };
        Vec3 const at{place(k % 6), place(k / 6 % 6), place(k / 36)};
        double const radius = random.uniform(1e-3, 3.5e-3), off = std::hypot(at.x - 0.03, at.y - 0.03);
        loose.add(at, radius, 2650.0);
        if (off < 0.028) round.add(at, radius, 2650.0);
        if (off < 0.028 && k < 36) discs.add({at.x, at.y}, radius, 2650.0);
    }
    auto const t = cells(box({0.06, 0.06, 0.06}), loose);
    CHECK(sum(t.volume) == close_to(0.06 * 0.06 * 0.06).epsilon(1e-9));
    CHECK(std::count(t.closed.begin(), t.closed.end(), true) == 216);

    double const radius = 0.03, area = pi * radius * radius;
    auto s = still<3>();
    add_wall<3>(s, dem::Plane<3>{{}, {0, 0, 1}});
    add_wall<3>(s, dem::Plane<3>{{0, 0, 0.06}, {0, 0, -1}});
    add_wall<3>(s, dem::Cylinder<3>{{radius, radius, 0}, {0, 0, 1}, radius, true});
    CHECK(sum(cells(s, round).volume) == close_to(area * 0.06).epsilon(1e-9));
    auto circle = still<2>();
    add_wall<2>(circle, dem::Cylinder<2>{{radius, radius}, {}, radius, true});
    CHECK(sum(cells(circle, discs).volume) == close_to(area).epsilon(1e-9));
}

TEST_CASE("voronoi: a cell at a free surface is not closed, nor one at a wall that has gone")
{
    double const r = 1e-3;
    auto s = still<2>();
    add_wall<2>(s, dem::Plane<2>{{0, 0}, {0, 1}});
    add_wall<2>(s, dem::Plane<2>{{0, 0}, {1, 0}});
    add_wall<2>(s, dem::Plane<2>{{6 * r, 0}, {-1, 0}}, 0.0);
    dem::Grains<2> g;
    for (int k = 0; k < 9; ++k) g.add({(2 * (k % 3) + 1) * r, (2 * (k / 3) + 1) * r}, r, 2650.0);
    dem::Solver<2> solver(s, g);
    auto const top_open = std::vector{true, true, true, true, true, true, false, false, false};
    CHECK(dem::tessellate(solver.setup(), solver.state()).closed == top_open);
    solver.step(1e-7);
    auto const gone = dem::tessellate(solver.setup(), solver.state());
    CHECK(gone.closed == std::vector{true, true, false, true, true, false, false, false, false});
    auto const p = dem::packed_of(solver.grains(), gone, {100 * r, false});
    CHECK(p.closed == 4);
    CHECK(p.fraction == close_to(pi / 4).epsilon(1e-6));
}

TEST_CASE("voronoi: the cells of a periodic gas fill its cell, wherever its sides are, at rest and sheared")
{
    auto const check = []<int D>(dem::Solver<D> start, int steps) {
        for (int n = 0; n < steps; ++n) start.step(unit::periodic_step);  // grains leave the cell between lists, too
        auto const& state = start.state();
        auto const t = dem::tessellate(start.setup(), state);
        double room = 1.0;
        for (int k = 0; k < D; ++k) room *= dem::component(state.cell.extent, k);
        CHECK(std::abs(sum(t.volume) - room) < 1e-9 * room);
        CHECK(std::ranges::all_of(t.closed, [](bool closed) { return closed; }));
        auto moved = state;  // all of it by parts of the cell
        for (auto& place : moved.grains.place)
            for (int k = 0; k < D; ++k)
                dem::component<D>(place.centre, k) += 0.37 * dem::component(state.cell.extent, k);
        auto const after = dem::tessellate(start.setup(), moved);
        for (std::size_t i = 0; i < t.volume.size(); ++i)
            CHECK(std::abs(after.volume[i] - t.volume[i]) < 1e-9 * t.volume[i]);
    };
    check(dem::Solver<2>(unit::cell<2>(unit::cube<2>(8)), unit::gas<2>(8, 1.0)), 500);
    check(dem::Solver<3>(unit::cell<3>(unit::cube<3>(5)), unit::gas<3>(5, 1.0)), 500);
    check(unit::sheared<2>(), 2000);
    check(unit::sheared<3>(), 2000);
}

TEST_CASE("voronoi: a square lattice sheared by a part of its spacing has cells of one size, by s = 1/2 in six sides")
{
    // radii alike: cells are those of the lattice (a, 0), (s a, a), all of area a^2
    double const a = 2.1e-3;
    for (double const part : {0.0, 0.25, 0.5, 1.0}) {
        dem::Setup<2> s = unit::cell<2>(unit::cube<2>(4));
        s.periodic.shear = {.along = 1, .across = 0, .rate = 1.0};
        dem::Grains<2> g;
        for (int k = 0; k < 16; ++k)
            g.add({(k / 4 + 0.5) * a, (k % 4 + 0.5 + part * (k / 4)) * a}, 1e-3, unit::density);
        dem::Solver<2> solver(s, g);
        dem::State<2> state = solver.state();
        state.cell.offset = 4 * a * part - 4 * a * std::round(part);
        for (auto const volume : dem::tessellate(solver.setup(), state).volume) CHECK(volume == close_to(a * a));
    }
}
