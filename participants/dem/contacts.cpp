#include "participants/dem/contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "participants/dem/contact.hpp"

namespace dem {
namespace {

//! Gives a grain its share of a fresh contact's impulse; `sign` is +1 for i, -1 for j.
template <int D>
void push(Grains<D>& g, std::size_t i, double sign, double arm, Contact<D> const& c, Forces<D> const& f) noexcept
{
    g.half[i].velocity += (sign / g.mass[i]) * (f.impulse_n * c.normal - vector_of(f.impulse_t, c.normal));
    g.half[i].spin = g.half[i].spin + (arm / g.inertia[i]) * torque_of(f.impulse_t, c.normal);
}

template <Features F, int D>
Memory<D> memory_of(History<D> const& history, std::size_t at) noexcept
{
    Memory<D> m;
    if constexpr (F.friction) m.friction = history.friction[at];
    if constexpr (F.rolling == Rolling::elastic_plastic) m.rolling = history.rolling[at];
    return m;
}
template <Features F, int D>
void remember(History<D>& history, std::size_t at, Memory<D> const& m) noexcept
{
    if constexpr (F.friction) history.friction[at] = m.friction;
    if constexpr (F.rolling == Rolling::elastic_plastic) history.rolling[at] = m.rolling;
}

//! Turns the memory of a contact with it (space only). LIGGGHTS only projects it.
template <Features F, int D>
void carry(Memory<D>& m, Contact<D> const& c, double dt, Motion<D> const& hi, Motion<D> const& hj) noexcept
{
    if constexpr (D == 3 && F.friction) {
        if constexpr (F.scheme == Scheme::liggghts) {
            m.friction = along(m.friction, c.normal);
        } else {
            double const twist = dt * twist_of(hi.spin, hj.spin, c.normal);
            m.friction = carried(m.friction, c.normal, twist);
            if constexpr (F.rolling == Rolling::elastic_plastic) m.rolling = carried(m.rolling, c.normal, twist);
        }
    }
}

//! The laws on one listed contact that touches. Returns what acts; writes the history.
template <Features F, int D, class Turning>
Forces<D> act(ContactLaw const& law, Contact<D> const& c, double overlap, double sqrt_mass, double dt,
              Motion<D> const& vi, Motion<D> const& vj, Motion<D> const& hi, Motion<D> const& hj, Turning&& turning,
              History<D>& history, std::size_t at, Books& books) noexcept
{
    auto const touching = touching_of<F>(c, overlap, sqrt_mass, dt, vi, vj, hi, hj);
    Memory<D> memory = memory_of<F>(history, at);
    carry<F>(memory, c, dt, hi, hj);
    Forces<D> const f = contact_forces<F>(law, dt, touching, turning, memory, books);
    remember<F>(history, at, memory);
    if constexpr (F.ledger) history.lossy[at] = f.lossy;
    return f;
}

//! Forgets a listed contact that does not touch.
template <Features F, int D>
void forget(ContactLaw const& law, Contact<D> const& c, double overlap, double dt, Motion<D> const& hi,
            Motion<D> const& hj, History<D>& history, std::size_t at, Books& books) noexcept
{
    if constexpr (F.ledger) {
        Memory<D> const memory = memory_of<F>(history, at);
        book_opening<F>(law, c, overlap, dt * c.closing(hi, hj), dt * c.slip(hi, hj), memory, books);
        history.lossy[at] = {};
    }
    remember<F>(history, at, Memory<D>{});
}

template <Features F, int D>
void add_pair_forces(Setup<D> const& setup, State<D>& state, double dt) noexcept
{
    Grains<D>& g = state.grains;
    Pairs<D>& pairs = state.pairs;
    ContactLaw const law = setup.law;
    auto const& late = F.scheme == Scheme::liggghts ? g.half : g.motion;
    Books books;
    for (std::size_t i = 0; i < g.size(); ++i) {
        Place<D> const pi = g.place[i];
        Motion<D> const vi = late[i], hi = g.half[i];
        Load<D> sum;
        std::uint32_t const end = pairs.first[i + 1];
        for (std::uint32_t slot = pairs.first[i]; slot < end; ++slot) {
            std::size_t const j = pairs.other[slot];
            Vec<D> const apart = pi.centre - g.place[j].centre;
            double const reach = pi.radius + g.place[j].radius, square = dot(apart, apart);
            if (square >= reach * reach) {
                double const distance = F.ledger ? std::sqrt(square) : 0.0;
                forget<F>(law, contact_of<D>(apart, distance, pi.radius, g.place[j].radius), reach - distance, dt, hi,
                          g.half[j], pairs.history, slot, books);
                continue;
            }
            double const distance = std::sqrt(square);
            Contact<D> c = contact_of<D>(apart, distance, pi.radius, g.place[j].radius);
            if constexpr (F.scheme == Scheme::liggghts) shorten_arms(c, pi.radius, g.place[j].radius, reach - distance);
            auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i] + c.arm_j * c.arm_j / g.inertia[j]; };
            Forces<D> const f = act<F>(law, c, reach - distance, pairs.sqrt_mass[slot], dt, vi, late[j], hi, g.half[j],
                                       turning, pairs.history, slot, books);
            if (f.fresh) [[unlikely]] {
                push(g, i, 1.0, c.arm_i, c, f);
                push(g, j, -1.0, c.arm_j, c, f);
            }
            Vec<D> const force = f.normal * c.normal - vector_of(f.tangential, c.normal);
            sum.force += force;
            g.contact[j].force -= force;
            if constexpr (F.friction) {
                auto const torque = torque_of(f.tangential, c.normal);
                sum.torque = sum.torque + c.arm_i * torque;
                g.contact[j].torque = g.contact[j].torque + c.arm_j * torque;
            }
            if constexpr (F.rolling != Rolling::none) {
                auto const torque = c.effective * torque_of(f.rolling, c.normal);
                sum.torque = sum.torque - torque;
                g.contact[j].torque = g.contact[j].torque + torque;
            }
        }
        g.contact[i].force += sum.force;
        g.contact[i].torque = g.contact[i].torque + sum.torque;
    }
    if constexpr (F.ledger) books.add_to(state.booked);
}

template <Features F, int D, class AnyShape>
void add_wall_forces(AnyShape const& shape, Wall<D> const& wall, State<D>& state, WallContacts<D>& contacts, double dt,
                     bool absolute_damping) noexcept
{
    Grains<D>& g = state.grains;
    auto const& late = F.scheme == Scheme::liggghts ? g.half : g.motion;
    Motion<D> half{}, motion{};
    if (wall.motion.moves()) {
        contacts.velocity = wall.motion.speed(state.time + dt);
        if (dt > 0.0) half.velocity = (1.0 / dt) * (contacts.shift - wall.motion.shift(state.time));
        motion.velocity = F.scheme == Scheme::liggghts ? half.velocity : contacts.velocity;
    }
    Vec<D> total;
    Books books;
    for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
        std::size_t const i = contacts.grain[k];
        double const radius = g.place[i].radius;
        Facing<D> const at = shape.facing(g.place[i].centre - contacts.shift, contacts.facet[k]);
        Contact<D> c = contact_with_wall<D>(at.normal, radius);
        double const overlap = radius - at.distance;
        if constexpr (F.scheme == Scheme::liggghts) shorten_arms(c, radius, 0.0, overlap);
        if (overlap <= 0.0) {
            forget<F>(wall.law, c, overlap, dt, g.half[i], half, contacts.history, k, books);
            continue;
        }
        auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i]; };
        double const sqrt_mass = absolute_damping ? 1.0 : std::sqrt(g.mass[i]);
        Forces<D> const f = act<F>(wall.law, c, overlap, sqrt_mass, dt, late[i], motion, g.half[i], half, turning,
                                   contacts.history, k, books);
        if (f.fresh) [[unlikely]]
            push(g, i, 1.0, c.arm_i, c, f);
        Vec<D> const force = f.normal * c.normal - vector_of(f.tangential, c.normal);
        g.contact[i].force += force;
        total += force;
        if constexpr (F.friction)
            g.contact[i].torque = g.contact[i].torque + c.arm_i * torque_of(f.tangential, c.normal);
        if constexpr (F.rolling != Rolling::none)
            g.contact[i].torque = g.contact[i].torque - c.effective * torque_of(f.rolling, c.normal);
    }
    if constexpr (F.ledger) {
        books.add_to(state.booked);
        state.booked.wall_work += 0.5 * dt * dot(contacts.force + total, half.velocity);
    }
    contacts.force = total;
}

template <Features F, int D>
void evaluate_contacts(Setup<D> const& setup, State<D>& state, double dt) noexcept
{
    std::fill(state.grains.contact.begin(), state.grains.contact.end(), Load<D>{});
    add_pair_forces<F>(setup, state, dt);
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        std::visit(
            [&](auto const& shape) {
                add_wall_forces<F>(shape, setup.walls[w], state, state.walls[w], dt, setup.absolute_damping);
            },
            setup.walls[w].shape);
}

//! All sets of features that are compiled: friction and rolling go together, LIGGGHTS' order has no ledger.
constexpr auto compiled = [] {
    std::array<Features, 20> all{};
    std::size_t n = 0;
    for (auto const elasticity : {Elasticity::linear, Elasticity::hertz})
        for (bool const ledger : {false, true}) {
            all[n++] = {.elasticity = elasticity, .ledger = ledger};
            for (auto const rolling : {Rolling::none, Rolling::elastic_plastic, Rolling::constant})
                all[n++] = {.elasticity = elasticity, .friction = true, .rolling = rolling, .ledger = ledger};
        }
    for (auto const elasticity : {Elasticity::linear, Elasticity::hertz})
        for (auto const rolling : {Rolling::none, Rolling::constant})
            all[n++] = {.elasticity = elasticity, .friction = true, .rolling = rolling, .scheme = Scheme::liggghts};
    return all;
}();

template <int D, std::size_t... I>
Evaluate<D> find(Features const& wanted, std::index_sequence<I...>) noexcept
{
    Evaluate<D> found = nullptr;
    ((compiled[I] == wanted ? found = &evaluate_contacts<compiled[I], D> : found), ...);
    return found;
}

}  // namespace

template <int D>
Evaluate<D> evaluation_for(Features const& features) noexcept
{
    return find<D>(features, std::make_index_sequence<compiled.size()>());
}
template Evaluate<DEM_DIMENSION> evaluation_for<DEM_DIMENSION>(Features const&) noexcept;

}  // namespace dem
