#include "participants/dem/energy.hpp"

#include "participants/dem/contacts.hpp"
#include "participants/dem/half_step.hpp"

namespace dem {

//! -m w^2 r^2 / 2 of all grains, less buoyancy.
template <int D>
double centrifugal_energy(Setup<D> const& setup, Grains<D> const& g, double time)
{
    auto const pull = setup.frame->centrifugal(time);
    Vec<D> const axis = point_of_axis(*setup.frame);
    double sum = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        Vec<D> const r = g.place[i].centre - axis;
        sum -= 0.5 * setup.weight * g.mass[i] * dot(r, times(pull, r));
    }
    return sum;
}

template <int D>
Energies energies(Setup<D> const& setup, State<D> const& state)
{
    Grains<D> const& g = state.grains;
    Energies e;
    Vec<D> const gravity = setup.gravity_at(state.time);
    for (std::size_t i = 0; i < g.size(); ++i) {
        e.kinetic_linear += 0.5 * g.mass[i] * dot(g.motion[i].velocity, g.motion[i].velocity);
        e.kinetic_rotational += 0.5 * g.inertia[i] * dot(g.motion[i].spin, g.motion[i].spin);
        e.potential -= g.mass[i] * dot(gravity, g.place[i].centre);
    }
    if (setup.frame) e.potential += centrifugal_energy(setup, g, state.time);
    auto const add = [&](Elastic const& elastic) {
        e.elastic_normal += elastic.normal;
        e.elastic_tangential += elastic.tangential;
        e.elastic_rolling += elastic.rolling;
    };
    add(elastic_energy_of_pairs(setup, state));
    for (std::size_t w = 0; w < setup.walls.size(); ++w) add(elastic_energy_of_wall(setup, state, w));
    Booked const& b = state.booked;
    e.normal_dashpot = b.normal_dashpot;
    e.tangential_dashpot = b.tangential_dashpot;
    e.sliding = b.sliding;
    e.rolling = b.rolling;
    e.removed_walls = b.removed_walls;
    e.touch = b.touch;
    e.external_work = b.external_work;
    e.wall_work = b.wall_work;
    e.field_work = b.field_work;
    return e;
}

template Energies energies<2>(Setup<2> const&, State<2> const&);
template Energies energies<3>(Setup<3> const&, State<3> const&);

}  // namespace dem
