#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "participants/mpm/cell.hpp"

//! The cure for volumetric locking. Where plastic flow keeps the volume each point asks that of its own velocity
//! gradient, more than the grid's velocities can give, and the pressures of neighbours swing apart. So all points of a
//! cell share its change of volume, and its mean stress in what pulls the nodes:
//!
//!     dF <- dF (mean of det dF / det dF)^(1/D),   s <- s + (mean of tr s - tr s)/D I   (D x D parts; by volume)
//!
//! The two means are the same symmetric operator, so that the pull does exactly the work that the strain makes. After
//! de Souza Neto et al., Int. J. Solids Struct. 33 (1996) 3277 (F-bar); in material points: Coombs et al., Comput.
//! Methods Appl. Mech. Eng. 333 (2018) 1. There the centre of an element stands for its mean, and forces stay as they
//! are.
namespace mpm {

//! A cell in the domain, or one beside it, as one number.
template <int D>
std::int64_t number_of(Setup<D> const& setup, Cell<D> const& cell)
{
    std::int64_t number = 0;
    for (std::size_t k = D; k-- > 0;) number = number * (setup.cells[k] + 3) + cell[k] + 1;
    return number;
}

//! The mean of `values` over the points of its cell, by their volume now, for each point. Sums in the order of points.
template <int D>
std::vector<double> cell_means(Setup<D> const& setup, State<D> const& state, std::span<Vec<D> const> places,
                               std::vector<double> values)
{
    struct Sum
    {
        double volume = 0, value = 0;
    };
    std::unordered_map<std::int64_t, Sum> sums;
    std::vector<Sum const*> mine;
    for (std::size_t p = 0; p < places.size(); ++p) {
        Sum& sum = sums[number_of<D>(setup, cell_of(setup, places[p]))];
        sum.volume += state.points[p].volume_now();
        sum.value += state.points[p].volume_now() * values[p];
        mine.push_back(&sum);
    }
    for (std::size_t p = 0; p < places.size(); ++p) values[p] = mine[p]->value / mine[p]->volume;
    return values;
}

}  // namespace mpm
