#pragma once

#include "coupler/base/state.hpp"
#include "participants/mpm/solver.hpp"

namespace mpm {

//! Puts the whole state of a run into `kept`, as named arrays: a solver restored from it continues bit for bit. Of
//! several processes, all of which call both, the first keeps everything, for any number of them.
template <int D>
void keep(Solver<D> const& solver, sluice::State& kept);

//! Takes out what keep() put in. Throws sluice::Error (io) if something is not there, does not fit, or has no place in
//! the solver's domain; the solver is then as it was.
template <int D>
void restore(Solver<D>& solver, sluice::State const& kept);

}  // namespace mpm
