#include "participants/mpm/solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/mpm/cell_means.hpp"
#include "participants/mpm/parallelepiped.hpp"
#include "participants/mpm/room.hpp"
#include "participants/mpm/walls.hpp"

namespace mpm {
namespace {

using sluice::Error;
using sluice::Exit;
using sluice::require;

template <int D>
std::string text_of(Vec<D> const& v)
{
    char text[120];
    if constexpr (D == 2)
        std::snprintf(text, sizeof text, "(%g, %g)", v[0], v[1]);
    else
        std::snprintf(text, sizeof text, "(%g, %g, %g)", v[0], v[1], v[2]);
    return text;
}

template <int D>
std::array<bool, D> joined_axes(Setup<D> const& setup)
{
    std::array<bool, D> joined;
    for (std::size_t a = 0; a < D; ++a) joined[a] = setup.period[static_cast<int>(a)] > 0;
    return joined;
}

std::string number(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

}  // namespace

template <int D>
void require_shareable(Setup<D> const& setup, std::size_t points, int processes)
{
    if (processes == 1) return;
    require(PackedStep<D>::serves(setup), [&] {
        return Error("mpm: " + std::to_string(processes) +
                     " processes with what goes one point at a time: basis: linear or cpdi, width: stretch, law: "
                     "neo_hookean, or symmetry: axial with scheme: usl or affine: false (needed: none of them, or "
                     "ranks: 1).");
    });
    require_chunks(points, processes);
}

template <int D>
Solver<D>::Solver(Setup<D> setup, State<D> state, ranks::Peers* peers)
    : setup_(std::move(setup)),
      state_(std::move(state)),
      peers_(peers),
      packed_(1, peers),
      grid_(setup_.cells, joined_axes(setup_), rings_of_nodes(setup_.basis, D)),
      transfer_(&transfer_of<D>(setup_.basis)),
      increments_(state_.points.size())
{
    require(setup_.walls.size() <= most_walls, [&] {
        return Error("mpm: " + std::to_string(setup_.walls.size()) + " walls and gates (at most " +
                     std::to_string(most_walls) + ").");
    });
    if (peers_) require_shareable(setup_, state_.points.size(), peers_->count());
    for (Point<D> const& p : state_.points) {
        require(contains(p.place), [&] {
            return Error("mpm: point " + std::to_string(p.id) + " starts at " + text_of<D>(p.place) +
                         " m, outside the domain (must be inside).");
        });
        for (Wall const& w : setup_.walls)
            require(w.removed_at <= state_.time || w.side * (p.place[w.axis] - w.place) <= 0, [&] {
                return Error("mpm: point " + std::to_string(p.id) + " starts at " + text_of<D>(p.place) +
                             " m, behind a wall or gate at " + number(w.place) + " m (must be on its free side).");
            });
    }
    for (Point<D> const& p : state_.points)
        for (Plate<D> const& plate : setup_.plates)
            require(plate.removed_at <= state_.time ||
                        (p.place - plate.point - plate.motion.shift(state_.time)).dot(plate.normal) > 0,
                    [&] {
                        return Error("mpm: point " + std::to_string(p.id) + " starts at " + text_of<D>(p.place) +
                                     " m, behind a plate (must be where its normal points to).");
                    });
    find_speed();
}

template <int D>
double Solver<D>::limit() const
{
    double fastest = std::max(speed_, grains_.speed());
    for (Plate<D> const& plate : setup_.plates) fastest = std::max(fastest, plate.motion.speed(state_.time).norm());
    return setup_.cell / fastest;
}

template <int D>
bool Solver<D>::contains(Vec<D> const& place) const
{
    auto const [low, high] = room_of(setup_);
    return (place.array() >= low.array()).all() && (place.array() <= high.array()).all();
}

template <int D>
void Solver<D>::set_gravity(Vec<D> const& gravity)
{
    setup_.gravity = gravity;
}

template <int D>
void Solver<D>::restore(State<D> state, std::optional<double> speed)
{
    state_ = std::move(state);
    packed_has_points_ = first_is_behind_ = others_are_behind_ = false;
    increments_.resize(state_.points.size());
    if (speed)
        speed_ = *speed;
    else
        find_speed();
}

template <int D>
std::string Solver<D>::where(Point<D> const& p) const
{
    return "mpm: t = " + number(state_.time) + " s: point " + std::to_string(p.id) + " at " + text_of<D>(p.place) +
           " m: ";
}

template <int D>
void Solver<D>::step(double dt)
{
    double const longest = largest_courant * limit();
    require(dt > 0 && dt <= (1 + 1e-9) * longest, [&] {
        return Error("mpm: t = " + number(state_.time) + " s: step = " + number(dt) + " s (must be at most " +
                         number(longest) + " s, " + number(largest_courant) + " cells at " +
                         number(setup_.cell / limit()) + " m/s). Try step: auto.",
                     Exit::numerical);
    });
    if (!setup_.plates.empty()) grains_.set_plates(plates_at(setup_, state_.time, dt));
    if (step_packed(dt)) return;
    step_plain(dt);
}

template <int D>
void Solver<D>::use_threads(int threads)
{
    leave_packed();
    packed_ = PackedStep<D>(threads, peers_);
}

template <int D>
void Solver<D>::write_points(Whom whom) const
{
    bool const behind = whom == Whom::first ? first_is_behind_ : others_are_behind_;
    if (behind) packed_.give(setup_, state_, whom);
    first_is_behind_ = false;
    if (whom == Whom::all || !peers_) others_are_behind_ = false;
}

//! All have the points as they are, to work on.
template <int D>
void Solver<D>::leave_packed()
{
    write_points(Whom::all);
    packed_has_points_ = false;
}

//! Returns whether it did the step.
template <int D>
bool Solver<D>::step_packed(double dt)
{
    if (!PackedStep<D>::serves(setup_)) return false;
    if (!packed_has_points_) packed_.take(state_);
    packed_has_points_ = true;
    if (state_.steps % PackedStep<D>::sorted_every == 0) {
        packed_.sort(setup_);
        first_is_behind_ = others_are_behind_ = true;  // even if it can do no more: the order is part of the state
    }
    typename PackedStep<D>::Outcome o;
    if (!packed_.step(setup_, state_.time, dt, loads_, grains_, o)) return false;
    first_is_behind_ = others_are_behind_ = true;
    state_.time += dt;
    ++state_.steps;
    if (!o.all_inside) check_places();
    if (!o.all_upright) check_upright();
    speed_ = o.speed;
    nodes_reached_ = o.nodes;
    light_nodes_ += o.light_nodes;
    Booked& booked = state_.booked;
    booked.plastic += o.booked.plastic;
    booked.sliding += o.booked.sliding;
    booked.damping += o.booked.damping;
    booked.external_work += o.booked.external_work;
    booked.field_work += o.booked.field_work;
    booked.numerical += o.kinetic_before - o.kinetic_after + o.field - o.stress + o.booked.external_work -
                        o.booked.sliding - o.booked.damping;
    return true;
}

template <int D>
void Solver<D>::step_plain(double dt)
{
    leave_packed();
    places_.clear();
    for (Point<D> const& p : state_.points) places_.push_back(p.place);
    double const kinetic = kinetic_energy(state_);
    bool const changes = setup_.frame && setup_.frame->changes(state_.time);
    double const potential = changes ? potential_energy(setup_, state_, state_.time) : 0;
    Field<D> const field(setup_, state_.time, dt);
    Booked const before = state_.booked;
    grid_.clear();
    transfer_->to_grid(setup_, state_, loads_, shifts_of_stress(), grid_);
    move_nodes(field, dt);
    if (grains_.any()) touch_grains(dt);
    hold_nodes(dt);
    nodes_reached_ = static_cast<std::size_t>(
        std::count_if(grid_.nodes().begin(), grid_.nodes().end(), [](auto const& node) { return node.mass > 0; }));
    transfer_->to_points(setup_, field, state_, grid_, dt);
    set_strain_velocities();
    transfer_->gradients(setup_, state_, places_, grid_, dt, increments_);
    if (setup_.shared_volume) share_volume();
    if (setup_.affine)  // v* = slope x(n) = slope (I + dt slope)^-1 x(n+1)
        for (Point<D>& p : state_.points) {
            p.slope = (p.slope * (Mat<D>::Identity() + dt * p.slope).inverse()).eval();
            if (p.matter.gap > loose<D>) p.slope = (0.5 * (p.slope - p.slope.transpose())).eval();
        }
    state_.time += dt;
    ++state_.steps;
    bring_round();
    check_places();
    double const work = deform(dt), fallen = work_of_field(field);
    find_speed();
    Booked& booked = state_.booked;
    if (changes) booked.field_work += potential_energy(setup_, state_, state_.time) - potential + fallen;
    booked.numerical += kinetic - kinetic_energy(state_) + fallen - work +
                        (booked.external_work - before.external_work) - (booked.sliding - before.sliding) -
                        (booked.damping - before.damping);
}

//! Velocities of the nodes after forces and damping.
template <int D>
void Solver<D>::move_nodes(Field<D> const& field, double dt)
{
    Booked& booked = state_.booked;
    double const kept = std::exp(-setup_.damping * dt);
    for (Node<D>& node : grid_.nodes()) {
        if (node.mass <= 0) continue;
        node.before = node.momentum / node.mass;
        Vec<D> v = (node.inner + node.outer) / node.mass;
        if (setup_.frame) {
            Vec<D> const half = 0.5 * dt * (v + field.acceleration(corner_of<D>(setup_, node.index)));
            v = field.turned(node.before + half) + half;
            node.before = field.turned(node.before);
        } else {
            v = node.before + dt * (v + setup_.gravity);
        }
        booked.external_work += 0.5 * dt * node.outer.dot(node.before + v);
        node.velocity = kept * v;
    }
}

//! ... and grains
template <int D>
void Solver<D>::touch_grains(double dt)
{
    grains_.begin(setup_);
    for (Point<D> const& p : state_.points)
        if (grains_.is_near(setup_, p.place)) grains_.consider(setup_, dt, p.id, p.place, p.matter.ratio);
    for (TouchedNode<D>& touched : grains_.nodes()) {
        Node<D> const& node = grid_.reach(touched.index);
        touched.mass = node.mass, touched.before = node.before, touched.velocity = node.velocity;
    }
    grains_.solve(setup_, state_.time, dt, state_.booked);
    for (TouchedNode<D> const& touched : grains_.nodes()) grid_.reach(touched.index).velocity = touched.velocity;
}

//! ... and walls. Work of friction: its impulse times the mean of the velocities at the ends of the step; a node that
//! sticks makes none. Damping takes energy of what walls leave: they do the same to all multiples of a velocity, so
//! that it may as well act after them.
template <int D>
void Solver<D>::hold_nodes(double dt)
{
    double const damped = 0.5 * std::expm1(2 * setup_.damping * dt);  // of mass x the square of what is left
    for (Node<D>& node : grid_.nodes()) {
        if (node.mass <= 0) continue;
        Vec<D> v = node.velocity;
        for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
            Wall const& wall = setup_.walls[w];
            if (wall.removed_at <= state_.time || !holds<D>(wall, setup_, node.index)) continue;
            Vec<D> rubbed = v;
            node.grip[w] = hold<D>(wall, v);
            if (wall.kind != WallKind::rough) continue;
            rubbed -= v;
            rubbed[wall.axis] = 0;
            state_.booked.sliding += 0.5 * node.mass * rubbed.dot(node.before + v);
        }
        node.velocity = v;
        state_.booked.damping += damped * node.mass * v.squaredNorm();
    }
}

//! Points that have left by a joined side come in at the other one. The potential that they have there is what the
//! field has done on their way round.
template <int D>
void Solver<D>::bring_round()
{
    for (int a = 0; a < D; ++a) {
        double const length = setup_.period[a];
        if (!(length > 0)) continue;
        for (Point<D>& p : state_.points) {
            double const round = -length * std::floor((p.place[a] - setup_.origin[a]) / length);
            if (round == 0) continue;
            p.place[a] += round;
            state_.booked.field_work -= p.mass * setup_.gravity[a] * round;
        }
    }
}

template <int D>
double Solver<D>::work_of_field(Field<D> const& field) const
{
    double sum = 0;
    for (std::size_t p = 0; p < places_.size(); ++p) {
        Vec<D> const way = setup_.arm(places_[p], state_.points[p].place);
        sum += state_.points[p].mass * field.acceleration(places_[p] + 0.5 * way).dot(way);
    }
    return sum;
}

//! A node of almost no mass gets any acceleration: the points near it feel it times its weight, which is bounded, but
//! its gradient would be felt as strain. Strain sees such a node at the velocity that the points brought.
template <int D>
void Solver<D>::set_strain_velocities()
{
    bool const musl = setup_.scheme == Scheme::musl;
    double const least = light_mass(setup_);
    if (musl) transfer_->back_to_grid(setup_, state_, places_, grid_);
    for (Node<D>& node : grid_.nodes()) {
        bool const is_light = node.mass < least;
        light_nodes_ += is_light && node.mass > 0;
        if (node.mass <= 0) continue;
        if (!musl) {
            node.strain_velocity = is_light ? node.before : node.velocity;
            continue;
        }
        node.strain_velocity /= node.mass;
        for (std::size_t w = 0; w < setup_.walls.size(); ++w)
            hold_again<D>(setup_.walls[w].axis, node.grip[w], node.strain_velocity);
    }
}

//! What lies between the mean stress of a point, of its D x D part, of a ring the whole, and that of its cell [Pa].
template <int D>
std::vector<double> Solver<D>::shifts_of_stress() const
{
    std::vector<double> own;
    if (!setup_.shared_volume) return own;
    int const shared = setup_.symmetry == Symmetry::axial ? 3 : D;
    for (Point<D> const& p : state_.points) own.push_back(p.matter.stress.diagonal().head(shared).mean());
    std::vector<double> shifts = cell_means<D>(setup_, state_, places_, own);
    for (std::size_t p = 0; p < own.size(); ++p) shifts[p] -= own[p];
    return shifts;
}

template <int D>
void Solver<D>::share_volume()
{
    std::vector<double> own;
    int const part = setup_.symmetry == Symmetry::axial ? 3 : D;
    for (Mat3 const& increment : increments_) own.push_back(increment.determinant());
    std::vector<double> const shared = cell_means<D>(setup_, state_, places_, own);
    for (std::size_t p = 0; p < own.size(); ++p)
        if (own[p] > 0 && shared[p] > 0)
            increments_[p].topLeftCorner(part, part) *= std::pow(shared[p] / own[p], 1.0 / part);
}

//! Returns the work that the stress did in it [J].
template <int D>
double Solver<D>::deform(double dt)
{
    double work = 0;
    auto const each = [&](auto const& law) {
        for (std::size_t p = 0; p < increments_.size(); ++p) {
            Point<D>& point = state_.points[p];
            Mat3 const& change = increments_[p];
            Increment const step(change, dt);
            double const ratio = point.matter.ratio * step.ratio, volume = point.volume_now();
            Mat3 const old = step.turned(point.matter.stress);
            point.matter.gradient = change * point.matter.gradient;
            point.matter.ratio = ratio;
            if (!(ratio > 0 && std::isfinite(ratio))) check_upright();
            state_.booked.plastic += point.volume_now() * law.respond(point.matter, step);
            work += 0.25 * (volume + point.volume_now()) * contract(old + point.matter.stress, step.strain);
        }
    };
    std::visit(each, setup_.law);
    return work;
}

template <int D>
void Solver<D>::check_upright() const
{
    write_points(Whom::all);
    for (Point<D> const& p : state_.points)
        require(p.matter.ratio > 0 && std::isfinite(p.matter.ratio), [&] {
            return Error(
                where(p) + "J = " + number(p.matter.ratio) + " (must be above 0). Try a shorter step or a finer cell.",
                Exit::numerical);
        });
}

template <int D>
void Solver<D>::check_places() const
{
    write_points(Whom::all);
    for (Point<D> const& p : state_.points) {
        if (contains(p.place)) continue;
        char const* const seen = p.place.allFinite() ? "has left the domain (must stay inside). Try a larger one."
                                                     : "its place is not a number. Try a shorter step.";
        throw Error(where(p) + seen, Exit::numerical);
    }
}

template <int D>
void Solver<D>::find_speed()
{
    speed_ = 0;
    std::visit(
        [&](auto const& law) {
            for (Point<D> const& p : state_.points) {
                double const wave = law.wave_modulus(p.matter) * p.volume_now() / p.mass;
                speed_ = std::max(speed_, std::sqrt(wave) + p.velocity.norm());
            }
        },
        setup_.law);
}

template void require_shareable<2>(Setup<2> const&, std::size_t, int);
template void require_shareable<3>(Setup<3> const&, std::size_t, int);
template class Solver<2>;
template class Solver<3>;

}  // namespace mpm
