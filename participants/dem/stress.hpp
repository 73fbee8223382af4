#pragma once

#include "participants/dem/state.hpp"

namespace dem {

//! What presses across a sheared cell, positive in compression [Pa]: contacts by the virial of the forces that act on
//! the grains, and the grains' motion.
template <int D>
double stress_across(Setup<D> const& setup, State<D> const& state) noexcept;

}  // namespace dem
