#pragma once

#include <vector>

#include "participants/dem/profile.hpp"
#include "participants/dem/state.hpp"

namespace dem {

//! The cells of the grains: all points that are nearer to a grain than to any other, by distance^2 - R^2 (radical, or
//! Laguerre, tessellation: no cell cuts a grain that touches its neighbours). Bounded by the walls, across periodic
//! sides by images, and where there is neither by a box one mean diameter beyond the outermost grains.
struct Tessellation
{
    std::vector<double> volume;    //!< of each grain's cell [m3]; discs: m2. 0: another grain covers it
    std::vector<double> fraction;  //!< of the cell that the grain fills [-]; 0 without a cell
    std::vector<bool> closed;      //!< the cell does not reach the box: it is bounded by grains and walls alone
};

//! Walls that grains are outside of (an inner cylinder) bound a cell by their tangent plane only.
template <int D>
Tessellation tessellate(Setup<D> const& setup, State<D> const& state);

//! What the closed cells say of the packing.
struct Packed
{
    double fraction = 0.0;          //!< grains over cells [-]; 0: no cell is closed
    std::size_t closed = 0;         //!< cells
    std::vector<double> position;   //!< middle of each slice [m]
    std::vector<double> fractions;  //!< grains over cells whose grain's centre is in the slice [-]; 0: none
};
template <int D>
Packed packed_of(Grains<D> const& grains, Tessellation const& cells, Bins const& bins);

}  // namespace dem
