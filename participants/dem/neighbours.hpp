#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! Finds all pairs (i < j) with a gap below `reach` [m], ascending, through a grid of square cells of one largest
//! diameter + reach. Cost O(N) for sizes within a factor of a few. Positions must be finite (asserted).
void find_pairs(Grains const& grains, double reach, std::vector<std::uint32_t>& first,
                std::vector<std::uint32_t>& other);

//! Rebuilds the neighbour lists of pairs and walls from the current positions; springs are carried over by pair.
//! Throws sluice::Error (numerical) naming the first grain whose position is not finite or behind a wall.
void rebuild_lists(Setup const& setup, State& state);

}  // namespace dem
