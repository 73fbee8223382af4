#include <cmath>

#include "participants/dem/contact.hpp"
#include "participants/dem/contacts.hpp"

//! What the ledger reads from the contacts between two evaluations.
namespace dem {
namespace {

//! Calls `visit(contact, overlap, law, history, slot)` for each listed contact of the pairs whose first grain is ours.
template <int D, class Visit>
void for_pairs(Setup<D> const& setup, State<D> const& state, Visit&& visit)
{
    Grains<D> const& g = state.grains;
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (g.is_ghost(i)) continue;  // its owner sees the pair as well
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::size_t const j = state.pairs.other[slot];
            Vec<D> const from_j = apart(g, state.pairs, state.cell, i, slot);
            double const distance = norm(from_j), ri = g.place[i].radius, rj = g.place[j].radius;
            visit(contact_of<D>(from_j, distance, ri, rj), ri + rj - distance, setup.law, state.pairs.history, slot);
        }
    }
}
template <int D, class Visit>
void for_wall(Setup<D> const& setup, State<D> const& state, std::size_t w, Visit&& visit)
{
    Grains<D> const& g = state.grains;
    WallContacts<D> const& contacts = state.walls[w];
    std::visit(
        [&](auto const& shape) {
            for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
                std::size_t const i = contacts.grain[k];
                Facing<D> const at = facing_of(shape, contacts, k, g.place[i].centre);
                double const radius = g.place[i].radius, overlap = radius - at.distance;
                if (!is_contact(shape, contacts, k, overlap)) continue;
                visit(contact_with_wall<D>(at.normal, radius), overlap, setup.walls[w].law, contacts.history, k);
            }
        },
        setup.walls[w].shape);
}

//! A visitor that adds elastic energies to `sum`.
template <int D>
auto adding(Features const& features, Elastic& sum)
{
    return [&features, &sum](Contact<D> const& c, double overlap, ContactLaw const& law, History<D> const& history,
                             std::size_t at) {
        if (overlap <= 0.0) return;
        Stiffness const s = stiffness_of(features.elasticity, law, overlap, c.effective);
        sum.normal += s.energy;
        if (features.friction) sum.tangential += spring_energy(history.friction[at], s.tangential);
        if (features.rolling == Rolling::elastic_plastic)
            sum.rolling += spring_energy(history.rolling[at], law.rolling.stiffness * s.tangential);
    };
}

}  // namespace

template <int D>
void evaluate_lossy_power(State<D>& state) noexcept
{
    Grains<D> const& g = state.grains;
    LossyLoads<D> const& lossy = state.lossy;
    auto const of = [](Load<D> const& load, Motion<D> const& motion) {
        return dot(load.force, motion.velocity) + dot(load.torque, motion.spin);
    };
    LossyPower power;
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (g.is_ghost(i)) continue;
        power.normal -= dot(lossy.press_and_roll[i].force, g.motion[i].velocity);
        power.rolling -= dot(lossy.press_and_roll[i].torque, g.motion[i].spin);
        if (!lossy.tangential.empty()) {
            power.tangential -= of(lossy.tangential[i], g.motion[i]);
            power.sliding -= of(lossy.sliding[i], g.motion[i]);
        }
    }
    auto const of_partner = [&](LossyForces<D> const& sum, Vec<D> velocity) {
        power.normal += dot(sum.normal, velocity);
        power.tangential += dot(sum.tangential, velocity);
        power.sliding += dot(sum.sliding, velocity);
    };
    for (std::size_t w = 0; w < lossy.wall.size(); ++w) of_partner(lossy.wall[w], state.walls[w].velocity);
    for (std::size_t k = 0; k < lossy.image.size(); ++k) of_partner(lossy.image[k], state.cell.images[k].velocity);
    state.power = power;
}

template <int D>
Elastic elastic_energy_of_pairs(Setup<D> const& setup, State<D> const& state) noexcept
{
    Elastic sum;
    for_pairs<D>(setup, state, adding<D>(setup.features, sum));
    return sum;
}

template <int D>
Elastic elastic_energy_of_wall(Setup<D> const& setup, State<D> const& state, std::size_t w) noexcept
{
    Elastic sum;
    for_wall<D>(setup, state, w, adding<D>(setup.features, sum));
    return sum;
}

template void evaluate_lossy_power<2>(State<2>&) noexcept;
template void evaluate_lossy_power<3>(State<3>&) noexcept;
template Elastic elastic_energy_of_pairs<2>(Setup<2> const&, State<2> const&) noexcept;
template Elastic elastic_energy_of_pairs<3>(Setup<3> const&, State<3> const&) noexcept;
template Elastic elastic_energy_of_wall<2>(Setup<2> const&, State<2> const&, std::size_t) noexcept;
template Elastic elastic_energy_of_wall<3>(Setup<3> const&, State<3> const&, std::size_t) noexcept;

}  // namespace dem
