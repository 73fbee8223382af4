// Solver: the collision of rows with solids.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

//! One row's solids; each thread keeps its own. Strips are worked on in whole lanes: beyond the row's end lie cells
//! that take what a strip cut off there has left, and exchange nothing.
struct RowBuffer
{
    std::vector<double> fraction, drag;
    std::vector<double> lag;  //!< sum of eps R, or with forced bodies of their eps
    std::vector<double> weight, open, ease, force_rate;
    std::array<std::vector<double>, 3> momentum, force;
    std::vector<char> touched;  //!< for each block

    //! Room for the longest row, and for one of nx cells.
    void resize(std::ptrdiff_t longest, std::ptrdiff_t nx)
    {
        auto const n = static_cast<std::size_t>(longest + strip_lanes);
        if (fraction.size() < n) {
            for (auto* v : {&fraction, &drag, &lag, &weight, &open, &ease, &force_rate}) v->assign(n, 0.0);
            for (auto* vectors : {&momentum, &force})
                for (auto& v : *vectors) v.assign(n, 0.0);
            touched.resize(n / block + 1);
        }
        for (auto* v : {&fraction, &force_rate, &force[0], &force[1], &force[2]})
            std::fill_n(v->begin() + nx, strip_lanes, 0.0);
    }
    SolidRow view()
    {
        return {fraction.data(),
                weight.data(),
                open.data(),
                ease.data(),
                {momentum[0].data(), momentum[1].data(), momentum[2].data()},
                force_rate.data(),
                {force[0].data(), force[1].data(), force[2].data()}};
    }
    SolidRowInput input()
    {
        return {fraction.data(),
                weight.data(),
                open.data(),
                ease.data(),
                {momentum[0].data(), momentum[1].data(), momentum[2].data()}};
    }
};

thread_local RowBuffer buffer;

//! A strip's cells, rounded up: the fractions beyond its end are 0 or lie beyond the row's end.
template <int D>
int whole_lanes(Strip<D> const& strip)
{
    auto const count = static_cast<int>((strip.count + strip_lanes - 1) / strip_lanes * strip_lanes);
    if (count % strip_lanes != 0 || count <= 0) __builtin_unreachable();  // spares the loops a remainder
    return count;
}

//! Marks the blocks of a strip.
template <int D>
void touch(Strip<D> const& s, RowBuffer& row)
{
    std::fill(row.touched.begin() + s.begin / block, row.touched.begin() + (s.begin + whole_lanes(s) - 1) / block + 1,
              1);
}

//! run(begin, end, touched) for the blocks of a row of nx cells that are alike.
template <class Run>
void each_run_of_blocks(RowBuffer const& row, std::ptrdiff_t nx, Run&& run)
{
    std::ptrdiff_t const blocks = (nx + block - 1) / block;
    for (std::ptrdiff_t first = 0, last = 0; first < blocks; first = last) {
        char const touched = row.touched[static_cast<std::size_t>(first)];
        while (last < blocks && row.touched[static_cast<std::size_t>(last)] == touched) ++last;
        run(first * block, std::min(last * block, nx), touched != 0);
    }
}

template <int D>
void clear(std::ptrdiff_t begin, std::ptrdiff_t end, RowBuffer& row)
{
    for (auto* v : {&row.fraction, &row.drag, &row.lag}) std::fill(v->begin() + begin, v->begin() + end, 0.0);
    for (std::size_t k = 0; k < D; ++k) std::fill(row.momentum[k].begin() + begin, row.momentum[k].begin() + end, 0.0);
}

template <int D>
void find_weights(std::ptrdiff_t begin, std::ptrdiff_t end, double tau, RowBuffer& row)
{
    double const *const fraction = row.fraction.data(), *const drag = row.drag.data(), *const lag = row.lag.data();
    double *const weight = row.weight.data(), *const open = row.open.data(), *const ease = row.ease.data();
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        weight[x] = weight_per_fraction(fraction[x], drag[x], tau);
        open[x] = open_share(fraction[x], lag[x] / std::max(fraction[x], 1e-300));
        if constexpr (eased_by_inertia<D>) ease[x] = ease_per_fraction(fraction[x], drag[x], tau);
    }
}

//! The same where bodies that move are forced: what rests keeps its weight.
template <int D>
void find_forced_weights(std::ptrdiff_t begin, std::ptrdiff_t end, double tau, RowBuffer& row)
{
    double const *const fraction = row.fraction.data(), *const drag = row.drag.data(), *const forced = row.lag.data();
    double *const weight = row.weight.data(), *const open = row.open.data(), *const ease = row.ease.data();
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        double const rest = std::max(fraction[x] - forced[x], 0.0);
        weight[x] = weight_beside_forced(forced[x], rest, drag[x], tau);
        open[x] = open_share(rest, 0.0);
        if constexpr (eased_by_inertia<D>) ease[x] = forced[x] > 0 ? 0.0 : ease_per_fraction(rest, drag[x], tau);
    }
}

//! Deep inside a body, where all neighbours are covered as well, the fluid takes the body's velocity in one step.
template <int D>
void set_core_weight(Strip<D> const& strip, std::span<Body<D> const> bodies, RowBuffer& row)
{
    if (strip.body >= static_cast<std::ptrdiff_t>(bodies.size())) return;
    double const core = bodies[static_cast<std::size_t>(strip.body)].radius - skin<D>;
    double square = core * core;
    for (std::size_t k = 1; k < D; ++k) square -= strip.arm[k] * strip.arm[k];
    if (core <= 0 || square <= 0) return;
    double const half = std::sqrt(square);
    auto const first = static_cast<std::ptrdiff_t>(std::ceil(-half - strip.arm[0]));
    auto const last = static_cast<std::ptrdiff_t>(std::floor(half - strip.arm[0]));
    double *const weight = row.weight.data() + strip.begin, *const open = row.open.data() + strip.begin,
                  *const ease = row.ease.data() + strip.begin;
    double const* const fraction = row.fraction.data() + strip.begin;
    std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(first, 0), end = std::min(last + 1, strip.count);
#pragma omp simd
    for (std::ptrdiff_t k = begin; k < end; ++k) {
        weight[k] = core_weight / fraction[k];
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

template <int D>
void add_strip(Strip<D> const& strip, StripVelocity<D> const& v, double held, double lag, RowBuffer& row)
{
    int const count = whole_lanes(strip);
    double *const fraction = row.fraction.data() + strip.begin, *const drag = row.drag.data() + strip.begin,
                  *const lags = row.lag.data() + strip.begin;
    double *const x = row.momentum[0].data() + strip.begin, *const y = row.momentum[1].data() + strip.begin,
                  *const z = row.momentum[2].data() + strip.begin;
#pragma omp simd
    for (int k = 0; k < count; ++k) {  // int: the machine turns four of them into doubles at once
        double const f = strip.fraction[k];
        fraction[k] += f;
        drag[k] += f * held;
        lags[k] += f * lag;
        x[k] += f * v.first[0];
        y[k] += f * v.at(1, k);
        if constexpr (D == 3) z[k] += f * v.at(2, k);
    }
}

//! What a strip of a solid at rest gets: force and torque [lattice units].
template <int D>
std::array<double, D + spins<D>> load_at_rest(Strip<D> const& s, SolidRow const& solid)
{
    typedef double Lanes4 __attribute__((vector_size(strip_lanes * sizeof(double))));
    auto const sum_of = [](Lanes4 const& v) { return (v[0] + v[1]) + (v[2] + v[3]); };
    std::array<Lanes4, D> force{}, moment{};  // moment: with the arm along x
    Lanes4 arm = s.arm[0] + Lanes4{0, 1, 2, 3};
    for (int k = 0, count = whole_lanes(s); k < count; k += strip_lanes) {
        Lanes4 fraction, per_fraction;
        std::memcpy(&fraction, s.fraction + k, sizeof fraction);
        for (std::size_t axis = 0; axis < D; ++axis) {
            std::memcpy(&per_fraction, solid.force[axis] + s.begin + k, sizeof per_fraction);
            Lanes4 const f = fraction * per_fraction;
            force[axis] += f;
            moment[axis] += arm * f;
        }
        arm += static_cast<double>(strip_lanes);
    }
    std::array<double, D + spins<D>> load;
    for (std::size_t axis = 0; axis < D; ++axis) load[axis] = sum_of(force[axis]);
    if constexpr (D == 2) {
        load[2] = sum_of(moment[1]) - s.arm[1] * load[0];
    } else {
        load[3] = s.arm[1] * load[2] - s.arm[2] * load[1];
        load[4] = s.arm[2] * load[0] - sum_of(moment[2]);
        load[5] = sum_of(moment[1]) - s.arm[1] * load[0];
    }
    return load;
}

}  // namespace

//! Cuts the row into runs of blocks with and without solids.
template <int D>
void Solver<D>::collide_covered_row(std::ptrdiff_t r, AnySlots<D> const& slots, std::span<std::uint32_t const> strips)
{
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    std::fill_n(buffer.touched.begin(), (nx + block - 1) / block, 0);
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        prefetch(s.fraction, s.count);
        touch(s, buffer);
    }
    if (phase_) phase_->mark(r, buffer.touched);
    if (r + 1 < layout_.rows())
        for (std::uint32_t const k : coverage_.row(r + 1)) prefetch(&coverage_.strips()[k], 1);
    auto const each_run = [&](auto&& run) { each_run_of_blocks(buffer, nx, run); };
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (touched) clear<D>(begin, end, buffer);
    });
    bool const forced = config_.surface == Surface::forced;
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        StripVelocity<D> const v(s, covering());
        bool const moves = s.body < static_cast<std::ptrdiff_t>(covering().size());
        if (forced)
            add_strip(s, v, moves ? 0.0 : s.drag, moves ? 1.0 : 0.0, buffer);
        else
            add_strip(s, v, s.drag, lag_of<D>(s, covering(), relaxation_.tau), buffer);
    }
    Relaxation const relaxation = of_row(r);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return kernels_.fluid(slots, {begin, end}, relaxation, {});
        covered_cells_[static_cast<std::size_t>(r)] += end - begin;
        (forced ? find_forced_weights<D> : find_weights<D>)(begin, end, relaxation_.tau, buffer);
    });
    for (std::uint32_t const k : strips) set_core_weight<D>(coverage_.strips()[k], covering(), buffer);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return;
        if (phase_)
            populations_.visit([&]<class Stored>(Rows<D, Stored> const&) {
                phase_->add_to_row(r, begin, end, typed<D, Stored>(slots), relaxation, buffer.input());
            });
        kernels_.covered(slots, {begin, end}, relaxation, buffer.view());
        if (phase_) phase_->take_from_row(r, begin, end, buffer.view());
    });
    add_strip_forces(strips, buffer.view());
}

template <int D>
void Solver<D>::add_strip_forces(std::span<std::uint32_t const> strips, SolidRow const& solid)
{
    for (std::uint32_t const index : strips) {
        Strip<D> const& s = coverage_.strips()[index];
        StripVelocity<D> const v(s, covering());
        double const *const rate = solid.force_rate + s.begin, *const fraction = s.fraction,
                            *const x = solid.force[0] + s.begin, *const y = solid.force[1] + s.begin,
                            *const z = solid.force[2] + s.begin;
        int const count = whole_lanes(s);
        double force_x = 0, force_y = 0, force_z = 0, moment_y = 0, moment_z = 0;  // moments: with the arm along x
#pragma omp simd reduction(+ : force_x, force_y, force_z, moment_y, moment_z)
        for (int k = 0; k < count; ++k) {
            double const arm = s.arm[0] + static_cast<double>(k);
            double const fx = fraction[k] * (x[k] - rate[k] * v.first[0]);
            double const fy = fraction[k] * (y[k] - rate[k] * v.at(1, k));
            force_x += fx;
            force_y += fy;
            moment_y += arm * fy;
            if constexpr (D == 3) {
                double const fz = fraction[k] * (z[k] - rate[k] * v.at(2, k));
                force_z += fz;
                moment_z += arm * fz;
            }
        }
        if constexpr (D == 2)
            strip_load_[index] = {force_x, force_y, moment_y - s.arm[1] * force_x};
        else
            strip_load_[index] = {force_x,
                                  force_y,
                                  force_z,
                                  s.arm[1] * force_z - s.arm[2] * force_y,
                                  s.arm[2] * force_x - moment_z,
                                  moment_y - s.arm[1] * force_x};
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
void Solver<D>::list_still_rows()
{
    still_.rest.assign(static_cast<std::size_t>(layout_.most_in_row()), 0.0);
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        still_.start.push_back(static_cast<std::uint32_t>(still_.runs.size()));
        auto const strips = coverage_.row(r);
        std::ptrdiff_t const nx = layout_.row(r).cells;
        if (strips.empty()) continue;
        buffer.resize(layout_.most_in_row(), nx);
        std::fill_n(buffer.touched.begin(), (nx + block - 1) / block, 0);
        for (std::uint32_t const k : strips) touch(coverage_.strips()[k], buffer);
        each_run_of_blocks(buffer, nx, [&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
            if (touched) clear<D>(begin, end, buffer);
        });
        for (std::uint32_t const k : strips) {
            Strip<D> const& s = coverage_.strips()[k];
            add_strip(s, StripVelocity<D>(s, covering()), s.drag, 0.0, buffer);
        }
        each_run_of_blocks(buffer, nx, [&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
            if (touched) find_weights<D>(begin, end, relaxation_.tau, buffer);
            still_.add_run(begin, end, touched, buffer.view());
        });
    }
    still_.start.push_back(static_cast<std::uint32_t>(still_.runs.size()));
}

//! What is known of the solids of the rows after the next: short rows are too quick to be followed by the machine.
template <int D>
void Solver<D>::prefetch_next(std::ptrdiff_t r) const
{
    std::ptrdiff_t const next = std::min(r + 2, layout_.rows() - 1);
    for (std::uint32_t const k : coverage_.row(next)) prefetch(&coverage_.strips()[k], 1);
    for (std::uint32_t const k : coverage_.row(std::min(r + 1, next))) {
        Strip<D> const& s = coverage_.strips()[k];
        prefetch(s.fraction, s.count);
        prefetch(&strip_load_[k], 1);
    }
    for (StillRows::Run const& run : still_.of_row(std::min(r + 1, next)))
        if (run.touched) prefetch(still_.numbers.data(run.at), 4 * (run.end - run.begin));
    auto const runs = still_.of_row(next);
    if (!runs.empty()) prefetch(runs.data(), static_cast<std::ptrdiff_t>(runs.size()));
}

template <int D>
void Solver<D>::collide_still_row(std::ptrdiff_t r, AnySlots<D> const& slots, std::span<std::uint32_t const> strips)
{
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    Relaxation const relaxation = of_row(r);
    prefetch_next(r);
    SolidRow solid = buffer.view();
    solid.momentum.fill(still_.rest.data());
    for (StillRows::Run const& run : still_.of_row(r)) {
        if (!run.touched) {
            kernels_.fluid(slots, {run.begin, run.end}, relaxation, {});
            continue;
        }
        covered_cells_[static_cast<std::size_t>(r)] += run.end - run.begin;
        still_.point(run, solid);
        kernels_.covered(slots, {run.begin, run.end}, relaxation, solid);
    }
    for (std::uint32_t const k : strips) strip_load_[k] = load_at_rest(coverage_.strips()[k], solid);
}

template void Solver<2>::collide_covered_row(std::ptrdiff_t, AnySlots<2> const&, std::span<std::uint32_t const>);
template void Solver<2>::collide_still_row(std::ptrdiff_t, AnySlots<2> const&, std::span<std::uint32_t const>);
template void Solver<2>::list_still_rows();
template bool Solver<2>::all_rest(std::span<std::uint32_t const>) const;
template void Solver<3>::collide_covered_row(std::ptrdiff_t, AnySlots<3> const&, std::span<std::uint32_t const>);
template void Solver<3>::collide_still_row(std::ptrdiff_t, AnySlots<3> const&, std::span<std::uint32_t const>);
template void Solver<3>::list_still_rows();
template bool Solver<3>::all_rest(std::span<std::uint32_t const>) const;

}  // namespace lbm
