#pragma once

#include "participants/mpm/config.hpp"
#include "participants/mpm/solver.hpp"

namespace mpm {

//! The constant part of a run.
template <int D>
Setup<D> make_setup(Config const& config);

//! The points of all bodies, at the middle of equal parts of the cells, body by body and row by row, with their
//! geostatic stress. The points whose places are in a body share its volume evenly: mass is exact.
template <int D>
State<D> make_state(Config const& config);

//! A run at t = 0. Throws sluice::Error (config) also for a step above the limit, and for a body without points.
//! `peers`: the processes that share it; null: there is one.
template <int D>
Solver<D> make_solver(Config const& config, ranks::Peers* peers = nullptr);

}  // namespace mpm
