#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! Finds all pairs (i < j) with a gap below `reach` [m], ascending. Grains are sorted by size into levels of a factor
//! of two, each with a grid of cells of its largest diameter + reach; a grain looks into the grids of its own and of
//! larger sizes. Cost O(N) also for wide ranges of sizes. Positions must be finite (asserted).
//! Source: hierarchical grids as Ogarko and Luding, Comput. Phys. Commun. 183 (2012) 931.
template <int D>
void find_pairs(Grains<D> const& grains, double reach, std::vector<std::uint32_t>& first,
                std::vector<std::uint32_t>& other);

//! Rebuilds the neighbour lists of pairs and walls from the current positions; histories are carried over by pair.
//! Ghosts are listed with grains of ours only.
//! Throws sluice::Error (numerical) naming the first grain whose position is not finite or behind a wall.
template <int D>
void rebuild_lists(Setup<D> const& setup, State<D>& state);

//! The same of grains that lie within their periodic cell and whose positions are finite.
template <int D>
void list_neighbours(Setup<D> const& setup, State<D>& state);

//! Throws sluice::Error (numerical) naming the first grain whose position is not finite.
template <int D>
void check_finite(State<D> const& state);

//! The pairs' sqrt(m*), after derive_from_list().
template <int D>
void set_sqrt_masses(Setup<D> const& setup, Grains<D> const& grains, Pairs<D>& pairs);

//! What follows from a list's `first` and `other`: owners, flags, and the transposed list if threads want it.
template <int D>
void derive_from_list(Setup<D> const& setup, Pairs<D>& pairs, std::size_t grains);

}  // namespace dem
