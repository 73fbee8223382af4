#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! An edge of a periodic cell must be at least so long [m]: then a grain is near one image of another at most.
inline double shortest_edge(double largest_diameter, double skin) noexcept
{
    return 2.0 * (largest_diameter + skin);
}

//! Puts the grains that have left the cell back on the other side, with the velocity of that side, and notes them in
//! state.crossings.
template <int D>
void put_back(Periodic<D> const& periodic, State<D>& state);

//! All pairs (i < j) with a gap below `reach` [m] between i and an image of j, ascending, and which image that is. The
//! grains must be in the cell. Throws sluice::Error (numerical) if the cell has become too small for this.
template <int D>
void find_periodic_pairs(Setup<D> const& setup, State<D> const& state, std::vector<std::uint32_t>& first,
                         std::vector<std::uint32_t>& other, std::vector<std::uint32_t>& image);

}  // namespace dem
