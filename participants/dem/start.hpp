#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "coupler/base/state.hpp"
#include "participants/dem/config.hpp"
#include "participants/dem/solver.hpp"

//! What a run says about its grains as they are at t = 0, whoever moves them afterwards.
namespace dem {

//! Packings are kept between runs here; empty: nowhere.
std::filesystem::path packing_cache();

//! So many grains has the run.
std::size_t count_grains(Config const& config);

//! A checkpoint keeps it, for the summary of a resumed run.
struct Start
{
    double height = 0, front = 0, mean_diameter = 0;  //!< m
    double packing_fraction = 0;                      //!< 0: not a column, or too narrow to measure it
    double balance = 0;                               //!< of the energies [J]

    void keep(sluice::State& state) const;
    static Start kept(sluice::State const& state);
};

template <int D>
Start start_of(Config const& config, Solver<D> const& solver);

//! Names with units, and figures, for a summary.
std::vector<std::pair<std::string, double>> facts_of(Config const& config, Start const& start);

}  // namespace dem
