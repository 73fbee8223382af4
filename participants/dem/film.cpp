#include "participants/dem/film.hpp"

#include "participants/dem/contact.hpp"

namespace dem {
namespace {

//! Calls `visit(film, contact, gap, i, j)` for every listed pair that is near
//! enough, and `wall(film, contact, gap, i, contacts)` for walls likewise.
template <int D, class PairVisit, class WallVisit>
void for_films(Setup<D> const& setup, State<D>& state, PairVisit&& visit, WallVisit&& wall)
{
    Grains<D> const& g = state.grains;
    double const cutoff = setup.lubrication.cutoff;
    std::size_t film = 0;
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot, ++film) {
            std::size_t const j = state.pairs.other[slot];
            double const reach = g.place[i].radius + g.place[j].radius, far = reach + cutoff;
            Vec<D> const from_j = apart(g, state.pairs, state.cell, i, slot);
            double const square = dot(from_j, from_j);
            if (square >= far * far) continue;
            double const distance = std::sqrt(square);
            auto const c = contact_of<D>(from_j, distance, g.place[i].radius, g.place[j].radius);
            visit(state.films[film], c, distance - reach, i, j);
        }
    for (std::size_t w = 0; w < setup.walls.size(); ++w) {
        WallContacts<D>& contacts = state.walls[w];
        std::visit(
            [&](auto const& shape) {
                for (std::size_t k = 0; k < contacts.grain.size(); ++k, ++film) {
                    std::size_t const i = contacts.grain[k];
                    Facing<D> const at = facing_of(shape, contacts, k, g.place[i].centre);
                    double const gap = at.distance - g.place[i].radius;
                    if (gap < cutoff)
                        wall(state.films[film], contact_with_wall<D>(at.normal, g.place[i].radius), gap, i, contacts);
                }
            },
            setup.walls[w].shape);
    }
}

//! How a wall moves; it does not turn.
template <int D>
Motion<D> motion_of(WallContacts<D> const& contacts)
{
    Motion<D> motion{};
    motion.velocity = contacts.velocity;
    return motion;
}

}  // namespace

template <int D>
void add_films(Setup<D> const& setup, State<D>& state, double dt)
{
    std::size_t count = state.pairs.other.size();
    for (auto const& contacts : state.walls) count += contacts.grain.size();
    state.films.assign(count, 0.0);
    Grains<D>& g = state.grains;
    auto const force_of = [&](Contact<D> const& c, double gap, Motion<D> const& i, Motion<D> const& j) {
        return setup.lubrication.template resistance<D>(gap, c.effective) * c.closing(i, j);
    };
    for_films<D>(
        setup, state,
        [&](double& film, Contact<D> const& c, double gap, std::size_t i, std::size_t j) {
            film = force_of(c, gap, g.motion[i], g.motion[j]);
            g.contact[i].force += film * c.normal;
            g.contact[j].force -= film * c.normal;
        },
        [&](double& film, Contact<D> const& c, double gap, std::size_t i, WallContacts<D>& contacts) {
            film = force_of(c, gap, g.motion[i], motion_of(contacts));
            Vec<D> const force = film * c.normal;
            g.contact[i].force += force;
            contacts.force += force;
            if (setup.features.ledger) state.booked.wall_work += 0.5 * dt * dot(force, contacts.velocity);
        });
}

template <int D>
double power_of_films(Setup<D> const& setup, State<D>& state)
{
    Grains<D> const& g = state.grains;
    double power = 0.0;
    for_films<D>(
        setup, state,
        [&](double film, Contact<D> const& c, double, std::size_t i, std::size_t j) {
            power += film * c.closing(g.motion[i], g.motion[j]);
        },
        [&](double film, Contact<D> const& c, double, std::size_t i, WallContacts<D> const& contacts) {
            power += film * c.closing(g.motion[i], motion_of(contacts));
        });
    return power;
}

template void add_films<2>(Setup<2> const&, State<2>&, double);
template void add_films<3>(Setup<3> const&, State<3>&, double);
template double power_of_films<2>(Setup<2> const&, State<2>&);
template double power_of_films<3>(Setup<3> const&, State<3>&);

}  // namespace dem
