#include <doctest/doctest.h>

#include <cmath>

#include "participants/dem/domain.hpp"
#include "participants/dem/stress.hpp"
#include "tests/participants/dem/domain_runs.hpp"
#include "tests/participants/dem/domain_scenes.hpp"
#include "tests/participants/dem/periodic_scenes.hpp"

//! Grains of periodic cells shared out among processes (threads here).
using unit::alone, unit::cell, unit::cube, unit::gas, unit::periodic_step, unit::shared, unit::sheared,
    unit::without_sums;

namespace {

//! The same cell with so many processes, to the last bit; grains change process across the sides, too.
template <int D>
void check_same(dem::Solver<D> const& start, int steps)
{
    auto const one = alone(start, steps, periodic_step);
    REQUIRE(one.rebuilds > 10);
    for (int const processes : {1, 2, 3, 5}) {
        CAPTURE(processes);
        auto const many = shared(start, processes, steps, periodic_step);
        CHECK(without_sums(many.whole) == without_sums(one));
        CHECK(many.whole.rebuilds == one.rebuilds);
        for (std::size_t k = 0; k < one.cell.pull.size(); ++k)
            CHECK(norm(many.whole.cell.pull[k] - one.cell.pull[k]) <= 1e-12 * norm(one.cell.pull[k]));
        if (processes > 1) CHECK(many.migrated > 0);
    }
}

//! A gas between sides that slide past one another at a height that stays.
template <int D>
dem::Solver<D> sliding(int along, int across, bool ledger)
{
    auto const start = sheared<D>(ledger);
    dem::Setup<D> s = start.setup();
    s.periodic.shear = {.along = along, .across = across, .rate = 40.0};
    return {s, start.grains()};
}

}  // namespace

TEST_CASE("domain: a gas in a periodic cell is the same to the last bit on 1, 2, 3 and 5 processes")
{
    check_same(dem::Solver<2>(cell<2>(cube<2>(12)), gas<2>(12, 1.0)), 6000);
    check_same(dem::Solver<3>(cell<3>(cube<3>(6)), gas<3>(6, 1.0)), 4000);
}

TEST_CASE("domain: a chute of periodic length, with a floor and gravity, is the same to the last bit")
{
    dem::Setup<2> chute = cell<2>(cube<2>(12));
    chute.gravity = {5.0, -9.81};
    chute.periodic.axis = {true, false};
    unit::add_wall(chute, "floor", {0.0, 0.0}, {0.0, 1.0});
    check_same(dem::Solver<2>(chute, gas<2>(12, 1.0)), 6000);
}

TEST_CASE("domain: sides that slide past one another change no bit, along and across the slabs")
{
    check_same(sliding<2>(0, 1, true), 6000);
    check_same(sliding<2>(1, 0, true), 6000);
    check_same(sliding<3>(2, 0, false), 4000);
}

TEST_CASE("domain: the ledger of a cell whose images move is that of one process to rounding")
{
    int const steps = 8000;
    auto const start = sliding<2>(0, 1, true);
    auto const one = alone(start, steps, periodic_step);
    auto const whole = shared(start, 3, steps, periodic_step).whole;
    auto const ours = dem::energies(start.setup(), whole), theirs = dem::energies(start.setup(), one);
    REQUIRE(theirs.sliding > 0.0);
    REQUIRE(theirs.wall_work != 0.0);
    for (auto const part : {&dem::Energies::normal_dashpot, &dem::Energies::tangential_dashpot, &dem::Energies::sliding,
                            &dem::Energies::touch, &dem::Energies::wall_work})
        CHECK(std::abs(ours.*part - theirs.*part) < 1e-12 * theirs.lost());
    CHECK(std::abs(ours.balance() - theirs.balance()) < 1e-12 * theirs.balance());
}

TEST_CASE("domain: a height that follows a pressure does so on several processes")
{
    // the pressure is a sum over processes, added up in another order: rounding, which collisions magnify
    auto const start = sheared<2>(true);
    auto const early = alone(start, 300, periodic_step), late = alone(start, 12000, periodic_step);
    auto const few = shared(start, 3, 300, periodic_step).whole, many = shared(start, 3, 12000, periodic_step).whole;
    CHECK(std::abs(few.cell.extent.y / early.cell.extent.y - 1) < 1e-13);
    for (std::size_t i = 0; i < early.grains.size(); ++i)
        CHECK(norm(few.grains.place[i].centre - early.grains.place[i].centre) < 1e-12 * early.cell.extent.y);
    CHECK(many.cell.strain == late.cell.strain);
    double const scale = dem::energies(start.setup(), late).lost();
    CHECK(std::abs(dem::energies(start.setup(), many).balance() - start.energies().balance()) < 1e-4 * scale);
    // with the same processes the bits are the same
    CHECK(unit::kept(shared(start, 3, 3000, periodic_step).whole) ==
          unit::kept(shared(start, 3, 3000, periodic_step).whole));
}

TEST_CASE("domain: a checkpoint of two processes in a sheared cell goes on with one and with three")
{
    auto const start = sliding<2>(0, 1, true);
    auto const through = alone(start, 6000, periodic_step);
    dem::State<2> part, three;
    unit::on_processes(2, [&](ranks::Peers& peers) {
        dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(start.setup(), {});
        solver.share_out(peers);
        for (int n = 0; n < 3123; ++n) solver.step(periodic_step);
        auto const whole = solver.whole();
        if (peers.rank() == 0) part = whole;
    });
    auto const bytes = unit::kept(part);
    auto const state = [&](bool root) {
        auto kept = dem::kept_state<2>(bytes, start.setup(), start.grains().size());
        if (root) return kept;
        dem::State<2> none;
        none.walls.resize(start.setup().walls.size());
        return none;
    };
    dem::Solver<2> one(start.setup(), {});
    one.restore(state(true));
    CHECK(without_sums(alone(one, 6000 - 3123, periodic_step)) == without_sums(through));
    unit::on_processes(3, [&](ranks::Peers& peers) {
        dem::Solver<2> solver(start.setup(), {});
        solver.share_out(peers);
        solver.restore(state(peers.rank() == 0));
        for (int n = 3123; n < 6000; ++n) solver.step(periodic_step);
        auto const whole = solver.whole();
        if (peers.rank() == 0) three = whole;
    });
    CHECK(without_sums(three) == without_sums(through));
}
