#pragma once

#include "participants/dem/config.hpp"
#include "participants/dem/packing.hpp"
#include "participants/dem/solver.hpp"

namespace dem {

enum class Ledger
{
    off,
    on
};  //!< on: dissipated energies and work are summed up, at about half the speed

//! The constant part of a run: laws, walls, and gravity reduced by the buoyancy, g (1 - rho_f / rho_s); inertia stays.
template <int D>
Setup<D> make_setup(Config const& config, Ledger ledger = Ledger::off);

//! The grains that the scene or its file lists, in the order in which a run has them.
template <int D>
Grains<D> listed_grains(Config const& config);

//! A run at t = 0: the packing of a column, or the listed grains (then the packing is empty and not looked at).
template <int D>
Solver<D> make_solver(Config const& config, Packing<D> const& packing = {}, Ledger ledger = Ledger::off);

}  // namespace dem
