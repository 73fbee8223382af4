#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "participants/dem/contact.hpp"
#include "participants/dem/lossy_loads.hpp"

//! One listed contact of a run: its laws, its history, and what it adds to the grains.
namespace dem {

//! What a fresh contact gives to i besides its forces [N s].
template <int D>
Vec<D> impulse_of(Contact<D> const& c, Forces<D> const& f) noexcept
{
    return f.impulse_n * c.normal - vector_of(f.impulse_t, c.normal);
}

//! A grain's share of a fresh contact's impulse; `sign` is +1 for i, -1 for j.
template <int D>
Push<D> push(Grains<D> const& g, std::size_t i, double sign, double arm, Contact<D> const& c,
             Forces<D> const& f) noexcept
{
    Motion<D> motion{};
    motion.velocity = (sign / g.mass[i]) * impulse_of(c, f);
    motion.spin = (arm / g.inertia[i]) * torque_of(f.impulse_t, c.normal);
    return {static_cast<std::uint32_t>(i), motion};
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
[[gnu::always_inline]] inline Forces<D> act(ContactLaw const& law, Contact<D> const& c, double overlap,
                                            double sqrt_mass, double dt, Motion<D> const& vi, Motion<D> const& vj,
                                            Motion<D> const& hi, Motion<D> const& hj, Turning&& turning,
                                            History<D>& history, std::size_t at, Books& books) noexcept
{
    auto const touching = touching_of<F>(c, overlap, sqrt_mass, dt, vi, vj, hi, hj);
    Memory<D> memory = memory_of<F>(history, at);
    carry<F>(memory, c, dt, hi, hj);
    Forces<D> const f = contact_forces<F>(law, dt, touching, turning, memory, books);
    remember<F>(history, at, memory);
    return f;
}

//! Forgets a listed contact that does not touch.
template <Features F, int D>
void forget(ContactLaw const& law, Contact<D> const& c, double overlap, double dt, Motion<D> const& hi,
            Motion<D> const& hj, History<D>& history, std::size_t at, Books& books) noexcept
{
    if constexpr (F.ledger) {
        Memory<D> const memory = memory_of<F>(history, at);
        book_opening<F>(law, c, overlap, dt * c.closing(hi, hj), dt * c.slip(hi, hj), dt * c.roll(hi, hj), memory,
                        books);
    }
    remember<F>(history, at, Memory<D>{});
}

//! What a contact adds to its two grains: the force on i, the opposite on j, and torques.
template <int D>
struct PairLoad
{
    Vec<D> force;
    Spin<D> on_i = {}, on_j = {};
    LossyLoad<D> lossy = {};  //!< with the ledger
};

//! Where the loads of pairs go.
template <int D>
struct Sink
{
    State<D>& state;
    std::vector<Push<D>>& pushes;
    std::vector<SeamLoad<D>>& seams;
    std::uint32_t end = std::numeric_limits<std::uint32_t>::max();  //!< from here on grains get theirs from elsewhere
};

//! The images of the cell; not looked at unless the scene is periodic.
template <int D>
using Images = std::array<Image<D>, image_count<D>>;

//! How the image of a grain moves that a pair sees: as the grain itself unless the scene is periodic.
template <Features F, int D>
decltype(auto) motion_seen(Motion<D> const& of, Pairs<D> const& pairs, std::size_t slot,
                           Images<D> const& images) noexcept
{
    if constexpr (F.periodic) {
        Motion<D> seen = of;
        seen.velocity += images[pairs.image[slot]].velocity;
        return seen;
    } else {
        return (of);
    }
}
template <Features F, int D>
Vec<D> centre_seen(Vec<D> of, Pairs<D> const& pairs, std::size_t slot, Images<D> const& images) noexcept
{
    if constexpr (F.periodic) of += images[pairs.image[slot]].shift;
    return of;
}

//! A listed pair, plainly. Its history is kept, or forgotten if it does not touch; then there is no load. Appends to
//! `pushes`.
template <Features F, int D>
std::optional<PairLoad<D>> load_of_pair(ContactLaw const& law, Grains<D> const& g, Pairs<D>& pairs,
                                        Images<D> const& images, std::size_t i, std::size_t slot, double dt,
                                        Books& books, std::vector<Push<D>>& pushes) noexcept
{
    auto const& late = F.scheme == Scheme::liggghts ? g.half : g.motion;
    std::size_t const j = pairs.other[slot];
    double const ri = g.place[i].radius, rj = g.place[j].radius;
    Vec<D> const apart = g.place[i].centre - centre_seen<F>(g.place[j].centre, pairs, slot, images);
    auto const& half_j = motion_seen<F>(g.half[j], pairs, slot, images);
    double const reach = ri + rj, square = dot(apart, apart);
    if (square >= reach * reach) {
        if constexpr (F.ledger)
            if (Vec<D> const before = apart - dt * (g.half[i].velocity - half_j.velocity);
                dot(before, before) < reach * reach) {
                double const distance = std::sqrt(square);
                forget<F>(law, contact_of<D>(apart, distance, ri, rj), reach - distance, dt, g.half[i], half_j,
                          pairs.history, slot, books);
            }
        remember<F>(pairs.history, slot, Memory<D>{});
        return std::nullopt;
    }
    double const distance = std::sqrt(square);
    Contact<D> c = contact_of<D>(apart, distance, ri, rj);
    if constexpr (F.scheme == Scheme::liggghts) shorten_arms(c, ri, rj, reach - distance);
    auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i] + c.arm_j * c.arm_j / g.inertia[j]; };
    Forces<D> const f =
        act<F>(law, c, reach - distance, pairs.sqrt_mass[slot], dt, late[i],
               motion_seen<F>(late[j], pairs, slot, images), g.half[i], half_j, turning, pairs.history, slot, books);
    if (f.fresh) [[unlikely]] {
        pushes.push_back(push(g, i, 1.0, c.arm_i, c, f));
        pushes.push_back(push(g, j, -1.0, c.arm_j, c, f));
        if constexpr (F.periodic && F.ledger)
            books.wall_work += dot(impulse_of(c, f), images[pairs.image[slot]].velocity);
    }
    PairLoad<D> load{f.normal * c.normal - vector_of(f.tangential, c.normal)};
    if constexpr (F.friction) {
        Spin<D> const torque = torque_of(f.tangential, c.normal);
        load.on_i = c.arm_i * torque;
        load.on_j = c.arm_j * torque;
        if constexpr (F.rolling != Rolling::none) {
            Spin<D> const rolling = c.effective * torque_of(f.rolling, c.normal);
            load.on_i = load.on_i - rolling;
            load.on_j = load.on_j + rolling;
        }
    }
    if constexpr (F.ledger) load.lossy = lossy_load<F>(c, f.lossy);
    return load;
}

//! The same, added to the grains.
template <Features F, int D>
void add_pair(ContactLaw const& law, Sink<D> const& to, std::size_t i, std::size_t slot, double dt,
              Books& books) noexcept
{
    State<D>& state = to.state;
    Grains<D>& g = state.grains;
    std::size_t const j = state.pairs.other[slot];
    auto const found = load_of_pair<F>(law, g, state.pairs, state.cell.images, i, slot, dt, books, to.pushes);
    if (!found) return;
    PairLoad<D> const& load = *found;
    g.contact[i].force += load.force;
    if constexpr (F.friction) g.contact[i].torque = g.contact[i].torque + load.on_i;
    if constexpr (F.ledger) add<F>(state.lossy, i, load.lossy, 1.0, load.lossy.on_i);
    if constexpr (F.periodic)
        if (std::uint32_t const image = state.pairs.image[slot]; image != home<D> && !g.is_ghost(i))
            to.seams.push_back({image, load.force, lossy_forces(load.lossy)});
    if (j >= to.end) return;
    g.contact[j].force -= load.force;
    if constexpr (F.friction) g.contact[j].torque = g.contact[j].torque + load.on_j;
    if constexpr (F.ledger) add<F>(state.lossy, j, load.lossy, -1.0, load.lossy.on_j);
}

}  // namespace dem
