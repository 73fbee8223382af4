#pragma once

#include <cmath>
#include <utility>

#include "participants/mpm/axial.hpp"

namespace mpm {

constexpr double pressed =
    0.499;  //!< cells by which points may be pressed into a side; at 1/2 it holds them altogether

//! Where points may be [m]: in the domain, or in a side that is a wall by less than half a cell, where nothing moves
//! them further.
template <int D>
std::pair<Vec<D>, Vec<D>> room_of(Setup<D> const& setup)
{
    Vec<D> low = Vec<D>::Zero(), high;
    for (int k = 0; k < D; ++k) high[k] = setup.cells[static_cast<std::size_t>(k)];
    for (Wall const& wall : setup.walls) {
        if (wall.kind == WallKind::open || wall.kind == WallKind::joined || std::isfinite(wall.removed_at)) continue;
        (wall.side < 0 ? low : high)[wall.axis] += wall.side * pressed;
    }
    // nothing gets beyond the axis
    if (setup.symmetry == Symmetry::axial) low[0] = std::max(low[0], -setup.origin[0] / setup.cell);
    return {setup.origin + setup.cell * low, setup.origin + setup.cell * high};
}

//! Mass below which a node is light [kg]: its acceleration is felt by points, not by strain.
template <int D>
double light_mass(Setup<D> const& setup)
{
    double const cell = std::pow(setup.cell, D);
    // of a full cell, on the first ring of nodes
    return 1e-9 * setup.density * cell * girth<D>(setup.symmetry, Vec<D>::Constant(setup.cell));
}

}  // namespace mpm
