#pragma once

#include <cmath>

#include "participants/mpm/grid.hpp"
#include "participants/mpm/state.hpp"

namespace mpm {

//! Coulomb's law on impulses: along a rough wall a node loses at most mu times what it loses across.
template <int D>
Grip hold(Wall const& wall, Vec<D>& v)
{
    double const into = wall.side * v[wall.axis];
    if (wall.kind == WallKind::open || wall.kind == WallKind::joined || (wall.kind == WallKind::rough && into <= 0))
        return Grip::none;
    v[wall.axis] = 0;
    if (wall.kind == WallKind::roller) return Grip::across;
    double const speed = v.norm(), most = wall.friction * into;
    if (wall.kind == WallKind::fixed || speed <= most) {
        v.setZero();
        return Grip::whole;
    }
    v *= 1 - most / speed;
    return Grip::across;
}

//! The same to the velocity that strain sees: where the wall has acted, and only there. A wall that may be left would
//! else take inward motion and let outward motion pass, and a body in contact would gain energy.
template <int D>
void hold_again(int axis, Grip grip, Vec<D>& v)
{
    if (grip == Grip::whole) v.setZero();
    if (grip == Grip::across) v[axis] = 0;
}

//! The grid line that a wall is on.
template <int D>
int line_of(Wall const& wall, Setup<D> const& setup)
{
    return static_cast<int>(std::lround((wall.place - setup.origin[wall.axis]) / setup.cell));
}

template <int D>
bool holds(Wall const& wall, Setup<D> const& setup, std::array<int, D> const& node)
{
    return wall.side * (node[static_cast<std::size_t>(wall.axis)] - line_of(wall, setup)) >= 0;
}

}  // namespace mpm
