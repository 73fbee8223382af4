#include "participants/dem/contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "participants/dem/listed_contact.hpp"
#include "participants/dem/listed_foot.hpp"
#include "participants/dem/packed_walls.hpp"
#include "participants/dem/shared_contacts.hpp"

namespace dem {
namespace {

template <Features F, int D>
void add_pair_forces(Setup<D> const& setup, State<D>& state, double dt, sluice::Team* team) noexcept
{
    if constexpr (is_packed(F, D)) {
        if (!setup.plain)
            return team ? add_shared_pair_forces<F, true>(setup, state, dt, *team)
                        : add_packed_pair_forces<F>(setup, state, dt);
    }
    return team ? add_shared_pair_forces<F, false>(setup, state, dt, *team)
                : add_plain_pair_forces<F>(setup, state, dt);
}

template <Features F, int D, class AnyShape>
void add_wall_forces(AnyShape const& shape, Setup<D> const& setup, State<D>& state, std::size_t w, double dt) noexcept
{
    Grains<D>& g = state.grains;
    Wall<D> const& wall = setup.walls[w];
    WallContacts<D>& contacts = state.walls[w];
    auto const& late = F.scheme == Scheme::liggghts ? g.half : g.motion;
    Motion<D> half{}, motion{};
    if (wall.motion.moves()) {
        contacts.velocity = wall.motion.speed(state.time + dt);
        if (dt > 0.0) half.velocity = (1.0 / dt) * (contacts.shift - wall.motion.shift(state.time));
        motion.velocity = F.scheme == Scheme::liggghts ? half.velocity : contacts.velocity;
    }
    Vec<D> total;
    Books books;
    LossyForces<D> lossy;
    std::size_t k = 0;
    auto const in_packs = [&] {
        if constexpr (is_packed(F, D) && std::is_same_v<AnyShape, Plane<3>>)
            if (!setup.plain)
                k = add_packed_wall_forces<F>(shape, setup, state, w, half.velocity, motion.velocity, dt,
                                              {total, books, lossy});
    };
    in_packs();
    for (; k < contacts.grain.size(); ++k) {
        std::size_t const i = contacts.grain[k];
        double const radius = g.place[i].radius;
        Facing<D> const at = facing_of(shape, contacts, k, g.place[i].centre);
        Contact<D> c = contact_with_wall<D>(at.normal, radius);
        double const overlap = radius - at.distance;
        if constexpr (F.scheme == Scheme::liggghts) shorten_arms(c, radius, 0.0, overlap);
        if (!is_contact(shape, contacts, k, overlap)) {
            if constexpr (is_mesh<AnyShape>)
                forget_foot<F>(wall.law, radius, dt, g.half[i], half, contacts, k, books);
            else
                forget<F>(wall.law, c, overlap, dt, g.half[i], half, contacts.history, k, books);
            continue;
        }
        auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i]; };
        double const sqrt_mass = setup.absolute_damping ? 1.0 : std::sqrt(g.mass[i]);
        Forces<D> const f = act<F>(wall.law, c, overlap, sqrt_mass, dt, late[i], motion, g.half[i], half, turning,
                                   contacts.history, k, books);
        if constexpr (is_mesh<AnyShape> && F.ledger)
            if (!f.fresh) book_arrival<F>(wall.law, c, overlap, dt, g.half[i], half, contacts.foot[k], books);
        if (f.fresh) [[unlikely]] {
            state.pushes.push_back(push(g, i, 1.0, c.arm_i, c, f));
            if constexpr (F.ledger) books.wall_work += dot(impulse_of(c, f), half.velocity);
        }
        Vec<D> const force = f.normal * c.normal - vector_of(f.tangential, c.normal);
        g.contact[i].force += force;
        total += force;
        if constexpr (F.friction) {
            Spin<D> torque = c.arm_i * torque_of(f.tangential, c.normal);
            if constexpr (F.rolling != Rolling::none) torque = torque - c.effective * torque_of(f.rolling, c.normal);
            g.contact[i].torque = g.contact[i].torque + torque;
        }
        if constexpr (F.ledger) {
            LossyLoad<D> const load = lossy_load<F>(c, f.lossy);
            add<F>(state.lossy, i, load, 1.0, load.on_i);
            add(lossy, lossy_forces(load));
        }
    }
    if constexpr (F.ledger) {
        books.add_to(state.booked);
        state.booked.wall_work += 0.5 * dt * dot(contacts.force + total, half.velocity);
    }
    contacts.force = total;
    if constexpr (F.ledger) state.lossy.wall[w] = lossy;
}

//! What goes through the sides of the cell.
template <Features F, int D>
void sum_up_seams(State<D>& state) noexcept
{
    for (Image<D>& image : state.cell.images) image.through = {};
    for (SeamLoad<D> const& load : state.seams) {
        state.cell.images[load.image].through += load.force;
        if constexpr (F.ledger) add(state.lossy.image[load.image], load.lossy);
    }
    state.seams.clear();
    gather_pull(state.cell);
}

template <Features F, int D>
void evaluate_contacts(Setup<D> const& setup, State<D>& state, double dt, sluice::Team* team) noexcept
{
    if constexpr (F.ledger) clear<F>(state.lossy, setup, state.grains.size());
    add_pair_forces<F>(setup, state, dt, team);
    if constexpr (F.periodic) sum_up_seams<F>(state);
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        std::visit([&](auto const& shape) { add_wall_forces<F>(shape, setup, state, w, dt); }, setup.walls[w].shape);
    for (Push<D> const& push : state.pushes) {
        state.grains.half[push.grain].velocity += push.motion.velocity;
        state.grains.half[push.grain].spin = state.grains.half[push.grain].spin + push.motion.spin;
    }
    state.pushes.clear();
}

//! All sets of features that are compiled: friction and rolling go together, LIGGGHTS' order has no ledger and no
//! periodic sides.
constexpr auto compiled = [] {
    std::array<Features, DEM_PERIODIC ? 16 : 20> all{};
    std::size_t n = 0;
    for (auto const elasticity : {Elasticity::linear, Elasticity::hertz})
        for (bool const ledger : {false, true}) {
            all[n++] = {.elasticity = elasticity, .ledger = ledger};
            for (auto const rolling : {Rolling::none, Rolling::elastic_plastic, Rolling::constant})
                all[n++] = {.elasticity = elasticity, .friction = true, .rolling = rolling, .ledger = ledger};
        }
    for (auto const elasticity : {Elasticity::linear, Elasticity::hertz})
        for (auto const rolling : {Rolling::none, Rolling::constant})
            if (!DEM_PERIODIC)
                all[n++] = {.elasticity = elasticity, .friction = true, .rolling = rolling, .scheme = Scheme::liggghts};
    for (Features& features : all) features.periodic = DEM_PERIODIC;
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

template <int D, bool periodic>
Evaluate<D> evaluation_for(Features const& features) noexcept
{
    return find<D>(features, std::make_index_sequence<compiled.size()>());
}
template Evaluate<DEM_DIMENSION> evaluation_for<DEM_DIMENSION, DEM_PERIODIC>(Features const&) noexcept;

}  // namespace dem
