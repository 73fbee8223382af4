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
    if (wall.kind == WallKind::open || (wall.kind == WallKind::rough && into <= 0)) return Grip::none;
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
void hold_again(Wall const& wall, Grip grip, Vec<D>& v)
{
    if (grip == Grip::whole) v.setZero();
    if (grip == Grip::across) v[wall.axis] = 0;
}

template <int D>
bool holds(Wall const& wall, Setup<D> const& setup, Node<D> const& node)
{
    auto const line = std::lround((wall.place - setup.origin[wall.axis]) / setup.cell);
    return wall.side * (node.index[static_cast<std::size_t>(wall.axis)] - line) >= 0;
}

}  // namespace mpm
