#include "participants/dem/energy.hpp"

#include "participants/dem/contacts.hpp"

namespace dem {

Energies energies(Setup const& setup, State const& state)
{
    Grains const& g = state.grains;
    Energies e;
    for (std::size_t i = 0; i < g.size(); ++i) {
        e.kinetic_linear += 0.5 * g.mass[i] * (g.vx[i] * g.vx[i] + g.vy[i] * g.vy[i]);
        e.kinetic_rotational += 0.5 * g.inertia[i] * g.spin[i] * g.spin[i];
        e.potential -= g.mass[i] * (setup.gravity.x * g.x[i] + setup.gravity.y * g.y[i]);
    }
    Elastic elastic = elastic_energy_of_pairs(setup, state);
    for (std::size_t w = 0; w < setup.walls.size(); ++w) {
        Elastic const wall = elastic_energy_of_wall(setup, state, w);
        elastic.normal += wall.normal;
        elastic.tangential += wall.tangential;
    }
    e.elastic_normal = elastic.normal;
    e.elastic_tangential = elastic.tangential;
    e.normal_dashpot = state.booked.normal_dashpot;
    e.tangential_dashpot = state.booked.tangential_dashpot;
    e.sliding = state.booked.sliding;
    e.removed_walls = state.booked.removed_walls;
    e.touch = state.booked.touch;
    e.external_work = state.booked.external_work;
    return e;
}

}  // namespace dem
