#pragma once

#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/dem/solver.hpp"

//! Stress, fabric and packing fraction as columns of the time series: those that a scene asks for.
namespace dem {

template <int D>
std::vector<std::string> average_names(Config const& config);
template <int D>
void append_averages(Config const& config, Solver<D> const& solver, std::vector<double>& row);

}  // namespace dem
