#pragma once

#include <array>

#include "participants/mpm/setup.hpp"

namespace unit {

using Joined = std::array<bool, 3>;  //!< the axes whose sides are one

//! A domain full of matter between joined sides, through which gravity drives it, and walls.
template <int D>
mpm::Config full(mpm::Law const& law, Joined const& joined, int cells, mpm::WallKind others = mpm::WallKind::roller,
                 double friction = 0)
{
    mpm::Config c;
    c.dimension = D;
    c.density = 1900;
    c.law = law;
    c.shared_volume = true;
    c.cell = 0.01;
    double const length = cells * c.cell;
    c.size = {length, length, D == 3 ? length : 0};
    c.bodies.push_back({.high = c.size});
    for (std::size_t a = 0; a < D; ++a) {
        if (joined[a]) c.gravity[a] = static_cast<double>(a) - 2.5;
        for (int side : {-1, 1})
            c.walls.push_back({static_cast<int>(a), side, side < 0 ? 0 : length,
                               joined[a] ? mpm::WallKind::joined : others, friction});
    }
    return c;
}

}  // namespace unit
