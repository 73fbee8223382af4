#pragma once

#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/scenes.hpp"

//! Of runs whose grains are shared out, and what is compared of them.
namespace unit {

//! All that a checkpoint keeps but for sums over processes, whose terms are added up in another order.
template <int D>
sluice::State without_sums(dem::State<D> state)
{
    state.booked = {};
    state.power = {};
    for (auto& wall : state.walls) wall.force = {};
    state.cell.pull = {};
    return kept(state);
}

//! The box of the other tests, 16 ms: its left wall pushes, its right one is a gate, its floor gives way in the end.
inline dem::Solver<2> collapse(bool ledger = false)
{
    dem::Setup<2> s = box(ledger).setup();
    s.walls[1].motion.velocity = {0.4, 0.0};
    s.walls[2].removed_at = 0.002;
    s.walls[0].removed_at = 0.012;
    return {s, loose(12, 5, 0.3)};
}

}  // namespace unit
