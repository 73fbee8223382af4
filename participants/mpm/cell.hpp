#pragma once

#include <array>
#include <cmath>

#include "participants/mpm/state.hpp"

namespace mpm {

//! A cell of the grid, by its number along each axis from the domain's lower corner on.
template <int D>
using Cell = std::array<int, D>;

//! The one that a place lies in.
template <int D>
Cell<D> cell_of(Setup<D> const& setup, Vec<D> const& place)
{
    Cell<D> cell;
    for (std::size_t k = 0; k < D; ++k) {
        auto const a = static_cast<int>(k);
        cell[k] = static_cast<int>(std::floor((place[a] - setup.origin[a]) / setup.cell));
    }
    return cell;
}

//! The lower corner of a cell, where the node of its number is.
template <int D>
Vec<D> corner_of(Setup<D> const& setup, Cell<D> const& cell)
{
    Vec<D> place = setup.origin;
    for (std::size_t k = 0; k < D; ++k) place[static_cast<int>(k)] += setup.cell * cell[k];
    return place;
}

}  // namespace mpm
