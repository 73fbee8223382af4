#include "participants/dem/solver.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/dem/domain.hpp"
#include "participants/dem/film.hpp"
#include "participants/dem/half_step.hpp"
#include "participants/dem/mesh_contacts.hpp"
#include "participants/dem/neighbours.hpp"
#include "participants/dem/stress.hpp"

namespace dem {

template <int D>
std::size_t Grains<D>::add(Vec<D> centre, double radius, double density, Motion<D> const& moves)
{
    double const r = radius, m = density * volume_of<D>(r);
    id.push_back(static_cast<std::int64_t>(size()));
    place.push_back({centre, radius});
    motion.push_back(moves);
    half.push_back(moves);
    mass.push_back(m);
    inertia.push_back((D == 2 ? 0.5 : 0.4) * m * r * r);
    contact.emplace_back();
    external.emplace_back();
    return size() - 1;
}

namespace {

template <int D>
void check_inside(Setup<D> const& setup, Grains<D> const& g)
{
    for (Wall<D> const& wall : setup.walls)
        for (std::size_t i = 0; i < g.size(); ++i) {
            sluice::require(facing_at_start(wall, g.place[i].centre).distance > 0.0, [&] {
                return sluice::Error(
                    "dem: the centre of grain " + std::to_string(g.id[i]) + " is behind wall \"" + wall.name +
                    "\" (must be on the side its normal points to). Turn the normal or move the grain.");
            });
        }
}

template <int D>
double smallest_radius(Grains<D> const& g)
{
    double smallest = g.size() > 0 ? g.place[0].radius : 0.0;
    for (auto const& place : g.place) smallest = std::min(smallest, place.radius);
    return smallest;
}

}  // namespace

template <int D>
Solver<D>::Solver(Setup<D> setup, Grains<D> grains, std::span<ContactRecord<D> const> records)
    : setup_(std::move(setup)),
      team_(setup_.threads > 1 ? std::make_shared<sluice::Team>(setup_.threads) : nullptr),
      evaluate_(setup_.features.periodic ? evaluation_for<D, true>(setup_.features)
                                         : evaluation_for<D, false>(setup_.features))
{
    sluice::require(evaluate_ != nullptr,
                    [] { return sluice::Error("dem: this set of features is not compiled. Add it in contacts.cpp."); });
    check_inside(setup_, grains);
    state_.grains = std::move(grains);
    if (setup_.features.periodic) state_.cell = cell_at_start(setup_.periodic);
    derive();
    state_.walls.resize(setup_.walls.size());
    for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
        state_.walls[w].shift = setup_.walls[w].motion.shift(0.0);
        state_.walls[w].velocity = setup_.walls[w].motion.speed(0.0);
    }
    rebuild_lists(setup_, state_);
    find_feet(setup_, state_, 0.0);
    state_.crossings.clear();
    set_records(state_, records);
    evaluate_again();
}

//! What follows from the grains and does not change.
template <int D>
void Solver<D>::derive()
{
    Grains<D> const& g = state_.grains;
    smallest_radius_ = domain_ ? domain_->smallest_radius() : smallest_radius(g);
    per_mass_.resize(g.size());
    per_inertia_.resize(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
        per_mass_[i] = 1.0 / g.mass[i];
        per_inertia_[i] = 1.0 / g.inertia[i];
    }
}

//! The forces at the end of a step of dt, where contact loads are zero before.
template <int D>
void Solver<D>::evaluate(double dt)
{
    evaluate_(setup_, state_, dt, team_.get());
    if (setup_.lubrication.any()) add_films(setup_, state_, dt);
}

//! The forces as they are, without a step.
template <int D>
void Solver<D>::evaluate_again()
{
    std::fill(state_.grains.contact.begin(), state_.grains.contact.end(), Load<D>{});
    evaluate(0.0);
    if (setup_.features.ledger) evaluate_power();
    if (domain_) domain_->refresh(state_.grains);
}

template <int D>
void Solver<D>::evaluate_power()
{
    evaluate_lossy_power(state_);
    if (setup_.lubrication.any()) state_.power.normal += power_of_films(state_);
}

//! Before a step.
template <int D>
void Solver<D>::let_sleep()
{
    if (state_.steps % steps_between_looks == 0) {
        Look const look = look_for_sleepers(setup_, state_);
        if (look == Look::some_woke)
            evaluate_again();
        else if (look == Look::some_slept && setup_.features.ledger)
            evaluate_power();
    }
    if (!state_.rest.is_apart()) put_aside(setup_, state_);
}

template <int D>
void Solver<D>::share_out(ranks::Peers& peers)
{
    require_shareable(setup_);
    domain_ = std::make_shared<Domain<D>>(peers);
    domain_->distribute(setup_, state_);
    derive();
}

template <int D>
void Solver<D>::set_loads(std::vector<Load<D>> const& loads)
{
    if (domain_) return domain_->deal(loads, state_.grains);
    state_.grains.external = loads;
}

template <int D>
void Solver<D>::gather_motion(Grains<D>& all) const
{
    domain_->gather_motion(state_.grains, all);
}

template <int D>
State<D> Solver<D>::whole() const
{
    return domain_ ? domain_->gather(setup_, state_) : state();
}

template <int D>
void Solver<D>::remove_walls(double now)
{
    bool removed = false;
    for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
        if (!state_.walls[w].active || setup_.walls[w].removed_at > now) continue;
        if (setup_.features.ledger) {
            Elastic const gone = elastic_energy_of_wall(setup_, state_, w);
            state_.booked.removed_walls += gone.normal + gone.tangential + gone.rolling;
        }
        state_.walls[w] = WallContacts<D>{};
        state_.walls[w].active = false;
        removed = true;
    }
    if (!removed) return;
    take_back(setup_, state_);
    wake_all(state_);
    evaluate_again();
}

//! Whether a wall has come nearer by half a skin since the lists were built: the grains have the other half.
template <int D>
bool Solver<D>::walls_have_moved() const
{
    for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
        if (!state_.walls[w].active || !setup_.walls[w].motion.moves()) continue;
        Vec<D> const since = state_.walls[w].shift - state_.walls[w].built_shift;
        if (!(dot(since, since) <= 0.25 * setup_.slack() * setup_.slack())) return true;
    }
    return false;
}

//! Calls body(from, to) for all grains, in pieces that the threads take.
template <int D>
template <class Body>
void Solver<D>::share(Body&& body)
{
    std::size_t const count = state_.grains.size();
    if (!team_) return body(std::size_t{0}, count);
    team_->share(static_cast<std::ptrdiff_t>(count), 512, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        body(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
    });
}

//! All that acts on a grain; nobody's loads are not looked at.
template <int D>
auto Solver<D>::loads() const
{
    return [contact = state_.grains.contact.data(),
            external = setup_.loads ? state_.grains.external.data() : nullptr](std::size_t i) -> Load<D> {
        if (!external) return contact[i];
        return {contact[i].force + external[i].force, contact[i].torque + external[i].torque};
    };
}

//! How grain i moves at the end of a step; `load` is what acts on it.
template <int D>
template <class Half>
Motion<D> Solver<D>::kicked(double dt, Half const& second, std::size_t i, Load<D> const& load) const
{
    double const half = 0.5 * dt;
    Motion<D> const& h = state_.grains.half[i];
    return {
        second.velocity(h.velocity) + (second.fall(state_.grains.place[i].centre) + (half * per_mass_[i]) * load.force),
        second.spin(h.spin) + second.twist((half * per_inertia_[i]) * load.torque)};
}

//! First half and drift, and before them what is due of the last step. Leaves contact loads zero.
template <int D>
template <class Half>
void Solver<D>::drift(double dt, std::optional<Half> const& due, Half const& first, Half const& second)
{
    Grains<D>& g = state_.grains;
    double const half = 0.5 * dt;
    double const free = 0.5 * (setup_.slack() - moved_since_built(setup_.periodic, state_.cell));
    double const near = free > 0.0 ? free * free : -1.0, far = smallest_radius_ * smallest_radius_;
    bool const predicts = setup_.features.scheme == Scheme::predicted;
    auto const load_on = loads();
    std::atomic<bool> any_moved = false, any_fast = false;
    auto const* const asleep = state_.rest.is_apart() ? state_.rest.asleep.data() : nullptr;
    share([&, due, first, second](std::size_t from, std::size_t to) {
        std::size_t moved = 0, fast = 0;
        for (std::size_t i = from; i < to; ++i) {
            Load<D> const load = load_on(i);
            g.contact[i] = {};
            if (asleep && asleep[i] != 0U) continue;
            Motion<D> const before = due ? kicked(dt, *due, i, load) : g.motion[i];
            Vec<D> const kick = first.fall(g.place[i].centre) + (half * per_mass_[i]) * load.force;
            Spin<D> const turn = first.twist((half * per_inertia_[i]) * load.torque);
            Motion<D> const now{first.velocity(before.velocity + kick), first.spin(before.spin + turn)};
            g.half[i] = now;
            if (predicts) g.motion[i] = {second.velocity(now.velocity) + kick, second.spin(now.spin) + turn};
            Vec<D> const step = dt * now.velocity;
            g.place[i].centre += step;
            Vec<D> const since = g.place[i].centre - state_.built[i];
            moved += !(dot(since, since) <= near);  // also true for a number that is not finite
            fast += !(dot(step, step) <= far);
        }
        if (moved > 0) any_moved = true;
        if (fast > 0) any_fast = true;
    });
    sluice::require(!any_fast, [&] {
        std::size_t i = 0;
        while (dt * norm(g.half[i].velocity) <= smallest_radius_) ++i;
        return sluice::Error("dem: grain " + std::to_string(g.id[i]) +
                                 " moves by more than the smallest radius in one step, at t = " +
                                 std::to_string(state_.time) + " s, step " + std::to_string(state_.steps) +
                                 " (contacts would be missed). Try a smaller step, or look for overlaps at the start.",
                             sluice::Exit::numerical);
    });
    for (std::size_t w = 0; w < setup_.walls.size(); ++w)
        if (setup_.walls[w].motion.moves()) state_.walls[w].shift = setup_.walls[w].motion.shift(state_.time + dt);
    rebuild_if(any_moved || walls_have_moved());
    find_feet(setup_, state_, dt);
}

//! Builds the lists anew, on all processes if it is time on one; those that sleep are left out again.
template <int D>
void Solver<D>::rebuild_if(bool late)
{
    if (domain_) {
        if (!domain_->any(late)) return;
        domain_->rebuild(setup_, state_);
        derive();
    } else if (late) {
        take_back(setup_, state_);
        rebuild_lists(setup_, state_);
        put_aside(setup_, state_);
    }
}

//! Moves the images of the cell; the work of the first half of the step is booked.
template <int D>
void Solver<D>::move_cell(double dt)
{
    if (!setup_.periodic.is_sheared()) return;
    bool const follows = setup_.periodic.shear.pressure > 0.0;
    double stress = follows ? stress_across(setup_, state_) : 0.0;
    if (follows && domain_) stress = domain_->sum(stress);
    advance_cell(setup_.periodic, state_.cell, dt, stress);
    if (setup_.features.ledger) state_.booked.wall_work += 0.5 * dt * pulling_power(setup_.periodic, state_.cell);
}

//! The work of moving images in the second half of the step, and what the grains that were put back have gained: their
//! places and velocities changed, and of the pull those see that they had not crossed.
template <int D>
void Solver<D>::book_cell(double dt)
{
    Grains<D> const& g = state_.grains;
    Vec<D> const gravity = setup_.gravity_at(state_.time);
    double work = 0.5 * dt * pulling_power(setup_.periodic, state_.cell);
    for (auto const& [i, moved, sped] : state_.crossings) {
        work += g.mass[i] * (dot(g.motion[i].velocity - 0.5 * sped, sped) - dot(gravity, moved));
        work -= 0.5 * dt * dot(g.contact[i].force, sped);
    }
    state_.booked.wall_work += work;
}

template <int D>
template <class Half>
void Solver<D>::kick(double dt, Half const& second)
{
    auto const load_on = loads();
    auto const* const asleep = state_.rest.is_apart() ? state_.rest.asleep.data() : nullptr;
    share([&, second](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i)
            if (!asleep || asleep[i] == 0U) state_.grains.motion[i] = kicked(dt, second, i, load_on(i));
    });
}

//! The work of what is not elastic, by the trapezium of its power at full steps: with velocity Verlet this is the work
//! that changed the kinetic energy, up to a term dt^2 F^2 / (8 m) that does not grow. The external force is constant
//! over a step.
template <int D>
void Solver<D>::book_step(double dt)
{
    Grains<D> const& g = state_.grains;
    LossyPower const before = state_.power;
    evaluate_power();
    LossyPower const& now = state_.power;
    state_.booked.normal_dashpot += 0.5 * dt * (before.normal + now.normal);
    state_.booked.tangential_dashpot += 0.5 * dt * (before.tangential + now.tangential);
    state_.booked.sliding += 0.5 * dt * (before.sliding + now.sliding);
    state_.booked.rolling += 0.5 * dt * (before.rolling + now.rolling);
    if (setup_.field_changes(state_.time)) state_.booked.field_work += work_of_field(dt);
    if (!setup_.loads) return;
    double power = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i)
        if (!g.is_ghost(i))
            power += dot(g.external[i].force, g.half[i].velocity) + dot(g.external[i].torque, g.half[i].spin);
    state_.booked.external_work += dt * power;
}

//! In a step in which gravity or the frame's rate changes: of their potentials, which then change in themselves, and of
//! the Euler acceleration. By the middle of the step.
template <int D>
double Solver<D>::work_of_field(double dt) const
{
    Grains<D> const& g = state_.grains;
    double const now = state_.time;
    double work = 0.0;
    Vec<D> const heavier = setup_.gravity_at(now + dt) - setup_.gravity_at(now);
    for (std::size_t i = 0; i < g.size(); ++i)
        if (!g.is_ghost(i)) work -= g.mass[i] * dot(heavier, g.place[i].centre - 0.5 * dt * g.half[i].velocity);
    if (!setup_.frame) return work;
    auto const& frame = *setup_.frame;
    auto const pull = frame.centrifugal(now), later = frame.centrifugal(now + dt), push = frame.euler(now, now + dt);
    Spin<D> const twist = spin_of<D>(frame.spin_rate(now, now + dt), frame.direction());
    Vec<D> const axis = point_of_axis(frame);
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (g.is_ghost(i)) continue;
        auto const& [velocity, spin] = g.half[i];
        Vec<D> const r = g.place[i].centre - 0.5 * dt * velocity - axis;
        work -= 0.5 * setup_.weight * g.mass[i] * dot(r, times(later, r) - times(pull, r));
        work += dt * (g.mass[i] * dot(times(push, r), velocity) + g.inertia[i] * dot(twist, spin));
    }
    return work;
}

//! Whether nobody looks at velocities between the step that begins now and the next.
template <int D>
bool Solver<D>::kick_can_wait(double dt) const
{
    bool const gate = std::ranges::any_of(setup_.walls, [&](Wall<D> const& wall) {
        return wall.removed_at > state_.time && wall.removed_at <= state_.time + 2.0 * dt;
    });
    return !gate && !setup_.features.ledger && !setup_.sleep.any() && !setup_.periodic.is_sheared() && !domain_;
}

//! `halves(t)`: what acts in the halves of a step that begins at t.
template <int D>
template <class Half, class Halves>
void Solver<D>::advance(double dt, std::int64_t count, Halves const& halves)
{
    std::optional<Half> due;  // the kick that ends the last step, to be done in one go with the next step's first
    for (; count > 0; --count) {
        remove_walls(state_.time + 0.5 * dt);  // a removal time belongs to the nearest step
        if (setup_.sleep.any()) let_sleep();
        move_cell(dt);
        bool const waits = count > 1 && kick_can_wait(dt);
        auto const [first, second] = halves(state_.time);
        drift(dt, due, first, second);
        evaluate(dt);
        due.reset();
        if (waits)
            due.emplace(second);
        else
            kick(dt, second);
        if (domain_) domain_->refresh(state_.grains);
        if (setup_.features.ledger) {
            book_step(dt);
            if (setup_.features.periodic) book_cell(dt);
        }
        state_.crossings.clear();
        state_.time += dt;
        ++state_.steps;
    }
}

template <int D>
void Solver<D>::steps(double dt, std::int64_t count)
{
    std::optional<sluice::Team::Awake> awake;
    if (team_) awake.emplace(*team_);
    if (setup_.frame)
        advance<TurningHalf<D>>(dt, count, [&](double now) {
            return std::pair{TurningHalf<D>(setup_, now, now, dt),
                             TurningHalf<D>(setup_, now + 0.5 * dt, now + dt, dt)};
        });
    else
        advance<StillHalf<D>>(dt, count, [&](double now) {
            return std::pair{StillHalf<D>{0.5 * dt * setup_.gravity_at(now)},
                             StillHalf<D>{0.5 * dt * setup_.gravity_at(now + dt)}};
        });
}

template <int D>
void Solver<D>::set_laws(Setup<D> const& from)
{
    setup_.gravity = from.gravity;
    setup_.frame = from.frame;
    setup_.law = from.law;
    for (std::size_t w = 0; w < setup_.walls.size(); ++w) setup_.walls[w].law = from.walls[w].law;
    evaluate_again();
}

template <int D>
void Solver<D>::restore(State<D> state)
{
    state_ = std::move(state);
    if (domain_) domain_->distribute(setup_, state_);
    derive();
    find_feet(setup_, state_, 0.0);
}

template struct Grains<2>;
template struct Grains<3>;
template class Solver<2>;
template class Solver<3>;

}  // namespace dem
