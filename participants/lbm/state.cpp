// Solver: what goes in and comes out between two steps.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "coupler/base/error.hpp"
#include "coupler/base/format.hpp"
#include "participants/lbm/blow_up.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::Exit;
using sluice::format;
using sluice::require;

constexpr double most_cells_away = 1e9;  //!< of a body: then its place is known to 1e-7 of a cell

//! Numbers with commas between.
std::string listed(std::span<double const> numbers)
{
    std::string text;
    for (double const number : numbers) text += format(text.empty() ? "%g" : ", %g", number);
    return text;
}

}  // namespace

//! On a cell x of a row whose fluid has a velocity.
template <int D>
std::array<double, 3> Solver<D>::force_on(Relaxation const& row, std::ptrdiff_t x, double rho,
                                          std::array<double, D> const& velocity) const
{
    std::array<double, 3> force = row.force, j{};
    for (std::size_t k = 0; k < D; ++k) j[k] = rho * velocity[k];
    auto const turned = cross(row.turn, j);
    for (std::size_t k = 0; k < 3; ++k) force[k] += row.slope[k] * static_cast<double>(x) - 2 * turned[k];
    return force;
}

template <int D>
void Solver<D>::check_bodies(BodiesView const& bodies) const
{
    std::size_t const n = bodies.radius.size();
    bool const shaped = bodies.position.size() == D * n && bodies.velocity.size() == D * n &&
                        bodies.angular_velocity.size() == spins<D> * n && (bodies.id.empty() || bodies.id.size() == n);
    require(shaped, [&] {
        return Error("fluid: the bodies' arrays differ in length (all must have one entry a body).", Exit::protocol);
    });
    auto const finite = [](std::span<double const> values) {
        return std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
    };
    auto const name = [&](std::size_t i) {
        return format("fluid: body %zu at t = %g s: ", bodies.id.empty() ? i : static_cast<std::size_t>(bodies.id[i]),
                      time());
    };
    double repeats = std::numeric_limits<double>::infinity();  // after so many metres, where cells have one body each
    for (std::size_t k = 0; k < D && links_; ++k)
        if (config_.periodic(k)) repeats = std::min(repeats, config_.size[k]);
    for (std::size_t i = 0; i < n; ++i) {
        bool placed = finite(bodies.velocity.subspan(D * i, D)) &&
                      finite(bodies.angular_velocity.subspan(spins<D> * i, spins<D>));
        for (std::size_t k = 0; k < D; ++k)  // false if it is not a number
            placed =
                placed && std::abs(bodies.position[D * i + k] - config_.origin[k]) < most_cells_away * config_.cell;
        require(placed && bodies.radius[i] > 0 && std::isfinite(bodies.radius[i]), [&] {
            return Error(
                name(i) + format("position (%s) m, radius %g m (must be finite, within 1e9 cells of the domain, "
                                 "radius > 0).",
                                 listed(bodies.position.subspan(D * i, D)).c_str(), bodies.radius[i]),
                Exit::numerical);
        });
        double const across = 2 * config_.hydrodynamic_radius * bodies.radius[i];
        require(across < repeats, [&] {
            return Error(name(i) + format("%g m across in a domain that repeats after %g m (needed with grains: "
                                          "interpolated: less, or it would touch its own image). Take a longer domain, "
                                          "or grains: covered.",
                                          across, repeats));
        });
    }
}

template <int D>
void Solver<D>::set_bodies(BodiesView const& bodies)
{
    check_bodies(bodies);
    std::size_t const n = bodies.radius.size();
    double const cell = config_.cell, velocity_unit = config_.units().velocity_unit(), pi = std::numbers::pi;
    bodies_.resize(n);
    id_.resize(n);
    displaced_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        double const r = config_.hydrodynamic_radius * bodies.radius[i];
        Body<D>& body = bodies_[i];
        Displaced& displaced = displaced_[i];
        displaced.mass = config_.density * (D == 2 ? pi * r * r : 4.0 / 3.0 * pi * r * r * r);
        displaced.gyration = (D == 2 ? 0.5 : 0.4) * r * r;
        body.radius = r / cell;
        for (std::size_t k = 0; k < D; ++k) {
            body.centre[k] = (bodies.position[D * i + k] - config_.origin[k]) / cell;
            body.velocity[k] = bodies.velocity[D * i + k] / velocity_unit;
            displaced.motion[k] = bodies.velocity[D * i + k];
        }
        for (std::size_t k = 0; k < spins<D>; ++k) {
            body.spin[k] = bodies.angular_velocity[spins<D> * i + k] * config_.step;
            displaced.motion[D + k] = bodies.angular_velocity[spins<D> * i + k];
        }
        id_[i] = bodies.id.empty() ? i : bodies.id[i];
    }
    resize_loads(n);
}

template <int D>
void Solver<D>::resize_loads(std::size_t bodies)
{
    for (auto* v : {&force_, &exchange_}) v->resize(D * bodies);
    for (auto* v : {&torque_, &exchange_torque_}) v->resize(spins<D> * bodies);
}

//! From lattice units [m].
template <int D>
std::array<double, D> Solver<D>::place_of(std::array<double, D> at) const
{
    for (std::size_t k = 0; k < D; ++k) at[k] = config_.origin[k] + at[k] * config_.cell;
    return at;
}

//! Where the centre of a cell is [m].
template <int D>
std::array<double, D> Solver<D>::centre_of(std::ptrdiff_t x, std::ptrdiff_t r) const
{
    Row const& row = layout_.row(r);
    Extent const cell{row.first + x, row.y, row.z};
    std::array<double, D> at;
    for (std::size_t k = 0; k < D; ++k) at[k] = config_.origin[k] + (static_cast<double>(cell[k]) + 0.5) * config_.cell;
    return at;
}

//! Equilibrium plus the first-order stress -tau w_q rho/c_s^2 (c c - c_s^2 I) : grad u, less half the force.
template <int D>
void Solver<D>::set_state(std::function<PointState<D>(std::array<double, D> const& at)> const& state)
{
    using L = Lattice<D>;
    LatticeUnits const unit = config_.units();
    auto const set_row = [&](std::ptrdiff_t r, auto const& f) {
        using Stored = std::remove_reference_t<decltype(*f[0])>;
        Relaxation const relaxation = of_row(r);
        for (std::ptrdiff_t x = 0; x < layout_.row(r).cells; ++x) {
            PointState<D> const s = state(centre_of(x, r));
            double const excess = unit.density_excess_lu(s.pressure), rho = 1 + excess;
            std::array<double, D> u = s.velocity;
            for (double& v : u) v /= unit.velocity_unit();
            auto const force = force_on(relaxation, x, rho, u);
            for (std::size_t q = 0; q < L::directions; ++q) {
                double stress = 0;
                for (std::size_t a = 0; a < D; ++a)
                    for (std::size_t b = 0; b < D; ++b)
                        stress +=
                            (L::c[q][a] * L::c[q][b] - (a == b ? 1.0 / 3 : 0.0)) * s.gradient[a][b] * config_.step;
                f[q][x] = static_cast<Stored>(equilibrium<D>(q, excess, u) -
                                              L::weight[q] *
                                                  (3 * rho * relaxation_.tau * stress + 1.5 * dot(L::c[q], force)));
            }
        }
    };
    if (halo_) halo_->receive(populations_);  // lest they come later
    populations_.visit([&](auto const& rows) {
        for (std::ptrdiff_t r = 0; r < rows.rows(); ++r) {
            set_row(r, rows.row(r));
            note_turned(rows, r, walls_, Incoming::found);
        }
    });
    complete_ = true;
}

//! Writes what enters from outside, so that every cell's populations are those of now.
template <int D>
void Solver<D>::complete()
{
    if (complete_) return;
    if (halo_) halo_->receive(populations_);
    team_.share(layout_.rows(), 64, [&](std::ptrdiff_t begin, std::ptrdiff_t end) { enter_rows(begin, end); });
    coverage_.update(covering(), team_);
    if (phase_) phase_->spread();
    complete_ = true;
}

//! Cells in bodies with an interpolated surface are no fluid.
template <int D>
void Solver<D>::leave_out_bodies(std::ptrdiff_t r, RowState<D>& row) const
{
    if (!links_) return;
    for (std::size_t x = 0; x < row.excess.size(); ++x) {
        if (!links_->covers(r, static_cast<std::ptrdiff_t>(x))) continue;
        row.excess[x] = -1;
        for (auto& component : row.velocity) component[x] = 0;
    }
}

//! of_row(row's state) over all rows of all processes, in one order: by layers.
template <int D>
template <std::size_t K, class Of>
std::array<double, K> Solver<D>::sum_over_rows(Of&& of_row) const
{
    RowState<D> row;
    std::vector<SumPart<K>> parts;
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        read_moments(r, row);
        leave_out_bodies(r, row);
        if (parts.empty() || parts.back().layer != domain_.layer_of(r)) parts.push_back({0, domain_.layer_of(r), {}});
        std::array<double, K> const sums = of_row(row);
        for (std::size_t k = 0; k < K; ++k) parts.back().sum[k] += sums[k];
    }
    return domain_.totals(parts, 1)[0];
}

template <int D>
double Solver<D>::mass()
{
    complete();
    double const excess = sum_over_rows<1>([](RowState<D> const& row) {
        return std::array{std::accumulate(row.excess.begin(), row.excess.end(), 0.0)};
    })[0];
    return (excess + static_cast<double>(domain_.whole().stored())) * config_.units().mass_unit();
}

template <int D>
std::array<double, D> Solver<D>::momentum()
{
    complete();
    auto sum = sum_over_rows<D>([](RowState<D> const& row) {
        std::array<double, D> sums;
        for (std::size_t k = 0; k < D; ++k)
            sums[k] = std::accumulate(row.velocity[k].begin(), row.velocity[k].end(), 0.0);
        return sums;
    });
    for (double& component : sum) component *= config_.units().momentum_unit();
    return sum;
}

//! Stops the run at the first cell that is not finite, too fast or too dense: one vector pass over the rows, and only
//! if it finds something the slow search that can say where.
template <int D>
void Solver<D>::watch()
{
    complete();
    std::atomic<bool> found = false;
    team_.share(layout_.rows(), 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        populations_.visit([&](auto const& rows) {
            for (std::ptrdiff_t r = begin; r < end; ++r)
                if (has_blown_up<D>(rows.row(r), rows.nx(r))) found.store(true, std::memory_order_relaxed);
        });
    });
    if (found) report_blow_up();
}

template <int D>
void Solver<D>::report_blow_up()
{
    double const unit = config_.units().velocity_unit();
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        auto const bad =
            populations_.visit([&](auto const& rows) { return first_blown_up<D>(rows.row(r), rows.nx(r)); });
        if (!bad) continue;
        auto const [speed, density] =
            populations_.visit([&](auto const& rows) { return speed_and_density<D>(rows.row(r), *bad); });
        Row const& at = layout_.row(r);
        std::string place = format("%td, %d", at.first + *bad, at.y);
        if constexpr (D == 3) place += format(", %d", at.z);
        throw Error(format("fluid: t = %g s (step %lld), cell (%s) at (%s) m: speed %g m/s, density %g of rho_0 (speed "
                           "must stay below %g m/s, density within 0.5 to 1.5). Take a shorter step (a smaller "
                           "lattice_velocity), a smaller cell, or les.",
                           time(), static_cast<long long>(steps_), place.c_str(), listed(centre_of(*bad, r)).c_str(),
                           speed * unit, density, speed_limit * unit),
                    Exit::numerical);
    }
}

template class Solver<2>;
template class Solver<3>;

}  // namespace lbm
