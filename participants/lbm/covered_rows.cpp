// Solver: the collision of rows with solids, some of which move.
#include <algorithm>
#include <cmath>

#include "participants/lbm/row_buffer.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

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
    each_cover(buffer, strips, coverage_.strips(), [&](std::uint32_t, Strip<D> const& s, Stored const* cover) {
        StripVelocity<D> const v(s, covering());
        if (forced)
            add_strip(s, cover, v, is_forced(s) ? 0.0 : s.drag, is_forced(s) ? 1.0 : 0.0, buffer);
        else
            add_strip(s, cover, v, s.drag, lag_of<D>(s, covering(), relaxation_.tau), buffer);
    });
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
    each_cover(buffer, strips, coverage_.strips(), [&](std::uint32_t k, Strip<D> const& s, Stored const* cover) {
        find_load<true>(s, cover, StripVelocity<D>(s, covering()), solid, strip_load_[k]);
    });
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

#define LBM_COVERED_ROWS(D, Stored)                                                          \
    template void Solver<D>::collide_covered_row<Stored>(std::ptrdiff_t, AnySlots<D> const&, \
                                                         std::span<std::uint32_t const>);    \
    template void Solver<D>::prefetch_next<Stored>(std::ptrdiff_t) const;
LBM_COVERED_ROWS(2, double)
LBM_COVERED_ROWS(2, float)
LBM_COVERED_ROWS(3, double)
LBM_COVERED_ROWS(3, float)
#undef LBM_COVERED_ROWS

}  // namespace lbm
