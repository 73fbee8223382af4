#pragma once

#include "participants/dem/state.hpp"

namespace dem {

//! Energy ledger [J]; discs: per metre of thickness. What the state holds, and what it lost since the ledger began:
//!     held() + lost() - external_work - wall_work - field_work = constant
struct Energies
{
    double kinetic_linear = 0.0;
    double kinetic_rotational = 0.0;
    double potential =
        0.0;  //!< -sum m g.x, g with buoyancy; zero at the origin; and the centrifugal one, zero on the axis
    double elastic_normal = 0.0;
    double elastic_tangential = 0.0;
    double elastic_rolling = 0.0;
    double normal_dashpot = 0.0;      //!< dissipated, also by films of fluid in narrow gaps
    double tangential_dashpot = 0.0;  //!< dissipated
    double sliding = 0.0;             //!< dissipated, with what is left in a spring whose contact opens
    double rolling = 0.0;             //!< dissipated by the resistance to rolling
    double removed_walls = 0.0;       //!< elastic energy that vanished with walls, and with grains that fell asleep
    double touch = 0.0;               //!< lost by the step's finite length where contacts begin and end; < 0: made
    double external_work = 0.0;       //!< done on the grains by the external forces (the fluid)
    double wall_work = 0.0;           //!< done on the grains by moving walls
    double field_work = 0.0;          //!< done on the grains by gravity or a frame that changes

    double kinetic() const { return kinetic_linear + kinetic_rotational; }
    double elastic() const { return elastic_normal + elastic_tangential + elastic_rolling; }
    double held() const { return kinetic() + potential + elastic(); }
    double lost() const { return normal_dashpot + tangential_dashpot + sliding + rolling + removed_walls + touch; }
    double balance() const { return held() + lost() - external_work - wall_work - field_work; }
};

//! Kinetic energy of all grains, linear and rotational [J].
template <int D>
double kinetic_energy(Grains<D> const& grains)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < grains.size(); ++i) {
        auto const& [velocity, spin] = grains.motion[i];
        sum += 0.5 * grains.mass[i] * dot(velocity, velocity) + 0.5 * grains.inertia[i] * dot(spin, spin);
    }
    return sum;
}

//! The energies at the current time. Without Features::ledger the booked ones are zero.
template <int D>
Energies energies(Setup<D> const& setup, State<D> const& state);

}  // namespace dem
