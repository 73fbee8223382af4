#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/dem/state.hpp"

namespace dem {

//! A settled column at rest: everything a run needs to start from it, contact history included.
template <int D>
struct Packing
{
    std::vector<Place<D>> place;
    std::vector<ContactRecord<D>> records;
    double kinetic_ratio = 0.0;  //!< kinetic energy / (sum m g d_mean) when it was accepted [-]; settled: <= 1e-8
};

//! Largest kinetic energy of a settled bed over sum m g d_mean [-]. Source: benchmark D07.
inline constexpr double settled_kinetic_ratio = 1e-8;

//! One line for the user at a time: what is going on.
using Progress = std::function<void(std::string const&)>;

//! The packing of a column: from the cache if it is there and intact, else poured and written to it. Depends on the
//! column, grains, contacts, walls and gravity, not on buoyancy or on what happens later. No column: an empty packing.
//! An empty cache path: nothing is read or written.
template <int D>
Packing<D> prepare_packing(Config const& config, std::filesystem::path const& cache, Progress const& progress = {});

//! Pours a column (see README.md for the three stages). Says so through `progress` if it does not settle.
template <int D>
Packing<D> pour_packing(Config const& config, Progress const& progress = {});

}  // namespace dem
