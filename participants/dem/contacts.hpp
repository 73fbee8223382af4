#pragma once

#include "participants/dem/state.hpp"

//! The contact loops. For a pair (i, j): n from j to i, t = n turned by +90 degrees, xi = Ri + Rj - |xi - xj|;
//!     slip      s      = (vi - vj).t - (li wi + lj wj),      arms li = Ri |xi - xj| / (Ri + Rj)
//!     force     on i   = Fn n - Ft t,  on j the opposite;    torque on i = li Ft, on j = lj Ft
//! The arms meet in one point, so that angular momentum is conserved; a wall is the limit Rj -> infinity, l = R.
//! Dashpots see the velocity predicted at the end of the step, springs the displacement over it.
//!
//! Beginning of a contact: a pair that touched a fraction q = xi / (dt xi_dot) of a step ago has had dashpot and
//! friction for q dt, where the second half kick acts for dt/2. The difference, (q - 1/2) dt times these forces, is an
//! impulse on the half-step velocities; the elongation is that of q dt, and the laws see the velocities slowed for q
//! dt. Without this the rebound depends on where in a step the contact begins, at first order in dt (0.03 alpha v0 at
//! t_c/50).
namespace dem {

//! Sets the contact and wall forces at the current positions; `dt` is the length of the step that led here [s], 0 to
//! evaluate the forces again without a step. With the ledger, books sliding and touch and keeps the lossy forces.
template <Features F>
void evaluate_contacts(Setup const& setup, State& state, double dt) noexcept;

//! Power of the forces that are not elastic at the current velocities, into state.power. After evaluate_contacts.
void evaluate_lossy_power(Setup const& setup, State& state) noexcept;

//! Elastic energy stored in one wall's contacts [J], normal and tangential.
struct Elastic
{
    double normal = 0.0;
    double tangential = 0.0;
};
Elastic elastic_energy_of_wall(Setup const& setup, State const& state, std::size_t wall) noexcept;
Elastic elastic_energy_of_pairs(Setup const& setup, State const& state) noexcept;

}  // namespace dem
