#pragma once

#include "participants/dem/checkpoint.hpp"
#include "participants/dem/solver.hpp"

namespace unit {

//! What a checkpoint keeps of a state: two that are equal are so bit for bit.
template <int D>
sluice::State kept(dem::State<D> const& state)
{
    sluice::State all;
    dem::keep(state, all);
    return all;
}
template <int D>
sluice::State kept(dem::Solver<D> const& solver)
{
    return kept(solver.state());
}

}  // namespace unit
