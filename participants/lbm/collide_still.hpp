#pragma once

#include <algorithm>

#include "participants/lbm/collide_space.hpp"

//! The collision of rows of D3Q19 in which solids rest.
namespace lbm {

//! Collides registers from `begin` on that begin before `end`, found by find(x) and changed by change(x, found), each
//! found before the last one changes; returns where the next one begins.
template <bool ahead, std::ptrdiff_t lanes, class Find, class Change>
[[gnu::always_inline]] inline std::ptrdiff_t collide_registers(std::ptrdiff_t begin, std::ptrdiff_t end, OnTheWay& way,
                                                               Find&& find, Change&& change)
{
    std::ptrdiff_t x = begin;
    if constexpr (ahead) {
        if (x >= end) return x;
        way.reach(x);
        auto now = find(x);
        for (x += lanes; x < end; x += lanes) {
            way.reach(x);
            auto const next = find(x);
            change(x - lanes, now);
            now = next;
        }
        change(x - lanes, now);
    } else {
        for (; x < end; x += lanes) {
            way.reach(x);
            change(x, find(x));
        }
    }
    return x;
}

//! Collides the slots [begin, end) of rows in line, whole registers; `slots` are those of the slot `origin`. Where
//! solids are as `solid`, else as `fluid`: the same bits where there are none.
template <Features fluid, Features solid, class Stored>
void collide_slots(Slots<3, Stored> const& slots, std::ptrdiff_t origin, StillBlock<Stored> const& block,
                   std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& relaxation)
{
    using V = Lanes<Stored>;
    using Numbers = StillNumbers<Stored>;
    using Change = SpaceChange<fluid.frame, V>;
    constexpr auto lanes = Numbers::lanes;
    constexpr bool ahead = !fluid.les && !fluid.split;  // more is found than stays in registers
    Slots<3, Stored> const f = slots;
    Relaxation const r = relaxation;
    StillBlock<Stored> const rows = block;
    OnTheWay nothing, &way = block.on_the_way ? *block.on_the_way : nothing;
    SolidCell<3, V> none;
    V place;
    auto const find_fluid = [&](std::ptrdiff_t x) __attribute__((always_inline))
    {
        if constexpr (fluid.frame) place = counted_from<V>(static_cast<double>(x));
        return find_change<fluid, V>(CellInRow<V, Stored>{f, x - origin}, r, rates_of<fluid, V>(r, none), none, place);
    };
    auto const change_fluid = [&](std::ptrdiff_t x, Change const& c) __attribute__((always_inline))
    {
        change<fluid, V>(CellInRow<V, Stored>{f, x - origin}, c, rates_of<fluid, V>(r, none), V{});
    };
    std::ptrdiff_t x = begin;
    auto const collide_run = [&](StillRun const& run, std::ptrdiff_t row) __attribute__((always_inline))
    {
        std::ptrdiff_t const to = std::min(end, row + run.end), free = std::min(end, row + run.begin - lanes + 1);
        Numbers const numbers(rows.numbers, run, -row);
        auto const find_still = [&](std::ptrdiff_t at) __attribute__((always_inline))
        {
            StillCell<V> s(numbers.from(at));
            if constexpr (fluid.frame) place = counted_from<V>(static_cast<double>(at));
            Change const found = find_change<solid, V>(CellInRow<V, Stored>{f, at - origin}, r, s.rates, s, place);
            if (rows.force[0] != nullptr)
                for (std::size_t k = 0; k < 3; ++k) store(rows.force[k] + at, s.force[k]);
            return found;
        };
        auto const change_still = [&](std::ptrdiff_t at, Change const& c) __attribute__((always_inline))
        {
            StillCell<V> const s(numbers.from(at));  // once more: there is no room in the registers
            change<solid, V>(CellInRow<V, Stored>{f, at - origin}, c, s.rates, s.pull);
        };
        x = collide_registers<ahead, lanes>(x, free, way, find_fluid, change_fluid);
        x = collide_registers<ahead, lanes>(x, to, way, find_still, change_still);
    };
    for (std::ptrdiff_t k = begin / rows.stride; k < rows.count; ++k)
        for (std::uint32_t run = rows.rows[k].at, last = run + rows.rows[k].count; run < last; ++run)
            collide_run(rows.runs[run], k * rows.stride);
    collide_registers<ahead, lanes>(x, end, way, find_fluid, change_fluid);
}

//! Collides rows in line in which solids rest, with what lies between them.
template <Features fluid, Features solid, class Stored>
void collide_still(AnySlots<3> const& any_slots, AnyStillBlock const& any_block, Relaxation const& relaxation)
{
    Slots<3, Stored> const slots = typed<3, Stored>(any_slots);
    auto const block = any_block.typed<Stored>();
    constexpr auto lanes = StillNumbers<Stored>::lanes;
    std::ptrdiff_t const end = (block.count - 1) * block.stride + block.cells, whole = end / lanes * lanes;
    if (whole > 0) collide_slots<fluid, solid>(slots, 0, block, 0, whole, relaxation);
    if (whole == end) return;
    if (block.on_the_way) block.on_the_way->reach(whole);
    RowEndCells<3, Stored> const cells(slots, whole, FirstLanes<Stored>(end - whole));
    collide_slots<fluid, solid>(cells.slots(), whole, block, whole, whole + lanes, relaxation);
    cells.put_back();
}

}  // namespace lbm
