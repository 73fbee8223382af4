// Solver: what goes in and comes out between two steps.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <unordered_map>

#include "coupler/base/error.hpp"
#include "participants/lbm/blow_up.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::Exit;
using sluice::require;

template <class... Value>
std::string format(char const* pattern, Value... value)
{
    char text[400];
    std::snprintf(text, sizeof text, pattern, value...);
    return text;
}

}  // namespace

void Solver::check_discs(DiscsView const& discs) const
{
    std::size_t const n = discs.radius.size();
    bool const shaped = discs.position.size() == 2 * n && discs.velocity.size() == 2 * n &&
                        discs.angular_velocity.size() == n && (discs.id.empty() || discs.id.size() == n);
    require(shaped, [&] {
        return Error("fluid: the discs' arrays differ in length (all must have one entry a disc).", Exit::protocol);
    });
    for (std::size_t i = 0; i < n; ++i) {
        bool const finite = std::isfinite(discs.position[2 * i] + discs.position[2 * i + 1] + discs.velocity[2 * i] +
                                          discs.velocity[2 * i + 1] + discs.angular_velocity[i]);
        require(finite && discs.radius[i] > 0 && std::isfinite(discs.radius[i]), [&] {
            return Error(
                format("fluid: disc %zu at t = %g s: position (%g, %g) m, radius %g m (must be finite, radius > 0).",
                       discs.id.empty() ? i : static_cast<std::size_t>(discs.id[i]), time(), discs.position[2 * i],
                       discs.position[2 * i + 1], discs.radius[i]),
                Exit::numerical);
        });
    }
}

void Solver::set_discs(DiscsView const& discs)
{
    check_discs(discs);
    std::size_t const n = discs.radius.size();
    double const cell = config_.cell, velocity_unit = config_.units().velocity_unit();
    discs_.resize(n);
    id_.resize(n);
    displaced_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        double const radius = config_.hydrodynamic_radius * discs.radius[i];
        discs_[i] = {.x = (discs.position[2 * i] - config_.origin[0]) / cell,
                     .y = (discs.position[2 * i + 1] - config_.origin[1]) / cell,
                     .radius = radius / cell,
                     .ux = discs.velocity[2 * i] / velocity_unit,
                     .uy = discs.velocity[2 * i + 1] / velocity_unit,
                     .spin = discs.angular_velocity[i] * config_.step};
        id_[i] = discs.id.empty() ? i : discs.id[i];
        displaced_[i] = {.mass = config_.density * std::numbers::pi * radius * radius,
                         .gyration = 0.5 * radius * radius,
                         .velocity = {discs.velocity[2 * i], discs.velocity[2 * i + 1], discs.angular_velocity[i]}};
    }
    resize_loads(n);
}

void Solver::resize_loads(std::size_t discs)
{
    for (auto* v : {&force_, &exchange_}) v->resize(2 * discs);
    for (auto* v : {&torque_, &exchange_torque_}) v->resize(discs);
}

//! From the momentum exchanged to the load on a disc:
//!     load = (exchange of this step + exchange of the last)/2 + m_f (dU/dt - a)
//! The mean takes out the swing of period 2 that the populations thrown back inside a disc make; half of the last
//! exchange is always under way. m_f = rho_0 pi r^2 is fluid that the lattice keeps inside a disc and that does not
//! exist: it is carried along and feels the body force. m_f a makes the buoyancy -rho_0 V a, exactly. dU is the change
//! of the disc's velocity since the last step; a new disc has no past.
void Solver::find_loads()
{
    std::size_t const n = id_.size();
    std::unordered_map<std::uint64_t, std::size_t> where;
    bool const same = id_ == last_id_;
    for (std::size_t i = 0; !same && i < last_id_.size(); ++i) where.emplace(last_id_[i], i);
    std::vector<Past> now(n);
    double const rate = 1 / config_.step;
    for (std::size_t i = 0; i < n; ++i) {
        Displaced const& d = displaced_[i];
        now[i] = {d.velocity, {exchange_[2 * i], exchange_[2 * i + 1], exchange_torque_[i]}};
        auto const found = same ? where.end() : where.find(id_[i]);
        Past const past = same ? past_[i] : found != where.end() ? past_[found->second] : Past{d.velocity, {0, 0, 0}};
        auto const load = [&](std::size_t k, double inertia) {
            return 0.5 * (now[i].exchange[k] + past.exchange[k]) + inertia * rate * (d.velocity[k] - past.velocity[k]);
        };
        force_[2 * i] = load(0, d.mass) - d.mass * config_.acceleration[0];
        force_[2 * i + 1] = load(1, d.mass) - d.mass * config_.acceleration[1];
        torque_[i] = load(2, d.mass * d.gyration);
    }
    past_ = std::move(now);
    if (!same) last_id_ = id_;
}

void Solver::set_obstacle(std::vector<double> fraction)
{
    auto const cells = static_cast<std::size_t>(populations_.nx() * populations_.ny());
    require(fraction.size() == cells, [&] {
        return Error(format("fluid: the obstacle has %zu cells (the lattice has %zu).", fraction.size(), cells));
    });
    coverage_.set_obstacle(std::move(fraction));
}

//! Equilibrium plus the first-order stress -tau w_q rho/c_s^2 (c c - c_s^2 I) : grad u, less half the force.
void Solver::set_state(std::function<PointState(double x, double y)> const& at)
{
    LatticeUnits const unit = config_.units();
    double const velocity = unit.velocity_unit();
    for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y) {
        Slots const f = populations_.row(y);
        for (std::ptrdiff_t x = 0; x < populations_.nx(); ++x) {
            PointState const s = at(config_.origin[0] + (static_cast<double>(x) + 0.5) * config_.cell,
                                    config_.origin[1] + (static_cast<double>(y) + 0.5) * config_.cell);
            double const excess = unit.density_excess_lu(s.pressure), rho = 1 + excess;
            double const ux = s.velocity[0] / velocity, uy = s.velocity[1] / velocity;
            double g[4];
            for (int k = 0; k < 4; ++k) g[k] = s.gradient[k] * config_.step;
            for (std::size_t q = 0; q < directions; ++q) {
                double const stress =
                    cx[q] * cx[q] * g[0] + cx[q] * cy[q] * (g[1] + g[2]) + cy[q] * cy[q] * g[3] - (g[0] + g[3]) / 3;
                double const force = cx[q] * relaxation_.force_x + cy[q] * relaxation_.force_y;
                f[q][x] = equilibrium(static_cast<int>(q), excess, ux, uy) -
                          weight[q] * (3 * rho * relaxation_.tau * stress + 1.5 * force);
            }
        }
    }
    complete_ = true;
}

//! Writes what enters from outside, so that every cell's populations are those of now.
void Solver::complete()
{
    if (complete_) return;
    team_.share(populations_.ny(), 64, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t y = begin; y < end; ++y) enter_from_outside(populations_, y, walls_);
    });
    coverage_.update(discs_, team_);
    complete_ = true;
}

double Solver::mass()
{
    complete();
    double sum = 0;
    for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y)
        for (std::size_t q = 0; q < directions; ++q)
            for (std::ptrdiff_t x = 0; x < populations_.nx(); ++x) sum += populations_.row(q, y)[x];
    return (sum + static_cast<double>(populations_.nx() * populations_.ny())) * config_.units().mass_unit();
}

std::array<double, 2> Solver::momentum()
{
    complete();
    double sum_x = 0, sum_y = 0;
    for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y)
        for (std::size_t q = 1; q < directions; ++q)
            for (std::ptrdiff_t x = 0; x < populations_.nx(); ++x) {
                sum_x += cx[q] * populations_.row(q, y)[x];
                sum_y += cy[q] * populations_.row(q, y)[x];
            }
    double const unit = config_.units().momentum_unit();
    return {sum_x * unit, sum_y * unit};
}

//! Stops the run at the first cell that is not finite, too fast or too dense: one vector pass over the rows, and only
//! if it finds something the slow search that can say where.
void Solver::watch()
{
    complete();
    std::atomic<bool> found = false;
    team_.share(populations_.ny(), 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t y = begin; y < end; ++y)
            if (has_blown_up(populations_.row(y), populations_.nx())) found.store(true, std::memory_order_relaxed);
    });
    if (found) report_blow_up();
}

void Solver::report_blow_up()
{
    RowState row;
    for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y) {
        read_row(y, row);
        Slots cell = populations_.row(y);
        for (std::size_t x = 0; x < row.ux.size(); ++x) {
            bool const bad = has_blown_up(cell, 1);
            for (double*& slot : cell) ++slot;
            require(!bad, [&] {
                double const unit = config_.units().velocity_unit();
                return Error(
                    format("fluid: t = %g s (step %lld), cell (%zu, %td) at (%g, %g) m: speed %g m/s, density %g of "
                           "rho_0 (speed must stay below %g m/s, density within 0.5 to 1.5). Take a shorter step (a "
                           "smaller lattice_velocity), a smaller cell, or les.",
                           time(), static_cast<long long>(steps_), x, y,
                           config_.origin[0] + (static_cast<double>(x) + 0.5) * config_.cell,
                           config_.origin[1] + (static_cast<double>(y) + 0.5) * config_.cell,
                           std::hypot(row.ux[x], row.uy[x]) * unit, 1 + row.excess[x], speed_limit * unit),
                    Exit::numerical);
            });
        }
    }
}

}  // namespace lbm
