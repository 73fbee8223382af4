#include "participants/lbm/solver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "coupler/base/error.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solids.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::require;

constexpr std::ptrdiff_t rows_a_chunk = 4;  //!< handed to a thread at a time
constexpr std::int64_t watch_every = 64;    //!< steps

Config checked(Config const& config)
{
    std::string text;
    for (Issue const& issue : find_issues(config))
        if (issue.refused)
            text.append(text.empty() ? "fluid: " : "\nfluid: ").append(issue.key).append(" = ").append(issue.text);
    require(text.empty(), [&] { return Error(text); });
    return config;
}

//! 4 s (1 - s) at every half cell, 0 at both edges of the domain.
std::vector<double> parabola(std::ptrdiff_t cells)
{
    std::vector<double> values;
    for (std::ptrdiff_t half = 0; half <= 2 * cells; ++half) {
        double const s = static_cast<double>(half) / static_cast<double>(2 * cells);
        values.push_back(4 * s * (1 - s));
    }
    return values;
}

template <int D>
Boundary boundary_lu(Config const& c, std::size_t s)
{
    Wall const& wall = c.walls[s];
    auto const cells = c.cells();
    Boundary side{.kind = wall.kind, .ramp = wall.ramp / c.step};
    for (std::size_t k = 0; k < 3; ++k) side.velocity[k] = wall.velocity[k] / c.units().velocity_unit();
    for (std::size_t k = 0; k < c.axes(); ++k)
        if (wall.parabola && k != s / 2 && !c.periodic(k)) side.profile[k] = parabola(cells[k]);
    if (wall.kind == Border::pressure) {
        side.density_excess = c.units().density_excess_lu(wall.pressure);
        side.turned.resize(Lattice<D>::directions *
                           static_cast<std::size_t>(cells[0] * cells[1] * cells[2] / cells[s / 2]));
    }
    return side;
}

template <int D>
Walls walls_lu(Config const& c, Relaxation const& relaxation)
{
    Walls walls{};
    for (std::size_t s = 0; s < 2 * c.axes(); ++s) walls.side[s / 2][s % 2] = boundary_lu<D>(c, s);
    walls.even_rate = relaxation.shear;
    walls.row_ends = row_ends<D>(walls, c.cells());
    return walls;
}

//! One row's solids; each thread keeps its own. Strips are worked on in whole lanes: beyond the row's end lie cells
//! that take what a strip cut off there has left, and exchange nothing.
struct RowBuffer
{
    std::vector<double> fraction, drag, lag, weight, open, ease, force_rate;
    std::array<std::vector<double>, 3> momentum, force;
    std::vector<char> touched;  //!< for each block

    void resize(std::ptrdiff_t nx)
    {
        auto const n = static_cast<std::size_t>(nx + strip_lanes);
        if (fraction.size() == n) return;
        for (auto* v : {&fraction, &drag, &lag, &weight, &open, &ease, &force_rate}) v->assign(n, 0.0);
        for (auto* vectors : {&momentum, &force})
            for (auto& v : *vectors) v.assign(n, 0.0);
        touched.resize(n / block + 1);
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
        return {
            fraction.data(), weight.data(), open.data(), {momentum[0].data(), momentum[1].data(), momentum[2].data()}};
    }
};

thread_local RowBuffer buffer;

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

//! A strip's cells, rounded up: the fractions beyond its end are 0 or lie beyond the row's end.
template <int D>
int whole_lanes(Strip<D> const& strip)
{
    auto const count = static_cast<int>((strip.count + strip_lanes - 1) / strip_lanes * strip_lanes);
    if (count % strip_lanes != 0 || count <= 0) __builtin_unreachable();  // spares the loops a remainder
    return count;
}

template <int D>
void add_strip(Strip<D> const& strip, StripVelocity<D> const& v, double lag, RowBuffer& row)
{
    int const count = whole_lanes(strip);
    double *const fraction = row.fraction.data() + strip.begin, *const drag = row.drag.data() + strip.begin,
                  *const lags = row.lag.data() + strip.begin;
    double *const x = row.momentum[0].data() + strip.begin, *const y = row.momentum[1].data() + strip.begin,
                  *const z = row.momentum[2].data() + strip.begin;
    double const held = strip.drag;
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

//! Share of an inflow that is there at a time, smooth at both ends.
double grown(double time, double ramp)
{
    return time < ramp ? 0.5 * (1 - std::cos(std::numbers::pi * time / ramp)) : 1.0;
}

}  // namespace

template <int D>
Solver<D>::Solver(Config const& config)
    : config_(checked(config)),
      relaxation_(relaxation(config_)),
      walls_(walls_lu<D>(config_, relaxation_)),
      kernels_(kernels_of<D>(config_)),
      team_(config_.threads),
      populations_(config_.cells(), config_.precision, team_),
      coverage_(config_.cells(), walls_.periodic()),
      covered_cells_(static_cast<std::size_t>(populations_.rows()))
{
    set_patches(patches_of<D>(config_));
    if (config_.rotation) turning_ = Turning{frame::RotatingFrame<D>(*config_.rotation)};
    if (config_.phase) phase_.emplace(config_);
    if (config_.surface == Surface::interpolated) links_.emplace(config_.cells(), walls_.periodic());
    find_field();
}

//! For the step that comes: what acts everywhere alike, and the frame.
template <int D>
void Solver<D>::find_field()
{
    acceleration_ = config_.acceleration;
    if (auto const& o = config_.oscillation)
        for (std::size_t k = 0; k < 3; ++k)
            acceleration_[k] += o->amplitude[k] * std::cos(2 * std::numbers::pi * o->frequency * time());
    for (std::size_t k = 0; k < 3; ++k) {
        relaxation_.force[k] = acceleration_[k] / config_.units().acceleration_unit();
        walls_.half_force[k] = 0.5 * relaxation_.force[k];
    }
    if (!turning_) return;
    double const from = time(), to = from + config_.step;
    turning_->field = turning_->frame.euler(from, to);
    auto const centrifugal = turning_->frame.centrifugal(0.5 * (from + to));
    if (config_.hydrostatic)
        for (std::size_t k = 0; k < centrifugal.size(); ++k) turning_->field[k] += centrifugal[k];
    // Guo's half force turns a velocity by 2 atan(w dt): with the tangent by twice the frame's angle, exactly
    double const turn = config_.rotation->coriolis ? std::tan(turning_->frame.angle(from, to)) : 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        relaxation_.turn[k] = turn * turning_->frame.direction()[k];
        turning_->rate[k] = relaxation_.turn[k] / config_.step;
    }
    for (std::size_t k = 0; k < D; ++k)
        relaxation_.slope[k] = turning_->field[k * D] * config_.cell / config_.units().acceleration_unit();
}

//! With the force in the row's first cell.
template <int D>
Relaxation Solver<D>::of_row(std::ptrdiff_t r) const
{
    Relaxation row = relaxation_;
    if (!turning_) return row;
    constexpr std::array<double, D> rest{};
    auto const a = acceleration_at(centre_of(0, r), rest.data());
    for (std::size_t k = 0; k < D; ++k) row.force[k] = a[k] / config_.units().acceleration_unit();
    return row;
}

//! What the scene's field and its frame do to fluid that moves [m/s2].
template <int D>
std::array<double, D> Solver<D>::acceleration_at(std::array<double, D> const& place, double const* velocity) const
{
    std::array<double, D> a;
    std::copy_n(acceleration_.begin(), D, a.begin());
    if (!turning_) return a;
    std::array<double, 3> u{};
    std::copy_n(velocity, D, u.begin());
    auto const turned = cross(turning_->rate, u);
    for (std::size_t i = 0; i < D; ++i) {
        a[i] -= 2 * turned[i];
        for (std::size_t k = 0; k < D; ++k)
            a[i] += turning_->field[i * D + k] * (place[k] - turning_->frame.point(static_cast<int>(k)));
    }
    return a;
}

template <int D>
void Solver<D>::step()
{
    sluice::Team::Awake const awake(team_);
    std::ptrdiff_t const rebuilt = coverage_.update(covering(), team_);
    if (links_) {
        complete();
        links_->place(populations_, bodies_, id_, walls_.half_force);
    }
    share_.rebuilt_bodies = static_cast<double>(rebuilt) / std::max(1.0, static_cast<double>(bodies_.size()));
    strip_load_.resize(coverage_.strips().size());
    for (auto& pair : walls_.side)
        for (Boundary& side : pair) side.share = grown(static_cast<double>(steps_) + 0.5, side.ramp);
    if (phase_) phase_->spread();
    team_.share(populations_.rows(), rows_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t r = begin; r < end; ++r) collide_row(r);
    });
    if (phase_) phase_->gather(team_);
    populations_.stream(team_);
    complete_ = false;
    if (links_) {
        complete();
        links_->reflect(populations_, bodies_, team_);
    }
    bool const finite = sum_loads();
    ++steps_;
    find_field();
    if (!finite || steps_ % watch_every == 0) watch();
    require(finite, [&] {
        return Error("fluid: t = " + std::to_string(time()) + " s: the force on a body is not finite.",
                     sluice::Exit::numerical);
    });
}

template <int D>
void Solver<D>::collide_row(std::ptrdiff_t r)
{
    if (!complete_) enter_row(r);
    covered_cells_[static_cast<std::size_t>(r)] = 0;
    auto const strips = coverage_.row(r);
    if (!strips.empty() || (phase_ && phase_->reaches(r))) return collide_covered_row(r, strips);
    kernels_.fluid(populations_.row(r), 0, populations_.nx(), of_row(r), {});
}

template <int D>
void Solver<D>::enter_row(std::ptrdiff_t r)
{
    populations_.visit([&](auto const& rows) {
        enter_from_outside(rows, r, walls_);
        note_turned(rows, r, walls_);
    });
}

//! Cuts the row into runs of blocks with and without solids.
template <int D>
void Solver<D>::collide_covered_row(std::ptrdiff_t r, std::span<std::uint32_t const> strips)
{
    std::ptrdiff_t const nx = populations_.nx(), blocks = (nx + block - 1) / block;
    buffer.resize(nx);
    std::fill_n(buffer.touched.begin(), blocks, 0);
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        prefetch(s.fraction, s.count);
        std::fill(buffer.touched.begin() + s.begin / block,
                  buffer.touched.begin() + (s.begin + whole_lanes(s) - 1) / block + 1, 1);
    }
    if (phase_) phase_->mark(r, buffer.touched);
    if (r + 1 < populations_.rows())
        for (std::uint32_t const k : coverage_.row(r + 1)) prefetch(&coverage_.strips()[k], 1);
    auto const each_run = [&](auto&& run) {
        for (std::ptrdiff_t first = 0, last = 0; first < blocks; first = last) {
            char const touched = buffer.touched[static_cast<std::size_t>(first)];
            while (last < blocks && buffer.touched[static_cast<std::size_t>(last)] == touched) ++last;
            run(first * block, std::min(last * block, nx), touched != 0);
        }
    };
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return;
        for (auto* v : {&buffer.fraction, &buffer.drag, &buffer.lag})
            std::fill(v->begin() + begin, v->begin() + end, 0.0);
        for (std::size_t k = 0; k < D; ++k)
            std::fill(buffer.momentum[k].begin() + begin, buffer.momentum[k].begin() + end, 0.0);
    });
    for (std::uint32_t const k : strips) {
        Strip<D> const& s = coverage_.strips()[k];
        add_strip(s, StripVelocity<D>(s, covering()), lag_of<D>(s, covering(), relaxation_.tau), buffer);
    }
    AnySlots<D> const slots = populations_.row(r);
    Relaxation const relaxation = of_row(r);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return kernels_.fluid(slots, begin, end, relaxation, {});
        covered_cells_[static_cast<std::size_t>(r)] += end - begin;
        find_weights<D>(begin, end, relaxation_.tau, buffer);
    });
    for (std::uint32_t const k : strips) set_core_weight<D>(coverage_.strips()[k], covering(), buffer);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return;
        if (phase_)
            populations_.visit([&]<class Stored>(Rows<D, Stored> const&) {
                phase_->add_to_row(r, begin, end, typed<D, Stored>(slots), relaxation, buffer.input());
            });
        kernels_.covered(slots, begin, end, relaxation, buffer.view());
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

template <int D>
typename Solver<D>::Motion Solver<D>::sum_strips(std::size_t index) const
{
    Motion sum{};
    if (links_ && index < bodies_.size()) return links_->impulses()[index];
    auto const [begin, end] = coverage_.of_body(index - (links_ ? bodies_.size() : 0));
    for (std::size_t k = begin; k < end; ++k)
        for (std::size_t f = 0; f < freedoms; ++f) sum[f] += strip_load_[k][f];
    return sum;
}

//! Sums each body's strips in their order, whatever the number of threads. Returns whether all loads are finite.
template <int D>
bool Solver<D>::sum_loads()
{
    std::size_t const n = bodies_.size();
    double const force_unit = config_.units().force_unit(), torque_unit = config_.units().torque_unit();
    bool finite = true;
    for (std::size_t i = 0; i < n; ++i) {
        Motion const sum = sum_strips(i);
        for (std::size_t f = 0; f < D; ++f) exchange_[D * i + f] = sum[f] * force_unit;
        for (std::size_t f = 0; f < spins<D>; ++f) exchange_torque_[spins<D> * i + f] = sum[D + f] * torque_unit;
        finite = finite && std::isfinite(std::accumulate(sum.begin(), sum.end(), 0.0));
    }
    find_loads();
    find_solid_loads();
    std::ptrdiff_t covered = std::accumulate(covered_cells_.begin(), covered_cells_.end(), std::ptrdiff_t{0});
    for (std::size_t i = 0; links_ && i < n; ++i) covered += static_cast<std::ptrdiff_t>(links_->cells_in(i));
    share_.covered_cells = static_cast<double>(covered) / static_cast<double>(populations_.cells());
    return finite;
}

template class Solver<2>;
template class Solver<3>;

}  // namespace lbm
