#include "participants/lbm/live_cells.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "coupler/base/error.hpp"
#include "tests/participants/lbm/bent_channel.hpp"
#include "tests/participants/lbm/kept_populations.hpp"
#include "tests/participants/lbm/unit_config.hpp"

namespace {

template <int D>
lbm::Config box_of(std::array<double, 3> const& size)
{
    auto c = unit_config<D>(size, 0.05);
    c.collision = lbm::Operator::trt;
    return c;
}

//! An S of 10 cells across, from the left side to the right one; about a tenth of the box.
lbm::Config bent_channel()
{
    lbm::Config c = box_of<2>({160, 120, 0});
    c.solids = bent_channel_solids();
    return c;
}

template <int D>
std::vector<lbm::Box> boxes_of(lbm::Config const& c)
{
    return lbm::live_boxes(c.cells(), {c.periodic(0), c.periodic(1), c.periodic(2)}, lbm::patches_of<D>(c));
}

//! Populations of all cells, shape [q][z][y][x]; 0 where none are stored.
template <int D>
std::vector<double> by_place(lbm::Solver<D>& solver)
{
    auto const kept = populations_of(solver);
    lbm::Layout const& layout = solver.layout();
    auto const [nx, ny, nz] = layout.cells();
    std::vector<double> all(lbm::Lattice<D>::directions * static_cast<std::size_t>(nx * ny * nz), 0.0);
    auto from = kept.begin();
    for (std::size_t q = 0; q < lbm::Lattice<D>::directions; ++q)
        for (std::ptrdiff_t r = 0; r < layout.rows(); ++r) {
            lbm::Row const& row = layout.row(r);
            std::ptrdiff_t const to = ((static_cast<std::ptrdiff_t>(q) * nz + row.z) * ny + row.y) * nx + row.first;
            std::copy_n(from, row.cells, all.begin() + to);
            from += row.cells;
        }
    return all;
}

//! All cells in two boxes along each of the axes from `first_axis` on, of unequal size.
template <int D>
std::vector<lbm::Box> pieces(lbm::Extent const& n, std::size_t first_axis)
{
    std::vector<lbm::Box> boxes;
    for (std::size_t part = 0; part < (D == 2 ? 4 : 8); part += std::size_t{1} << first_axis) {
        lbm::Box box{{0, 0, 0}, n};
        for (std::size_t k = first_axis; k < D; ++k) {
            std::ptrdiff_t const cut = n[k] / 3 + static_cast<std::ptrdiff_t>(k);
            bool const upper = (part >> k & 1) != 0;
            box.first[k] = upper ? cut : 0;
            box.size[k] = upper ? n[k] - cut : cut;
        }
        boxes.push_back(box);
    }
    return boxes;
}

//! Sides of all kinds, by number.
template <int D>
lbm::Config with_sides(lbm::Config c, int kind)
{
    using enum lbm::Border;
    if (kind == 0) c.walls[lbm::top<D>].velocity = {0.02, 0, 0};
    if (kind == 1)
        for (std::size_t k = 0; k < D; ++k) c.set_periodic(k);
    if (kind == 2) {
        c.walls[lbm::left] = {.kind = inflow, .velocity = {0.02, 0, 0}, .parabola = true, .ramp = 9};
        c.walls[lbm::right].kind = pressure;
        c.walls[lbm::upper_y].kind = slip;
    }
    if (kind == 3) {
        for (lbm::Wall& wall : c.walls) wall.kind = slip;
        c.set_periodic(0);
        c.smagorinsky = 0.1;
        c.acceleration = {1e-5, 0, 0};
    }
    return c;
}

//! Whole rows have the same bits. Cut rows have them where no solid is near: beside solids, cells are computed in
//! blocks that begin with the row.
template <int D>
void check_boxes(lbm::Precision precision, int kind, bool solids)
{
    lbm::Config c = with_sides<D>(box_of<D>({25, 22, D == 2 ? 0.0 : 18}), kind);
    c.precision = precision;
    if (solids) c.solids = {block({15.3, 4, 3}, {21, 11.2, 9})};
    lbm::Solver<D> one(c);
    c.threads = 2;
    lbm::Solver<D> many(c, lbm::patches_of<D>(c), pieces<D>(c.cells(), solids ? 1 : 0));
    REQUIRE(many.layout().boxes().size() == (D == 2 ? 4 : 8) / (solids ? 2 : 1));
    std::vector<double> at(D, 8.2), velocity(D, 0.01), spin(lbm::spins<D>, 1e-3), radius{4.3};
    for (int k = 0; k < 150; ++k) {  // slack along x is used up after 128
        for (double& x : at) x += 0.01;
        for (auto* solver : {&one, &many}) {
            if (solids) solver->set_bodies({at, velocity, spin, radius});
            solver->step();
        }
    }
    CHECK(by_place(one) == by_place(many));
    CHECK(std::ranges::equal(many.loads().force, one.loads().force));
    CHECK(std::ranges::equal(many.solid_loads().force, one.solid_loads().force));
    CHECK(many.fields().velocity == one.fields().velocity);
}

//! A channel along x between blocks, in a box many times as large, and in one that ends where the flow's reach does.
template <int D>
void check_against_walls(double offset)
{
    lbm::Config large = box_of<D>({16, 60, D == 2 ? 0.0 : 40});
    large.set_periodic(0);
    large.acceleration = {1e-5, 0, 0};
    lbm::Config small = large;
    double const z0 = D == 2 ? 0 : 12 - offset, z1 = D == 2 ? 0 : 24 + offset;
    large.solids = {block({0, 0, 0}, {16, 20 - offset, 40}), block({0, 30 + offset, 0}, {16, 60, 40})};
    if (D == 3) {
        large.solids.push_back(block({0, 20 - offset, 0}, {16, 30 + offset, z0}));
        large.solids.push_back(block({0, 20 - offset, z1}, {16, 30 + offset, 40}));
    }
    double const reach = offset > 0 ? 2 : 0;  // cells: one that is covered in part, one wholly
    small.solids = large.solids;
    small.origin = {0, 20 - reach, D == 2 ? 0 : 12 - reach};
    small.size = {16, 10 + 2 * reach, D == 2 ? 0 : 12 + 2 * reach};
    lbm::Solver<D> cut(large), walls(small);
    REQUIRE(cut.layout().boxes() == std::vector<lbm::Box>{{{0, static_cast<std::ptrdiff_t>(20 - reach),
                                                            D == 2 ? 0 : static_cast<std::ptrdiff_t>(12 - reach)},
                                                           small.cells()}});
    CHECK(walls.layout().whole());
    for (int k = 0; k < 300; ++k) {
        cut.step();
        walls.step();
    }
    CHECK(populations_of(cut) == populations_of(walls));
}

//! A channel along x between slabs whose faces cut cells, over a floor and under a roof whose faces do not: nothing of
//! these is stored, and they are as the domain's own walls.
template <int D>
void check_floor()
{
    constexpr std::size_t up = D - 1;
    std::array<double, 3> const n = D == 2 ? std::array<double, 3>{24, 36, 0} : std::array<double, 3>{16, 20, 36};
    lbm::Config large = box_of<D>(n);
    large.acceleration = {1e-5, 2e-5, 0};
    auto const add = [](lbm::Config& c, std::array<double, 3> low, std::array<double, 3> high, double from, double to) {
        low[up] = from, high[up] = to;
        c.solids.push_back(block(low, high));
    };
    lbm::Config small = large;
    small.origin[up] = 9;
    small.size[up] = 14;
    std::array<double, 3> const slab = D == 2 ? std::array<double, 3>{5.3, 0, 0} : std::array<double, 3>{16, 5.3, 0};
    std::array<double, 3> const other = D == 2 ? std::array<double, 3>{17.6, 0, 0} : std::array<double, 3>{0, 14.6, 0};
    for (lbm::Config* const c : {&large, &small}) {
        add(*c, {0, 0, 0}, slab, 9, 23);
        add(*c, other, n, 9, 23);
    }
    add(large, {0, 0, 0}, n, 0, 9);
    add(large, {0, 0, 0}, n, 23, 36);
    lbm::Solver<D> cut(large), walls(small);
    REQUIRE(cut.layout().boxes().size() == walls.layout().boxes().size());
    for (std::size_t b = 0; b < cut.layout().boxes().size(); ++b)
        CHECK(cut.layout().boxes()[b].size == walls.layout().boxes()[b].size);
    for (int k = 0; k < 100; ++k) {
        cut.step();
        walls.step();
    }
    CHECK(populations_of(cut) == populations_of(walls));
    double fastest = 0;
    for (double const u : cut.fields().velocity) fastest = std::max(fastest, std::abs(u));
    CHECK(fastest > 1e-5);
}

//! Between blocks a shaft up to a lid, or through from an inflow to a pressure; and the same between the domain's
//! walls.
template <int D>
void check_shaft(bool open)
{
    constexpr lbm::Side below = lbm::bottom<D>, above = lbm::top<D>;
    lbm::Config large = D == 2 ? box_of<2>({40, 24, 0}) : box_of<3>({40, 6, 24});
    large.walls[above].velocity = {0.05, 0, 0};
    if (open) {
        large.walls[below] = {.kind = lbm::Border::inflow};
        large.walls[below].velocity[D - 1] = 0.05;
        large.walls[above] = {.kind = lbm::Border::pressure, .absorbing = D == 3};
    }
    if (D == 3) large.set_periodic(1);
    lbm::Config small = large;
    small.origin[0] = 15;
    small.size[0] = 12;
    large.solids = {block({0, 0, 0}, {15, 24, 24}), block({27, 0, 0}, {40, 24, 24})};
    lbm::Solver<D> cut(large), walls(small);
    REQUIRE(cut.layout().stored() == walls.layout().stored());
    for (int k = 0; k < 100; ++k) {
        cut.step();
        walls.step();
    }
    CHECK(populations_of(cut) == populations_of(walls));
}

}  // namespace

TEST_CASE("live cells: boxes share no cell, and leave out only what is covered, but not beside what is in part")
{
    lbm::Config c = bent_channel();
    lbm::Solid pile;
    pile.centre = {120, 95, 0};
    pile.radius = 90;
    for (bool const round : {false, true}) {
        if (round) {
            c.solids = {pile};
            c.set_periodic(0);
            c.size = {200, 190, 0};
        }
        auto const [nx, ny, nz] = c.cells();
        auto const boxes = boxes_of<2>(c);
        CHECK(boxes.size() > 1);
        std::vector<int> held(static_cast<std::size_t>(nx * ny), 0);
        for (lbm::Box const& box : boxes)
            for (std::ptrdiff_t y = 0; y < box.size[1]; ++y)
                for (std::ptrdiff_t x = 0; x < box.size[0]; ++x)
                    ++held[static_cast<std::size_t>((box.first[1] + y) * nx + box.first[0] + x)];
        CHECK(*std::max_element(held.begin(), held.end()) == 1);
        auto const stored = std::accumulate(held.begin(), held.end(), 0);
        lbm::Solver<2> whole(c, lbm::patches_of<2>(c), {{{0, 0, 0}, c.cells()}});
        auto const fraction = whole.fields().solid_fraction;
        int live = 0;
        for (std::ptrdiff_t y = 0; y < ny; ++y)
            for (std::ptrdiff_t x = 0; x < nx; ++x) {
                auto const covered = [&](std::ptrdiff_t dx, std::ptrdiff_t dy) {
                    std::ptrdiff_t const at = c.periodic(0) ? (x + dx + nx) % nx : x + dx;
                    bool const inside = at >= 0 && at < nx && y + dy >= 0 && y + dy < ny;
                    return inside ? fraction[static_cast<std::size_t>((y + dy) * nx + at)] : 0.0;
                };
                bool open = covered(0, 0) < 1 - 1e-9;
                for (std::ptrdiff_t dy : {-1, 0, 1})
                    for (std::ptrdiff_t dx : {-1, 0, 1})
                        open = open || (covered(dx, dy) > 1e-9 && covered(dx, dy) < 1 - 1e-9);
                live += open ? 1 : 0;
                if (open) CHECK(held[static_cast<std::size_t>(y * nx + x)] == 1);
            }
        auto const filled = [](double cells, lbm::Box const& box) {
            return cells + 3.5 * static_cast<double>(box.size[1]);
        };
        double const to_registers =
            round ? std::accumulate(boxes.begin(), boxes.end(), 0.0, filled) : 0;  // in the mean
        CHECK(stored < (round ? 1.2 : 1.05) * live + to_registers);
    }
}

TEST_CASE("live cells: small solids leave the lattice in one piece")
{
    lbm::Config c = box_of<2>({60, 40, 0});
    CHECK(boxes_of<2>(c) == std::vector<lbm::Box>{{{0, 0, 0}, c.cells()}});
    c.solids = {block({20, 10, 0}, {34, 24, 0})};
    CHECK(boxes_of<2>(c) == std::vector<lbm::Box>{{{0, 0, 0}, c.cells()}});
}

TEST_CASE_TEMPLATE("live cells: a lattice in many boxes has the bits of one", Axes, std::integral_constant<int, 2>,
                   std::integral_constant<int, 3>)
{
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32})
        for (int kind = 0; kind < 4; ++kind)
            for (bool const solids : {false, true}) check_boxes<Axes::value>(precision, kind, solids);
}

TEST_CASE("live cells: rows that are cut beside solids agree to rounding")
{
    lbm::Config c = with_sides<2>(box_of<2>({45, 32, 0}), 0);
    c.solids = {block({15.3, 4, 0}, {31, 21.2, 0})};
    lbm::Solver<2> one(c), many(c, lbm::patches_of<2>(c), pieces<2>(c.cells(), 0));
    std::vector<double> const at{11.4, 27}, velocity{0.01, 0}, spin{1e-3}, radius{4.3};
    for (auto* solver : {&one, &many})
        for (int k = 0; k < 100; ++k) {
            solver->set_bodies({at, velocity, spin, radius});
            solver->step();
        }
    auto const a = by_place(one), b = by_place(many);
    for (std::size_t k = 0; k < a.size(); ++k) CHECK(std::abs(a[k] - b[k]) < 1e-15);  // populations of 0.02
    for (std::size_t k = 0; k < 2; ++k) {
        CHECK(std::abs(many.loads().force[k] - one.loads().force[k]) <= 1e-11 * std::abs(one.loads().force[k]));
        CHECK(std::abs(many.solid_loads().force[k] - one.solid_loads().force[k]) <=
              1e-11 * std::abs(one.solid_loads().force[k]));
    }
}

TEST_CASE("live cells: what is left out is as a wall at rest in its place, bit for bit")
{
    for (double const offset : {0.0, 0.25}) {
        check_against_walls<2>(offset);
        check_against_walls<3>(offset);
    }
}

TEST_CASE("live cells: so it is beside lids, inflows and outlets, bit for bit")
{
    for (bool const open : {false, true}) {
        check_shaft<2>(open);
        check_shaft<3>(open);
    }
}

//! TRT with magic = 3/16 is exact between half-way walls (L01); in the cells of a solid B < 1 lets it slip.
TEST_CASE("live cells: between blocks of whole cells a channel has the exact parabola")
{
    lbm::Config c = box_of<2>({8, 40, 0});
    double const width = 8, fastest = 1e-3;
    c.viscosity = 0.1;
    c.set_periodic(0);
    c.acceleration = {8 * c.viscosity * fastest / (width * width), 0, 0};
    c.solids = {block({0, 0, 0}, {8, 16, 0}), block({0, 24, 0}, {8, 40, 0})};
    lbm::Solver<2> solver(c);
    REQUIRE(solver.layout().stored() == 8 * 8);
    for (int k = 0; k < 4000; ++k) solver.step();
    auto const velocity = solver.fields().velocity;
    for (std::ptrdiff_t y = 16; y < 24; ++y) {
        double const d = static_cast<double>(y) + 0.5 - 20;
        CHECK(std::abs(velocity[static_cast<std::size_t>(2 * y * 8)] - fastest * (1 - 4 * d * d / (width * width))) <
              1e-11 * fastest);
    }
}

TEST_CASE("live cells: momentum that solids get is what the lattice loses")
{
    lbm::Config c = box_of<2>({100, 90, 0});
    c.set_periodic(0);
    c.acceleration = {2e-5, 0, 0};
    c.solids = {block({0, 0, 0}, {100, 30, 0}), block({0, 62.5, 0}, {100, 90, 0}), block({30, 28, 0}, {80, 50, 0})};
    lbm::Solver<2> solver(c);
    REQUIRE(solver.layout().stored() < 0.5 * 100 * 90);
    double const a = c.acceleration[0], before = solver.momentum()[0];
    auto const covered = solver.solid_volumes();
    std::vector<double> exchange(c.solids.size(), 0.0);
    double lost = 0;
    int const steps = 400;
    for (int k = 0; k < steps; ++k) {
        solver.step();
        for (std::size_t i = 0; i < exchange.size(); ++i) {
            exchange[i] = 2 * (solver.solid_loads().force[2 * i] + covered[i] * a) - exchange[i];
            lost += exchange[i];
        }
    }
    double const given = steps * a * static_cast<double>(solver.layout().stored());
    CHECK(std::abs(solver.momentum()[0] - before - (given - lost)) <= 1e-10 * given);
}

TEST_CASE("live cells: a solid with a core that is left out floats up as it should, with the right torque")
{
    lbm::Config c = box_of<2>({120, 120, 0});
    double const g = 1e-5;
    c.acceleration = {0, -g, 0};
    c.viscosity = 0.3;
    c.solids = {block({10, 10, 0}, {110, 110, 0})};
    auto patches = lbm::patches_of<2>(c);
    patches[0].centre = {12, 20};  // torque is about it
    lbm::Solver<2> solver(c, patches);
    REQUIRE(solver.layout().stored() < 0.5 * 120 * 120);
    for (int k = 0; k < 8000; ++k) solver.step();
    double const weight = 100.0 * 100 * g;
    CHECK(std::abs(solver.solid_loads().force[1] - weight) <= 2e-3 * weight);
    CHECK(std::abs(solver.solid_loads().force[0]) < 1e-6 * weight);
    CHECK(std::abs(solver.solid_loads().torque[0] - (60 - 12) * weight) <= 2e-3 * 48 * weight);
}

TEST_CASE("live cells: what solids get through cells that are left out does not depend on which axis is which")
{
    std::vector<std::array<double, 3>> first;  // force and torque of each solid
    for (std::size_t by = 0; by < 3; ++by) {
        auto const turned = [&](std::array<double, 3> const& v) {
            return std::array<double, 3>{v[(3 - by) % 3], v[(4 - by) % 3], v[(5 - by) % 3]};
        };
        lbm::Config c = box_of<3>(turned({24, 20, 22}));
        c.acceleration = turned({1e-4, -2e-4, 3e-4});
        c.solids = {block(turned({9, 0, 0}), turned({24, 20, 22})), block(turned({0, 0, 13}), turned({9, 20, 22}))};
        lbm::Solver<3> solver(c);
        REQUIRE(solver.layout().stored() == 9 * 20 * 13);
        for (int k = 0; k < 60; ++k) solver.step();
        for (std::size_t i = 0; i < 2; ++i)
            for (auto const& of : {solver.solid_loads().force, solver.solid_loads().torque}) {
                std::array<double, 3> const load{of[3 * i + by], of[3 * i + (by + 1) % 3], of[3 * i + (by + 2) % 3]};
                if (by == 0) first.push_back(load);
                auto const& expected = first[2 * i + (of.data() == solver.solid_loads().torque.data() ? 1 : 0)];
                double const size = std::abs(expected[0]) + std::abs(expected[1]) + std::abs(expected[2]);
                CHECK(size > 1e-3);
                for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(load[k] - expected[k]) < 1e-12 * size);
            }
    }
}

TEST_CASE_TEMPLATE("live cells: loads on solids that are left out change nothing else, and are the same a step later",
                   Space, std::integral_constant<int, 2>, std::integral_constant<int, 3>)
{
    constexpr int D = Space::value;
    lbm::Config c = box_of<D>({40, 30, D == 2 ? 0.0 : 20});
    c.set_periodic(0);
    c.acceleration = {1e-5, 2e-6, 0};
    c.solids = {block({0, 0, 0}, {40, 12.3, 20}), block({17.4, 5, 4}, {22, 20.2, 16})};
    lbm::Solver<D> always(c), seldom(c);
    std::vector<double> at(D, 15.2), velocity(D, 0.01), spin(lbm::spins<D>, 1e-3), radius{2.3};
    at[1] = 24.2;
    auto const step = [&](lbm::SolidLoads of_other) {
        for (auto* solver : {&always, &seldom}) solver->set_bodies({at, velocity, spin, radius});
        always.step();
        seldom.step(of_other);
        for (double& x : at) x += 0.01;
    };
    for (int k = 0; k < 20; ++k) step(lbm::SolidLoads::left_out);
    CHECK(std::ranges::equal(always.loads().force, seldom.loads().force));
    sluice::State kept, without;
    seldom.keep(without);
    CHECK_FALSE(without.has("solids/exchange"));
    seldom.restore(without);
    step(lbm::SolidLoads::found);
    always.keep(kept);
    auto const exchange = kept.numbers("solids/exchange", (D + lbm::spins<D>)*c.solids.size());
    auto const covered = seldom.solid_volumes();
    for (std::size_t i = 0; i < c.solids.size(); ++i) {
        double const only = exchange[(D + lbm::spins<D>)*i] - covered[i] * c.acceleration[0];
        CHECK(std::abs(seldom.solid_loads().force[D * i] - only) <= 1e-14 * std::abs(only));
        CHECK(std::abs(always.solid_loads().force[D * i] - only) > 1e-6 * std::abs(only));  // a step later it is not
    }
    step(lbm::SolidLoads::found);
    CHECK(std::ranges::equal(always.solid_loads().force, seldom.solid_loads().force));
    CHECK(std::ranges::equal(always.solid_loads().torque, seldom.solid_loads().torque));
    CHECK(by_place(always) == by_place(seldom));
}

TEST_CASE("live cells: behind a face between cells nothing is stored, though a surface beside it cuts cells")
{
    check_floor<2>();
    check_floor<3>();
}

TEST_CASE("live cells: a run goes on bit for bit, whatever the number of threads")
{
    lbm::Config c = bent_channel();
    c.walls[lbm::left].kind = lbm::Border::pressure;
    c.walls[lbm::left].pressure = 1e-3;
    c.walls[lbm::right].kind = lbm::Border::pressure;
    lbm::Solver<2> whole(c);
    c.threads = 2;
    lbm::Solver<2> resumed(c);
    sluice::State middle, end, again;
    for (int k = 0; k < 90; ++k) whole.step();
    whole.keep(middle);
    resumed.restore(middle);
    for (int k = 0; k < 90; ++k) {
        whole.step();
        resumed.step();
    }
    whole.keep(end);
    resumed.keep(again);
    CHECK(end == again);
    CHECK(std::ranges::equal(whole.solid_loads().force, resumed.solid_loads().force));

    lbm::Solver<2> other(c, lbm::patches_of<2>(c), {{{0, 0, 0}, {160, 120, 1}}});
    sluice::State kept;
    other.keep(kept);
    CHECK_THROWS_AS(resumed.restore(kept), sluice::Error);
}

TEST_CASE("live cells: nothing flows in through a side where solids cover it")
{
    lbm::Config c = box_of<2>({60, 60, 0});
    c.solids = {block({0, 0, 0}, {60, 20, 0}), block({0, 40, 0}, {60, 60, 0})};
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.01, 0, 0}};
    c.walls[lbm::right].kind = lbm::Border::pressure;
    lbm::Solver<2> solver(c);
    REQUIRE(!solver.layout().whole());
    for (int k = 0; k < 3000; ++k) solver.step();  // the rim of the solids filled up before
    CHECK(std::abs(solver.max_speed() - 0.015) < 0.0015);
}

TEST_CASE("live cells: what is left out is solid at rest in pictures")
{
    lbm::Config const c = bent_channel();
    lbm::Solver<2> solver(c);
    solver.step();
    lbm::Fields const f = solver.fields();
    CHECK(f.solid_fraction.size() == 160 * 120);
    CHECK(solver.layout().stored() < 160 * 120 / 4);
    CHECK(f.solid_fraction[60 * 160 + 20] == 1);
    CHECK(f.velocity[2 * (60 * 160 + 20)] == 0);
    CHECK(f.solid_fraction[60 * 160 + 105] == 0);
}

//! 0.3/0.01 is 30 less 4e-15: no cell beyond a face that lies between cells is one with solid.
TEST_CASE("live cells: boxes of whole cells, in metres, leave no traces beyond their faces")
{
    constexpr double cell = 0.01;
    lbm::Config c;
    c.dimension = 3;
    c.cell = cell;
    c.size = {0.4, 0.4, 0.02};
    for (int from = 0; from < 40; ++from)
        for (int to = from + 1; to <= 40; ++to) {
            double const low = cell * from, high = cell * to;
            c.solids = {block({low, low, 0}, {high, high, 2 * cell})};
            auto const fraction = lbm::patches_of<3>(c).at(0).fraction;
            CHECK(std::ranges::count_if(fraction, [](double f) { return f > 0; }) == 2 * (to - from) * (to - from));
        }
}
