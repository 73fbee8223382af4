#include "participants/mpm/energy.hpp"

#include "participants/mpm/field.hpp"

namespace mpm {

template <int D>
double kinetic_energy(State<D> const& state)
{
    double sum = 0;
    for (Point<D> const& p : state.points) sum += 0.5 * p.mass * p.velocity.squaredNorm();
    return sum;
}

template <int D>
double potential_energy(Setup<D> const& setup, State<D> const& state, double time)
{
    Potential<D> const potential(setup, time);
    double sum = 0;
    for (Point<D> const& p : state.points) sum += p.mass * potential(p.place);
    return sum;
}

template <int D>
Energies energies(Setup<D> const& setup, State<D> const& state)
{
    Energies e{.kinetic = kinetic_energy(state), .booked = state.booked};
    e.potential = potential_energy(setup, state, state.time);
    std::visit(
        [&](auto const& law) {
            for (Point<D> const& p : state.points) e.elastic += p.volume_now() * law.energy(p.matter);
        },
        setup.law);
    return e;
}

template double kinetic_energy<2>(State<2> const&);
template double kinetic_energy<3>(State<3> const&);
template double potential_energy<2>(Setup<2> const&, State<2> const&, double);
template double potential_energy<3>(Setup<3> const&, State<3> const&, double);
template Energies energies<2>(Setup<2> const&, State<2> const&);
template Energies energies<3>(Setup<3> const&, State<3> const&);

}  // namespace mpm
