#pragma once

#include <cstddef>

#include "coupler/base/state.hpp"
#include "participants/dem/config.hpp"
#include "participants/dem/state.hpp"

namespace dem {

//! Puts the whole state of a run into `kept`, as named arrays: a solver restored from it continues bit for bit.
template <int D>
void keep(State<D> const& state, sluice::State& kept);

//! Takes out what keep() put in, for a run of `grains` grains with this setup. Throws sluice::Error (io) if something
//! is not there, or does not fit: the kernels trust every index.
template <int D>
State<D> kept_state(sluice::State const& kept, Setup<D> const& setup, std::size_t grains);

//! Which grains a file gave, for a run that starts from one: the state must not go on with others. Throws
//! sluice::Error (io).
void keep_source(Config const& config, sluice::State& kept);
void require_source(Config const& config, sluice::State const& kept);

}  // namespace dem
