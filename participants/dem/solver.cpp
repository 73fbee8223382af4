#include "participants/dem/solver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/dem/contacts.hpp"
#include "participants/dem/neighbours.hpp"

namespace dem {

std::size_t Grains::add(Vec2 centre, double disc_radius, double density, Vec2 velocity, double angular_velocity)
{
    double const disc_mass = density * std::numbers::pi * disc_radius * disc_radius;
    x.push_back(centre.x);
    y.push_back(centre.y);
    vx.push_back(velocity.x);
    vy.push_back(velocity.y);
    spin.push_back(angular_velocity);
    radius.push_back(disc_radius);
    mass.push_back(disc_mass);
    inertia.push_back(0.5 * disc_mass * disc_radius * disc_radius);
    for (auto* zero : {&angle, &fx, &fy, &torque, &external_fx, &external_fy, &external_torque}) zero->push_back(0.0);
    half_vx.push_back(velocity.x);
    half_vy.push_back(velocity.y);
    half_spin.push_back(angular_velocity);
    return x.size() - 1;
}

namespace {

template <std::size_t... I>
auto find_kernel(Features wanted, std::index_sequence<I...>)
{
    void (*found)(Setup const&, State&, double) noexcept = nullptr;
    ((supported[I] == wanted ? found = &evaluate_contacts<supported[I]> : found), ...);
    return found;
}

void check_inside(Setup const& setup, Grains const& g)
{
    for (Wall const& wall : setup.walls)
        for (std::size_t i = 0; i < g.size(); ++i)
            sluice::require(dot(Vec2{g.x[i], g.y[i]} - wall.point, wall.normal) > 0.0, [&] {
                return sluice::Error(
                    "dem: the centre of grain " + std::to_string(i) + " is behind wall \"" + wall.name +
                    "\" (must be on the side its normal points to). Turn the normal or move the grain.");
            });
}

}  // namespace

Solver::Solver(Setup setup, Grains grains, std::span<SpringRecord const> springs) : setup_(std::move(setup))
{
    evaluate_ = find_kernel(setup_.features, std::make_index_sequence<std::size(supported)>());
    sluice::require(evaluate_ != nullptr, [] {
        return sluice::Error("dem: this set of features is not compiled. Add it to dem::supported in solver.hpp.");
    });
    check_inside(setup_, grains);
    state_.grains = std::move(grains);
    Grains const& g = state_.grains;
    if (g.size() > 0) smallest_radius_ = *std::min_element(g.radius.begin(), g.radius.end());
    rebuild_lists(setup_, state_);
    set_springs(state_, springs);
    evaluate_(setup_, state_, 0.0);
    if (setup_.features.ledger) evaluate_lossy_power(setup_, state_);
}

void Solver::remove_walls(double now)
{
    bool removed = false;
    for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
        if (!state_.wall_contacts[w].active || setup_.walls[w].removed_at > now) continue;
        if (setup_.features.ledger) {
            Elastic const gone = elastic_energy_of_wall(setup_, state_, w);
            state_.booked.removed_walls += gone.normal + gone.tangential;
        }
        state_.wall_contacts[w] = WallContacts{};
        state_.wall_contacts[w].active = false;
        removed = true;
    }
    if (!removed) return;
    evaluate_(setup_, state_, 0.0);
    if (setup_.features.ledger) evaluate_lossy_power(setup_, state_);
}

void Solver::drift(double dt)
{
    Grains& g = state_.grains;
    double const half = 0.5 * dt, gx = half * setup_.gravity.x, gy = half * setup_.gravity.y;
    double const near = 0.25 * setup_.skin * setup_.skin, far = smallest_radius_ * smallest_radius_;
    std::size_t const count = g.size();
    std::size_t moved = 0, fast = 0;
    for (std::size_t i = 0; i < count; ++i) {
        double const per_mass = half / g.mass[i];
        double const kick_x = gx + per_mass * (g.fx[i] + g.external_fx[i]);
        double const kick_y = gy + per_mass * (g.fy[i] + g.external_fy[i]);
        double const kick_spin = half / g.inertia[i] * (g.torque[i] + g.external_torque[i]);
        double const vx = g.vx[i] + kick_x, vy = g.vy[i] + kick_y, spin = g.spin[i] + kick_spin;
        g.half_vx[i] = vx;
        g.half_vy[i] = vy;
        g.half_spin[i] = spin;
        g.vx[i] = vx + kick_x;
        g.vy[i] = vy + kick_y;
        g.spin[i] = spin + kick_spin;
        double const step_x = dt * vx, step_y = dt * vy;
        g.x[i] += step_x;
        g.y[i] += step_y;
        g.angle[i] += dt * spin;
        double const dx = g.x[i] - state_.built_x[i], dy = g.y[i] - state_.built_y[i];
        moved += !(dx * dx + dy * dy <= near);  // also true for a number that is not finite
        fast += !(step_x * step_x + step_y * step_y <= far);
    }
    sluice::require(fast == 0, [&] {
        std::size_t i = 0;
        while (dt * std::hypot(g.half_vx[i], g.half_vy[i]) <= smallest_radius_) ++i;
        return sluice::Error("dem: grain " + std::to_string(i) +
                                 " moves by more than the smallest radius in one step, at t = " +
                                 std::to_string(state_.time) + " s, step " + std::to_string(state_.steps) +
                                 " (contacts would be missed). Try a smaller step, or look for overlaps at the start.",
                             sluice::Exit::numerical);
    });
    if (moved > 0) rebuild_lists(setup_, state_);
}

void Solver::kick(double dt)
{
    Grains& g = state_.grains;
    double const half = 0.5 * dt, gx = half * setup_.gravity.x, gy = half * setup_.gravity.y;
    std::size_t const count = g.size();
    for (std::size_t i = 0; i < count; ++i) {
        double const per_mass = half / g.mass[i];
        g.vx[i] = g.half_vx[i] + (gx + per_mass * (g.fx[i] + g.external_fx[i]));
        g.vy[i] = g.half_vy[i] + (gy + per_mass * (g.fy[i] + g.external_fy[i]));
        g.spin[i] = g.half_spin[i] + half / g.inertia[i] * (g.torque[i] + g.external_torque[i]);
    }
}

//! The work of what is not elastic, by the trapezium of its power at full steps: with velocity Verlet this is the work
//! that changed the kinetic energy, up to a term dt^2 F^2 / (8 m) that does not grow. The external force is constant
//! over a step.
void Solver::book_step(double dt)
{
    Grains const& g = state_.grains;
    State::Power const before = state_.power;
    evaluate_lossy_power(setup_, state_);
    state_.booked.normal_dashpot += 0.5 * dt * (before.normal + state_.power.normal);
    state_.booked.tangential_dashpot += 0.5 * dt * (before.tangential + state_.power.tangential);
    state_.booked.sliding += 0.5 * dt * (before.sliding + state_.power.sliding);
    double power = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i)
        power +=
            g.external_fx[i] * g.half_vx[i] + g.external_fy[i] * g.half_vy[i] + g.external_torque[i] * g.half_spin[i];
    state_.booked.external_work += dt * power;
}

void Solver::step(double dt)
{
    remove_walls(state_.time + 0.5 * dt);  // a removal time belongs to the nearest step
    drift(dt);
    evaluate_(setup_, state_, dt);
    kick(dt);
    if (setup_.features.ledger) book_step(dt);
    state_.time += dt;
    ++state_.steps;
}

void Solver::set_laws(NormalForce const& normal_force, TangentialForce const& tangential_force)
{
    setup_.normal_force = normal_force;
    setup_.tangential_force = tangential_force;
    for (Wall& wall : setup_.walls) {
        wall.normal_force = normal_force;
        wall.tangential_force = tangential_force;
    }
    evaluate_(setup_, state_, 0.0);
}

void Solver::restore(State state)
{
    state_ = std::move(state);
    Grains const& g = state_.grains;
    if (g.size() > 0) smallest_radius_ = *std::min_element(g.radius.begin(), g.radius.end());
}

std::vector<SpringRecord> springs_of(State const& state)
{
    std::vector<SpringRecord> records;
    Pairs const& pairs = state.pairs;
    auto const count = static_cast<std::uint32_t>(state.grains.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot)
            if (pairs.spring[slot] != 0.0) records.push_back({i, pairs.other[slot], pairs.spring[slot]});
    for (std::size_t w = 0; w < state.wall_contacts.size(); ++w)
        for (std::size_t k = 0; k < state.wall_contacts[w].grain.size(); ++k)
            if (state.wall_contacts[w].spring[k] != 0.0)
                records.push_back({state.wall_contacts[w].grain[k], count + static_cast<std::uint32_t>(w),
                                   state.wall_contacts[w].spring[k]});
    return records;
}

void set_springs(State& state, std::span<SpringRecord const> records)
{
    auto const count = static_cast<std::uint32_t>(state.grains.size());
    auto place = [](auto begin, auto end, std::uint32_t wanted) {
        auto const at = std::lower_bound(begin, end, wanted);
        return at != end && *at == wanted ? at : end;
    };
    for (SpringRecord const& r : records) {
        if (r.first >= count) continue;
        if (r.second < count) {
            auto const begin = state.pairs.other.begin() + state.pairs.first[r.first];
            auto const end = state.pairs.other.begin() + state.pairs.first[r.first + 1];
            auto const at = place(begin, end, r.second);
            if (at != end) state.pairs.spring[static_cast<std::size_t>(at - state.pairs.other.begin())] = r.spring;
        } else if (r.second - count < state.wall_contacts.size()) {
            WallContacts& contacts = state.wall_contacts[r.second - count];
            auto const at = place(contacts.grain.begin(), contacts.grain.end(), r.first);
            if (at != contacts.grain.end())
                contacts.spring[static_cast<std::size_t>(at - contacts.grain.begin())] = r.spring;
        }
    }
}

}  // namespace dem
