#pragma once

#include "participants/dem/state.hpp"

namespace dem {

//! Adds the forces of the fluid in narrow gaps (lubrication.hpp) to grains and walls, at the velocities predicted for
//! the end of the step, as dashpots have them; keeps them in state.films. After an evaluation of the contacts; `dt` as
//! there [s].
template <int D>
void add_films(Setup<D> const& setup, State<D>& state, double dt);

//! What they dissipate at the current velocities [W].
template <int D>
double power_of_films(State<D> const& state);

}  // namespace dem
