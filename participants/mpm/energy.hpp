#pragma once

#include "participants/mpm/state.hpp"

namespace mpm {

//! Energy ledger [J]; plane: per metre, axial: of whole rings. balance() is constant to the accuracy of the elastic
//! law: everything that the steps lose or gain themselves is in `numerical`.
struct Energies
{
    double kinetic = 0;
    double potential = 0;  //!< of gravity, zero at the origin, and of a frame that turns, zero on its axis
    double elastic = 0;
    Booked booked;

    double held() const { return kinetic + potential + elastic; }
    double lost() const { return booked.plastic + booked.sliding + booked.damping + booked.numerical; }
    double balance() const { return held() + lost() - booked.external_work - booked.field_work; }
};

template <int D>
double kinetic_energy(State<D> const& state);
template <int D>
double potential_energy(Setup<D> const& setup, State<D> const& state, double time);
template <int D>
Energies energies(Setup<D> const& setup, State<D> const& state);

}  // namespace mpm
