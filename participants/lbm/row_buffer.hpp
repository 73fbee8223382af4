#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/phase.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/strip.hpp"

//! What the solids in a row do to its cells, gathered from their strips, and what these get.
namespace lbm {

//! One row's solids; each thread keeps its own. Strips are worked on in whole lanes: beyond the row's end lie cells
//! that take what a strip cut off there has left, and exchange nothing.
template <class Stored>
struct RowBuffer
{
    std::vector<Stored> fraction, drag;
    std::vector<Stored> lag;  //!< sum of eps R, or with forced bodies of their eps
    std::vector<Stored> weight, open, ease, force_rate;
    std::array<std::vector<Stored>, 3> momentum, force;
    std::vector<char> touched;  //!< for each block
    struct Run
    {
        std::ptrdiff_t begin, end;
        bool touched;
    };
    std::vector<Run> runs;       //!< of the row, cells with solids and without
    std::vector<Stored> covers;  //!< fractions of each strip's cells, in whole lanes, one strip after another
    std::array<std::vector<Stored>, 3> block_force;  //!< of the slots of a StillBlock

    //! Room for the longest row, and for one of nx cells.
    void resize(std::ptrdiff_t longest, std::ptrdiff_t nx)
    {
        auto const n = static_cast<std::size_t>(longest + strip_lanes);
        if (fraction.size() < n) {
            for (auto* v : {&fraction, &drag, &lag, &weight, &open, &ease, &force_rate}) v->assign(n, Stored{});
            for (auto* vectors : {&momentum, &force})
                for (auto& v : *vectors) v.assign(n, Stored{});
            touched.resize(n / block + 2);
        }
        for (auto* v : {&fraction, &force_rate, &force[0], &force[1], &force[2]})
            std::fill_n(v->begin() + nx, strip_lanes, Stored{});
    }
    SolidRow<Stored> view()
    {
        return {fraction.data(),
                weight.data(),
                open.data(),
                ease.data(),
                {momentum[0].data(), momentum[1].data(), momentum[2].data()},
                force_rate.data(),
                {force[0].data(), force[1].data(), force[2].data()}};
    }
    SolidRowInput<Stored> input()
    {
        return {fraction.data(),
                weight.data(),
                open.data(),
                ease.data(),
                {momentum[0].data(), momentum[1].data(), momentum[2].data()}};
    }
};

template <class Stored>
RowBuffer<Stored>& row_buffer()
{
    thread_local RowBuffer<Stored> buffer;  // not as a template of its own: GCC 12 forgets to destroy those
    return buffer;
}

//! Marks the blocks of a strip.
template <class Stored, int D>
void touch(Strip<D> const& s, RowBuffer<Stored>& row)
{
    std::fill(row.touched.begin() + s.begin / block, row.touched.begin() + (s.begin + s.whole_lanes() - 1) / block + 1,
              1);
}

//! Cuts a row of nx cells into runs of blocks that are alike, of whole registers: only the row's last one may be cut
//! short, for a kernel takes the rest of a register as a copy.
template <class Stored>
void list_runs(RowBuffer<Stored>& row, std::ptrdiff_t nx)
{
    constexpr std::ptrdiff_t lanes = std::max<std::ptrdiff_t>(block, Lanes<Stored>::count), in_one = lanes / block;
    std::ptrdiff_t const registers = (nx + lanes - 1) / lanes;
    auto const is_touched = [&](std::ptrdiff_t at) {
        char const* const blocks = row.touched.data() + at * in_one;
        return std::any_of(blocks, blocks + in_one, [](char touched) { return touched != 0; });
    };
    row.runs.clear();
    for (std::ptrdiff_t first = 0, last = 0; first < registers; first = last) {
        bool const touched = is_touched(first);
        while (last < registers && is_touched(last) == touched) ++last;
        row.runs.push_back({first * lanes, std::min(last * lanes, nx), touched});
    }
}

template <int D, class Stored>
void clear(typename RowBuffer<Stored>::Run const& run, RowBuffer<Stored>& row)
{
    auto const fill = [&](std::vector<Stored>& v) { std::fill(v.begin() + run.begin, v.begin() + run.end, Stored{}); };
    for (auto* v : {&row.fraction, &row.drag, &row.lag}) fill(*v);
    for (std::size_t k = 0; k < D; ++k) fill(row.momentum[k]);
}

//! A row of nx cells with these strips of all, and what mark(touched) adds: cut into runs, those with solids empty.
template <int D, class Stored, class Mark>
void begin_row(RowBuffer<Stored>& row, std::ptrdiff_t nx, std::span<std::uint32_t const> strips,
               std::span<Strip<D> const> all, Mark&& mark)
{
    std::fill_n(row.touched.begin(), (nx + block - 1) / block + 1, 0);
    for (std::uint32_t const k : strips) touch(all[k], row);
    mark(row.touched);
    list_runs(row, nx);
    for (auto const& run : row.runs)
        if (run.touched) clear<D>(run, row);
}

//! Writes the fractions of the strips' cells; all before any is read, which would have to wait for them.
template <int D, class Stored>
void write_covers(RowBuffer<Stored>& row, std::span<std::uint32_t const> strips, std::span<Strip<D> const> all)
{
    std::size_t cells = strip_lanes;
    for (std::uint32_t const k : strips) cells += static_cast<std::size_t>(all[k].whole_lanes());
    if (row.covers.size() < cells) row.covers.resize(cells);
    Stored* to = row.covers.data();
    for (std::uint32_t const k : strips) {
        all[k].write(to);
        to += all[k].whole_lanes();
    }
}

//! Calls visit(k, strip, fractions of its cells) for the strips of write_covers().
template <int D, class Stored, class Visit>
void each_cover(RowBuffer<Stored> const& row, std::span<std::uint32_t const> strips, std::span<Strip<D> const> all,
                Visit&& visit)
{
    Stored const* cover = row.covers.data();
    for (std::uint32_t const k : strips) {
        visit(k, all[k], cover);
        cover += all[k].whole_lanes();
    }
}

template <int D, class Stored>
void find_weights(typename RowBuffer<Stored>::Run const& run, double tau, RowBuffer<Stored>& row)
{
    Stored const *const fraction = row.fraction.data(), *const drag = row.drag.data(), *const lag = row.lag.data();
    Stored *const weight = row.weight.data(), *const open = row.open.data(), *const ease = row.ease.data();
#pragma omp simd
    for (std::ptrdiff_t x = run.begin; x < run.end; ++x) {
        weight[x] = weight_per_fraction(fraction[x], drag[x], tau);
        open[x] = open_share(fraction[x], lag[x] / std::max(fraction[x], tiny<Stored>));
        if constexpr (eased_by_inertia<D>) ease[x] = ease_per_fraction(fraction[x], drag[x], tau);
    }
}

template <int D, class Stored>
void add_strip(Strip<D> const& strip, Stored const* cover, StripVelocity<D> const& v, double held, double lag,
               RowBuffer<Stored>& row)
{
    int const count = strip.whole_lanes();
    Stored *const fraction = row.fraction.data() + strip.begin, *const drag = row.drag.data() + strip.begin,
                  *const lags = row.lag.data() + strip.begin;
    Stored *const x = row.momentum[0].data() + strip.begin, *const y = row.momentum[1].data() + strip.begin,
                  *const z = row.momentum[2].data() + strip.begin;
    auto const drag_each = static_cast<Stored>(held), lag_each = static_cast<Stored>(lag);
#pragma omp simd
    for (int k = 0; k < count; ++k) {  // int: the machine turns several of them into numbers at once
        Stored const f = cover[k];
        fraction[k] += f;
        drag[k] += f * drag_each;
        lags[k] += f * lag_each;
        x[k] += f * v.template at<Stored>(0, k);
        y[k] += f * v.template at<Stored>(1, k);
        if constexpr (D == 3) z[k] += f * v.template at<Stored>(2, k);
    }
}

//! What a strip's solid gets: force and torque [lattice units], with the fractions and velocities that its cells had.
template <bool moves, int D, class Stored, class Number>
void find_load(Strip<D> const& s, Number const* cover, StripVelocity<D> const& v, SolidRow<Stored> const& solid,
               std::array<double, D + spins<D>>& load)
{
    constexpr std::size_t lanes = Lanes<double>::count;
    static_assert(strip_lanes % lanes == 0);
    using Part = typename Lanes<Stored>::template Part<lanes>;
    std::array<Part, D> force{}, moment{};  // moment: with the arm along x
    Part cell = __builtin_convertvector(counted_from<Lanes<double>>(0).all, Part);
    Part arm = static_cast<Stored>(s.arm[0]) + cell;
    for (std::ptrdiff_t k = 0, count = s.whole_lanes(); k < count; k += lanes) {
        Part const fraction = load_part<Stored, lanes>(cover + k);
        for (std::size_t axis = 0; axis < D; ++axis) {
            Part f = load_part<Stored, lanes>(solid.force[axis] + s.begin + k);
            if constexpr (moves) {
                Part const velocity = static_cast<Stored>(v.first[axis]) + cell * static_cast<Stored>(v.slope[axis]);
                f -= load_part<Stored, lanes>(solid.force_rate + s.begin + k) * velocity;
            }
            f *= fraction;
            force[axis] += f;
            moment[axis] += arm * f;
        }
        arm += static_cast<Stored>(lanes);
        cell += static_cast<Stored>(lanes);
    }
    auto const sum = [](Part const& part) {
        return sum_of(Lanes<double>(__builtin_convertvector(part, Lanes<double>::Register)));
    };
    std::array<double, D> total;
    for (std::size_t axis = 0; axis < D; ++axis) load[axis] = total[axis] = sum(force[axis]);
    load[D + spins<D> - 1] = sum(moment[1]) - s.arm[1] * total[0];
    if constexpr (D == 3) {
        load[3] = s.arm[1] * total[2] - s.arm[2] * total[1];
        load[4] = s.arm[2] * total[0] - sum(moment[2]);
    }
}

}  // namespace lbm
