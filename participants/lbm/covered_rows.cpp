// Solver: the collision of rows with solids.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"
#include "participants/lbm/still_numbers.hpp"

namespace lbm {
namespace {

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

//! The same where bodies that move are forced: what rests keeps its weight.
template <int D, class Stored>
void find_forced_weights(typename RowBuffer<Stored>::Run const& run, double tau, RowBuffer<Stored>& row)
{
    Stored const *const fraction = row.fraction.data(), *const drag = row.drag.data(), *const forced = row.lag.data();
    Stored *const weight = row.weight.data(), *const open = row.open.data(), *const ease = row.ease.data();
#pragma omp simd
    for (std::ptrdiff_t x = run.begin; x < run.end; ++x) {
        Stored const rest = std::max(fraction[x] - forced[x], Stored{});
        weight[x] = weight_beside_forced(forced[x], rest, drag[x], tau);
        open[x] = open_share(rest, Stored{});
        if constexpr (eased_by_inertia<D>) ease[x] = forced[x] > 0 ? Stored{} : ease_per_fraction(rest, drag[x], tau);
    }
}

//! Deep inside a body, where all neighbours are covered as well, the fluid takes the body's velocity in one step.
template <int D, class Stored>
void set_core_weight(Strip<D> const& strip, std::span<Body<D> const> bodies, RowBuffer<Stored>& row)
{
    if (strip.body >= static_cast<std::ptrdiff_t>(bodies.size())) return;
    double const core = bodies[static_cast<std::size_t>(strip.body)].radius - skin<D>;
    double square = core * core;
    for (std::size_t k = 1; k < D; ++k) square -= strip.arm[k] * strip.arm[k];
    if (core <= 0 || square <= 0) return;
    double const half = std::sqrt(square);
    auto const first = static_cast<std::ptrdiff_t>(std::ceil(-half - strip.arm[0]));
    auto const last = static_cast<std::ptrdiff_t>(std::floor(half - strip.arm[0]));
    Stored *const weight = row.weight.data() + strip.begin, *const open = row.open.data() + strip.begin,
                  *const ease = row.ease.data() + strip.begin;
    Stored const* const fraction = row.fraction.data() + strip.begin;
    std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(first, 0),
                         end = std::min<std::ptrdiff_t>(last + 1, strip.count);
#pragma omp simd
    for (std::ptrdiff_t k = begin; k < end; ++k) {
        weight[k] = Stored(core_weight) / fraction[k];
        open[k] = 1;
        ease[k] = 0;
    }
}

//! Strips of a row belong to different discs, each with a place of its own in memory.
template <class T>
void prefetch(T const* first, std::ptrdiff_t count)
{
    constexpr std::size_t line = 64;  // bytes
    auto const* const begin = reinterpret_cast<char const*>(first);
    for (std::size_t at = 0; at < static_cast<std::size_t>(count) * sizeof(T); at += line)
        __builtin_prefetch(begin + at);
    __builtin_prefetch(begin + static_cast<std::size_t>(count) * sizeof(T) - 1);
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

//! Of a run with solids at rest, those of a SolidRow.
template <class Stored>
std::vector<Stored> solid_numbers(StillRun const& run, RowBuffer<Stored> const& row)
{
    std::vector<Stored> numbers;
    for (auto const* of : {&row.fraction, &row.weight, &row.open, &row.ease})
        numbers.insert(numbers.end(), of->begin() + run.begin, of->begin() + run.end);
    return numbers;
}

//! Of each slot up to the next row's cell x = 0, whether it is a cell with solid.
template <class Stored>
std::vector<char> cells_with_solid(RowBuffer<Stored> const& row, std::ptrdiff_t nx, std::ptrdiff_t stride)
{
    std::vector<char> has_solid(static_cast<std::size_t>(stride));
    for (auto const& run : row.runs)
        for (std::ptrdiff_t x = run.begin; run.touched && x < std::min(run.end, nx); ++x)
            has_solid[static_cast<std::size_t>(x)] = row.fraction[static_cast<std::size_t>(x)] > 0;
    return has_solid;
}

//! Whether the fluid's velocity changes how solids push it: then numbers do not tell all.
template <int D, class Stored>
bool is_eased(RowBuffer<Stored> const& row)
{
    return eased_by_inertia<D> && std::ranges::any_of(row.runs, [&](auto const& run) {
               return run.touched && std::any_of(row.ease.begin() + run.begin, row.ease.begin() + run.end,
                                                 [](Stored ease) { return ease != 0; });
           });
}

}  // namespace

//! Cuts the row into runs of blocks with and without solids.
template <int D>
template <class Stored>
void Solver<D>::collide_covered_row(std::ptrdiff_t r, AnySlots<D> const& slots, std::span<std::uint32_t const> strips)
{
    auto& buffer = row_buffer<Stored>();
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    prefetch_next<Stored>(r);
    begin_row(buffer, nx, strips, coverage_.strips(), [&](auto& touched) {
        if (phase_) phase_->mark(r, touched);
    });
    bool const forced = config_.surface == Surface::forced;
    write_covers(buffer, strips, coverage_.strips());
    Stored const* cover = buffer.covers.data();
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        StripVelocity<D> const v(s, covering());
        bool const moves = s.body < static_cast<std::ptrdiff_t>(covering().size());
        if (forced)
            add_strip(s, cover, v, moves ? 0.0 : s.drag, moves ? 1.0 : 0.0, buffer);
        else
            add_strip(s, cover, v, s.drag, lag_of<D>(s, covering(), relaxation_.tau), buffer);
        cover += s.whole_lanes();
    }
    Relaxation const relaxation = of_row(r);
    for (auto const& run : buffer.runs) {
        if (!run.touched) continue;
        covered_cells_[static_cast<std::size_t>(r)] += run.end - run.begin;
        (forced ? find_forced_weights<D, Stored> : find_weights<D, Stored>)(run, relaxation_.tau, buffer);
    }
    for (std::uint32_t const k : strips) set_core_weight(coverage_.strips()[k], covering(), buffer);
    SolidRow<Stored> const solid = buffer.view();
    for (auto const& [begin, end, touched] : buffer.runs) {
        if (!touched) {
            kernels_.fluid(slots, {begin, end}, relaxation, {});
            continue;
        }
        if (phase_) phase_->add_to_row(r, begin, end, typed<D, Stored>(slots), relaxation, buffer.input());
        kernels_.covered(slots, {begin, end}, relaxation, solid);
        if (phase_) phase_->take_from_row(r, begin, end, solid);
    }
    cover = buffer.covers.data();
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        find_load<true>(s, cover, StripVelocity<D>(s, covering()), solid, strip_load_[k]);
        cover += s.whole_lanes();
    }
}

//! The solids of a row that all rest.
template <int D>
bool Solver<D>::all_rest(std::span<std::uint32_t const> strips) const
{
    return covering().empty() ||
           coverage_.strips()[strips.front()].body >= static_cast<std::ptrdiff_t>(covering().size());  // they come last
}

//! What the collision needs of rows in which all solids rest.
template <int D>
template <class Stored>
void Solver<D>::list_still_rows()
{
    if (coverage_.patches().empty()) return;
    auto& buffer = row_buffer<Stored>();
    still_.typed<Stored>().rest.assign(static_cast<std::size_t>(layout_.most_in_row()), Stored{});
    auto& numbers = still_.typed<Stored>().of_runs;
    std::vector<StillRun> runs;
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        auto const strips = coverage_.row(r);
        std::ptrdiff_t const nx = layout_.row(r).cells;
        if (strips.empty()) {
            still_.add_row({}, false);
            continue;
        }
        buffer.resize(layout_.most_in_row(), nx);
        begin_row(buffer, nx, strips, coverage_.strips(), [](auto&) {});
        write_covers(buffer, strips, coverage_.strips());
        Stored const* cover = buffer.covers.data();
        for (std::uint32_t const k : strips) {
            Strip<D> const& s = coverage_.strips()[k];
            add_strip(s, cover, {}, s.drag, 0.0, buffer);
            cover += s.whole_lanes();
        }
        for (auto const& run : buffer.runs)
            if (run.touched) find_weights<D>(run, relaxation_.tau, buffer);
        bool const in_block = kernels_.still != nullptr && !is_eased<D>(buffer);
        runs.clear();
        if (in_block) {
            StillRowNumbers const of_row(buffer.view(), cells_with_solid(buffer, nx, populations_.stride(r)),
                                         relaxation_, config_.smagorinsky > 0);
            runs = of_row.runs();
            for (StillRun& run : runs) run.at = numbers.add(of_row.numbers(run));
        } else {
            for (auto const& [begin, end, touched] : buffer.runs) {
                runs.push_back({begin, end, touched, 0});
                if (touched) runs.back().at = numbers.add(solid_numbers(runs.back(), buffer));
            }
        }
        still_.add_row(runs, in_block);
    }
}

//! What is known of the solids of the rows after the next: short rows are too quick to be followed by the machine.
template <int D>
template <class Stored>
void Solver<D>::prefetch_next(std::ptrdiff_t r) const
{
    std::ptrdiff_t const next = std::min(r + 2, layout_.rows() - 1);
    for (std::uint32_t const k : coverage_.row(next)) prefetch(&coverage_.strips()[k], 1);
    for (std::uint32_t const k : coverage_.row(std::min(r + 1, next))) {
        Strip<D> const& s = coverage_.strips()[k];
        prefetch(s.listed, s.left + s.right);
        prefetch(&strip_load_[k], 1);
    }
    for (StillRun const& run : still_.runs_of(still_.row(std::min(r + 1, next))))
        if (run.touched) prefetch(still_.typed<Stored>().of_runs.data(run.at), 4 * (run.end - run.begin));
    auto const runs = still_.runs_of(still_.row(next));
    if (!runs.empty()) prefetch(runs.data(), static_cast<std::ptrdiff_t>(runs.size()));
}

template <int D>
template <class Stored>
void Solver<D>::collide_still_row(std::ptrdiff_t r, AnySlots<D> const& slots, std::span<std::uint32_t const> strips)
{
    auto& buffer = row_buffer<Stored>();
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    Relaxation const relaxation = of_row(r);
    prefetch_next<Stored>(r);
    SolidRow<Stored> solid = buffer.view();
    solid.momentum.fill(still_.typed<Stored>().rest.data());
    StillRows::Row const row = still_.row(r);
    covered_cells_[static_cast<std::size_t>(r)] = row.touched;
    for (StillRun const& run : still_.runs_of(row)) {
        if (!run.touched) {
            kernels_.fluid(slots, {run.begin, run.end}, relaxation, {});
            continue;
        }
        still_.point(run, solid);
        kernels_.covered(slots, {run.begin, run.end}, relaxation, solid);
    }
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        find_load<false>(s, s.listed, {}, solid, strip_load_[k]);  // patches list all their cells
    }
}

//! `count` rows that are alike, from r on.
template <int D>
template <class Stored>
void Solver<D>::collide_still_block(std::ptrdiff_t r, std::ptrdiff_t count, AnySlots<D> const& slots)
{
    constexpr auto lanes = StillNumbers<Stored>::lanes;
    auto& buffer = row_buffer<Stored>();
    std::ptrdiff_t const nx = layout_.row(r).cells, stride = populations_.stride(r), room = count * stride + lanes;
    SolidRow<Stored> solid;
    for (std::size_t k = 0; k < 3; ++k) {
        auto& force = buffer.block_force[k];
        if (force.size() < static_cast<std::size_t>(room)) force.assign(static_cast<std::size_t>(room), Stored{});
        solid.force[k] = force.data();
    }
    StillRows::Row const row = still_.row(r);
    kernels_.still(
        slots,
        StillBlock<Stored>{nx, count, stride, still_.runs_of(row), still_.typed<Stored>().of_runs.data(0), solid.force},
        of_row(r));
    for (std::ptrdiff_t const last = r + count; r < last; ++r) {
        covered_cells_[static_cast<std::size_t>(r)] = row.touched;
        for (Stored* const force : solid.force) std::fill_n(force + nx, stride - nx, Stored{});  // of no cell
        for (std::uint32_t const k : coverage_.row(r)) {
            Strip<D> const& s = coverage_.strips()[k];
            find_load<false>(s, s.listed, {}, solid, strip_load_[k]);  // patches list all their cells
        }
        for (Stored*& force : solid.force) force += stride;
    }
}

template bool Solver<2>::all_rest(std::span<std::uint32_t const>) const;
template bool Solver<3>::all_rest(std::span<std::uint32_t const>) const;
#define LBM_COVERED_ROWS(D, Stored)                                                                           \
    template void Solver<D>::collide_covered_row<Stored>(std::ptrdiff_t, AnySlots<D> const&,                  \
                                                         std::span<std::uint32_t const>);                     \
    template void Solver<D>::collide_still_row<Stored>(std::ptrdiff_t, AnySlots<D> const&,                    \
                                                       std::span<std::uint32_t const>);                       \
    template void Solver<D>::collide_still_block<Stored>(std::ptrdiff_t, std::ptrdiff_t, AnySlots<D> const&); \
    template void Solver<D>::list_still_rows<Stored>();
LBM_COVERED_ROWS(2, double)
LBM_COVERED_ROWS(2, float)
LBM_COVERED_ROWS(3, double)
LBM_COVERED_ROWS(3, float)
#undef LBM_COVERED_ROWS

}  // namespace lbm
