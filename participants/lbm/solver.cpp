#include "participants/lbm/solver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "coupler/base/error.hpp"
#include "participants/lbm/collide.hpp"
#include "participants/lbm/solid_weight.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::require;

constexpr std::ptrdiff_t block = 8;         //!< cells that go to one kernel or the other together
constexpr std::ptrdiff_t rows_a_chunk = 4;  //!< handed to a thread at a time
constexpr std::int64_t watch_every = 64;    //!< steps

using Kernel = void (*)(Slots const&, std::ptrdiff_t, std::ptrdiff_t, Relaxation const&, SolidRow const&);

struct Kernels
{
    Features features;  //!< of the fluid between the grains
    Kernel fluid, covered;
};

template <bool Les, bool Force>
constexpr Kernels kernels = {{.les = Les, .force = Force},
                             collide<Features{.les = Les, .force = Force}>,
                             collide<Features{.les = Les, .force = Force, .grains = true}>};

constexpr Kernels supported[] = {kernels<false, false>, kernels<false, true>, kernels<true, false>,
                                 kernels<true, true>};

Kernels const& choose(Config const& c)
{
    Features const wanted{.les = c.smagorinsky > 0, .force = c.acceleration[0] != 0 || c.acceleration[1] != 0};
    return *std::find_if(std::begin(supported), std::end(supported), [&](auto& k) { return k.features == wanted; });
}

Config checked(Config const& config)
{
    std::string text;
    for (Issue const& issue : find_issues(config))
        if (issue.refused)
            text.append(text.empty() ? "fluid: " : "\nfluid: ").append(issue.key).append(" = ").append(issue.text);
    require(text.empty(), [&] { return Error(text); });
    return config;
}

Walls walls_lu(Config const& c)
{
    Walls walls{c.walls[left].periodic, c.walls[bottom].periodic, {}};
    for (std::size_t s = 0; s < 4; ++s) walls.velocity[s] = c.walls[s].velocity / c.units().velocity_unit();
    return walls;
}

//! One row's solids; each thread keeps its own. Strips are worked on in whole lanes: beyond the row's end lie cells
//! that take what a strip cut off there has left, and exchange nothing.
struct RowBuffer
{
    std::vector<double> fraction, weight, momentum_x, momentum_y, force_rate, force_x, force_y;
    std::vector<char> touched;  //!< for each block

    void resize(std::ptrdiff_t nx)
    {
        auto const n = static_cast<std::size_t>(nx + strip_lanes);
        if (fraction.size() == n) return;
        for (auto* v : {&fraction, &weight, &momentum_x, &momentum_y, &force_rate, &force_x, &force_y})
            v->assign(n, 0.0);
        touched.resize(n / block + 1);
    }
    SolidRow view()
    {
        return {fraction.data(),   weight.data(),  momentum_x.data(), momentum_y.data(),
                force_rate.data(), force_x.data(), force_y.data()};
    }
};

thread_local RowBuffer buffer;

//! Velocity of a body at the centres of a strip's cells: ux is the same all along, uy = uy0 + k spin.
struct StripVelocity
{
    double ux, uy, spin;
    StripVelocity(Strip const& s, std::span<Disc const> discs) : ux(0), uy(0), spin(0)
    {
        if (s.body >= static_cast<std::ptrdiff_t>(discs.size())) return;  // the obstacle rests
        Disc const& d = discs[static_cast<std::size_t>(s.body)];
        ux = d.ux - d.spin * s.arm_y;
        uy = d.uy + d.spin * s.arm_x;
        spin = d.spin;
    }
};

void find_weights(std::ptrdiff_t begin, std::ptrdiff_t end, double tau, RowBuffer& row)
{
    double const* const fraction = row.fraction.data();
    double* const weight = row.weight.data();
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) weight[x] = weight_per_fraction(fraction[x], tau);
}

//! Deep inside a disc, where all neighbours are covered as well, the fluid takes the disc's velocity in one step.
void set_core_weight(Strip const& strip, std::span<Disc const> discs, RowBuffer& row)
{
    if (strip.body >= static_cast<std::ptrdiff_t>(discs.size())) return;
    double const core = discs[static_cast<std::size_t>(strip.body)].radius - skin;
    double const square = core * core - strip.arm_y * strip.arm_y;
    if (core <= 0 || square <= 0) return;
    double const half = std::sqrt(square);
    auto const first = static_cast<std::ptrdiff_t>(std::ceil(-half - strip.arm_x));
    auto const last = static_cast<std::ptrdiff_t>(std::floor(half - strip.arm_x));
    double* const weight = row.weight.data() + strip.begin;
    double const* const fraction = row.fraction.data() + strip.begin;
    std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(first, 0), end = std::min(last + 1, strip.count);
#pragma omp simd
    for (std::ptrdiff_t k = begin; k < end; ++k) weight[k] = core_weight / fraction[k];
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
int whole_lanes(Strip const& strip)
{
    auto const count = static_cast<int>((strip.count + strip_lanes - 1) / strip_lanes * strip_lanes);
    if (count % strip_lanes != 0 || count <= 0) __builtin_unreachable();  // spares the loops a remainder
    return count;
}

void add_strip(Strip const& strip, StripVelocity const& v, RowBuffer& row)
{
    int const count = whole_lanes(strip);
    double* const fraction = row.fraction.data() + strip.begin;
    double* const momentum_x = row.momentum_x.data() + strip.begin;
    double* const momentum_y = row.momentum_y.data() + strip.begin;
#pragma omp simd
    for (int k = 0; k < count; ++k) {  // int: the machine turns four of them into doubles at once
        double const f = strip.fraction[k];
        fraction[k] += f;
        momentum_x[k] += f * v.ux;
        momentum_y[k] += f * (v.uy + static_cast<double>(k) * v.spin);
    }
}

}  // namespace

Solver::Solver(Config const& config)
    : config_(checked(config)),
      relaxation_(relaxation(config_)),
      walls_(walls_lu(config_)),
      fluid_(choose(config_).fluid),
      covered_(choose(config_).covered),
      team_(config_.threads),
      populations_(config_.cells()[0], config_.cells()[1], team_),
      coverage_(config_.cells()[0], config_.cells()[1], walls_.periodic_x, walls_.periodic_y),
      covered_cells_(static_cast<std::size_t>(config_.cells()[1]))
{}

void Solver::step()
{
    sluice::Team::Awake const awake(team_);
    std::ptrdiff_t const rebuilt = coverage_.update(discs_, team_);
    share_.rebuilt_discs = static_cast<double>(rebuilt) / std::max(1.0, static_cast<double>(discs_.size()));
    strip_load_.resize(coverage_.strips().size());
    team_.share(populations_.ny(), rows_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t y = begin; y < end; ++y) collide_row(y);
    });
    bool const finite = sum_loads();
    populations_.stream(team_);
    complete_ = false;
    ++steps_;
    if (!finite || steps_ % watch_every == 0) watch();
    require(finite, [&] {
        return Error("fluid: t = " + std::to_string(time()) + " s: the force on a disc is not finite.",
                     sluice::Exit::numerical);
    });
}

void Solver::collide_row(std::ptrdiff_t y)
{
    if (!complete_) enter_from_outside(populations_, y, walls_);
    covered_cells_[static_cast<std::size_t>(y)] = 0;
    if (auto const strips = coverage_.row(y); !strips.empty()) return collide_covered_row(y, strips);
    fluid_(populations_.row(y), 0, populations_.nx(), relaxation_, {});
}

//! Cuts the row into runs of blocks with and without solids.
void Solver::collide_covered_row(std::ptrdiff_t y, std::span<std::uint32_t const> strips)
{
    std::ptrdiff_t const nx = populations_.nx(), blocks = (nx + block - 1) / block;
    buffer.resize(nx);
    std::fill_n(buffer.touched.begin(), blocks, 0);
    for (std::uint32_t const k : strips) {
        Strip const& s = coverage_.strips()[k];
        prefetch(s.fraction, s.count);
        std::fill(buffer.touched.begin() + s.begin / block,
                  buffer.touched.begin() + (s.begin + whole_lanes(s) - 1) / block + 1, 1);
    }
    if (y + 1 < populations_.ny())
        for (std::uint32_t const k : coverage_.row(y + 1)) prefetch(&coverage_.strips()[k], 1);
    auto const each_run = [&](auto&& run) {
        for (std::ptrdiff_t first = 0, last = 0; first < blocks; first = last) {
            char const touched = buffer.touched[static_cast<std::size_t>(first)];
            while (last < blocks && buffer.touched[static_cast<std::size_t>(last)] == touched) ++last;
            run(first * block, std::min(last * block, nx), touched != 0);
        }
    };
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return;
        for (auto* v : {&buffer.fraction, &buffer.momentum_x, &buffer.momentum_y})
            std::fill(v->begin() + begin, v->begin() + end, 0.0);
    });
    for (std::uint32_t const k : strips) {
        Strip const& s = coverage_.strips()[k];
        add_strip(s, StripVelocity(s, discs_), buffer);
    }
    Slots const slots = populations_.row(y);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (!touched) return fluid_(slots, begin, end, relaxation_, {});
        covered_cells_[static_cast<std::size_t>(y)] += end - begin;
        find_weights(begin, end, relaxation_.tau, buffer);
    });
    for (std::uint32_t const k : strips) set_core_weight(coverage_.strips()[k], discs_, buffer);
    each_run([&](std::ptrdiff_t begin, std::ptrdiff_t end, bool touched) {
        if (touched) covered_(slots, begin, end, relaxation_, buffer.view());
    });
    add_strip_forces(strips, buffer.view());
}

void Solver::add_strip_forces(std::span<std::uint32_t const> strips, SolidRow const& solid)
{
    for (std::uint32_t const index : strips) {
        Strip const& s = coverage_.strips()[index];
        StripVelocity const v(s, discs_);
        double const *const rate = solid.force_rate + s.begin, *const x = solid.force_x + s.begin,
                            *const y = solid.force_y + s.begin, *const fraction = s.fraction;
        int const count = whole_lanes(s);
        double force_x = 0, force_y = 0, moment = 0;
#pragma omp simd reduction(+ : force_x, force_y, moment)
        for (int k = 0; k < count; ++k) {
            double const fx = fraction[k] * (x[k] - rate[k] * v.ux);
            double const fy = fraction[k] * (y[k] - rate[k] * (v.uy + static_cast<double>(k) * v.spin));
            force_x += fx;
            force_y += fy;
            moment += (s.arm_x + static_cast<double>(k)) * fy;
        }
        strip_load_[index] = {force_x, force_y, moment - s.arm_y * force_x};
    }
}

//! Sums each disc's strips in their order, whatever the number of threads. Returns whether all loads are finite.
bool Solver::sum_loads()
{
    std::size_t const n = discs_.size();
    double const force_unit = config_.units().force_unit(), torque_unit = config_.units().torque_unit();
    bool finite = true;
    for (std::size_t i = 0; i < n; ++i) {
        StripLoad sum{};
        auto const [begin, end] = coverage_.of_body(i);
        for (std::size_t k = begin; k < end; ++k) {
            sum.force_x += strip_load_[k].force_x;
            sum.force_y += strip_load_[k].force_y;
            sum.torque += strip_load_[k].torque;
        }
        exchange_[2 * i] = sum.force_x * force_unit;
        exchange_[2 * i + 1] = sum.force_y * force_unit;
        exchange_torque_[i] = sum.torque * torque_unit;
        finite = finite && std::isfinite(sum.force_x + sum.force_y + sum.torque);
    }
    find_loads();
    std::ptrdiff_t const covered = std::accumulate(covered_cells_.begin(), covered_cells_.end(), std::ptrdiff_t{0});
    share_.covered_cells = static_cast<double>(covered) / static_cast<double>(populations_.nx() * populations_.ny());
    return finite;
}

}  // namespace lbm
