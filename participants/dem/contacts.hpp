#pragma once

#include "coupler/base/team.hpp"
#include "participants/dem/state.hpp"

//! The loops over contacts; what happens in one is in contact.hpp.
namespace dem {

//! Adds the contact and wall forces at the current positions to grains.contact, which is zero before; `dt` is the
//! length of the step that led here [s], 0 to evaluate the forces again without a step. With the ledger, books sliding
//! and touch, and sets state.lossy. `team`: who shares the loops, null: nobody. The number of threads changes no bit.
template <int D>
using Evaluate = void (*)(Setup<D> const&, State<D>&, double dt, sluice::Team* team) noexcept;

//! The loop that was compiled for a set of features; null: not compiled.
template <int D, bool periodic>
Evaluate<D> evaluation_for(Features const& features) noexcept;

//! Power of the forces that are not elastic at the current velocities, into state.power. After an evaluation.
template <int D>
void evaluate_lossy_power(State<D>& state) noexcept;

//! Elastic energy of contacts [J].
struct Elastic
{
    double normal = 0.0;
    double tangential = 0.0;
    double rolling = 0.0;
};
template <int D>
Elastic elastic_energy_of_wall(Setup<D> const& setup, State<D> const& state, std::size_t wall) noexcept;
template <int D>
Elastic elastic_energy_of_pairs(Setup<D> const& setup, State<D> const& state) noexcept;

}  // namespace dem
