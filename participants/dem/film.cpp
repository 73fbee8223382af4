#include "participants/dem/film.hpp"

#include "participants/dem/contact.hpp"

namespace dem {

template <int D>
void add_films(Setup<D> const& setup, State<D>& state, double dt)
{
    Grains<D>& g = state.grains;
    double const cutoff = setup.lubrication.cutoff;
    auto const count = static_cast<std::uint32_t>(g.size());
    auto const force_of = [&](Contact<D> const& c, double gap, Motion<D> const& i, Motion<D> const& j) {
        return setup.lubrication.template resistance<D>(gap, c.effective) * c.closing(i, j) * c.normal;
    };
    state.films.clear();
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::uint32_t const j = state.pairs.other[slot];
            double const reach = g.place[i].radius + g.place[j].radius, far = reach + cutoff;
            Vec<D> const from_j = apart(g, state.pairs, state.cell, i, slot);
            double const square = dot(from_j, from_j);
            if (square >= far * far) continue;
            double const distance = std::sqrt(square);
            auto const c = contact_of<D>(from_j, distance, g.place[i].radius, g.place[j].radius);
            Vec<D> const force = force_of(c, distance - reach, g.motion[i], g.motion[j]);
            state.films.push_back({i, j, force});
            g.contact[i].force += force;
            g.contact[j].force -= force;
        }
    for (std::uint32_t w = 0; w < setup.walls.size(); ++w) {
        WallContacts<D>& contacts = state.walls[w];
        Motion<D> wall{};
        wall.velocity = contacts.velocity;
        std::visit(
            [&](auto const& shape) {
                for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
                    std::uint32_t const i = contacts.grain[k];
                    Facing<D> const at = facing_of(shape, contacts, k, g.place[i].centre);
                    double const radius = g.place[i].radius, gap = at.distance - radius;
                    if (gap >= cutoff) continue;
                    Vec<D> const force = force_of(contact_with_wall<D>(at.normal, radius), gap, g.motion[i], wall);
                    state.films.push_back({i, count + w, force});
                    g.contact[i].force += force;
                    contacts.force += force;
                    if (setup.features.ledger) state.booked.wall_work += 0.5 * dt * dot(force, contacts.velocity);
                }
            },
            setup.walls[w].shape);
    }
}

template <int D>
double power_of_films(State<D> const& state)
{
    auto const& motion = state.grains.motion;
    double power = 0.0;
    for (Film<D> const& film : state.films) {
        if (state.grains.is_ghost(film.first)) continue;  // its owner sees the pair as well
        Vec<D> const other = film.second < motion.size() ? motion[film.second].velocity
                                                         : state.walls[film.second - motion.size()].velocity;
        power -= dot(film.force, motion[film.first].velocity - other);
    }
    return power;
}

template void add_films<2>(Setup<2> const&, State<2>&, double);
template void add_films<3>(Setup<3> const&, State<3>&, double);
template double power_of_films<2>(State<2> const&);
template double power_of_films<3>(State<3> const&);

}  // namespace dem
