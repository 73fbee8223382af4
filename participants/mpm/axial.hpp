#pragma once

#include <algorithm>
#include <numbers>

#include "participants/mpm/state.hpp"

//! Points as rings around the axis x = 0, whose volume is 2 pi r times their area in the plane. Means over a point are
//! by volume, those of 1/r by area, so that a uniform pressure in points that fill space pulls at no node. With <.> the
//! mean over the point's area in the plane:
//!
//!     weight = <r N>/r,   slope = <r dN/dx>/r,   hoop = <N>/r         stretch around the axis: sum hoop v_r
//!
//! Source: Nairn and Guilkey, Int. J. Numer. Meth. Eng. 101 (2015) 127. Here the radius itself moves by r sum hoop v_r,
//! and stays that of the stretch around the axis; a point nearer to it than half its width is as narrow as that.
namespace mpm {

//! <u N(d + u)> and <u N'(d + u)> of a hat function, u from -l to l [cells]; what radial means add to those of the
//! plane.
struct Moments
{
    double value = 0, slope = 0;
};
inline Moments moments_of_hat(double d, double l)
{
    Moments sum;
    if (!(l > 0)) return sum;
    for (int side : {-1, 1}) {  // N = 1 + rise (d + u) there
        double const rise = -side, from = std::max(-l, (side < 0 ? -1 : 0) - d),
                     to = std::min(l, (side < 0 ? 0 : 1) - d);
        if (from >= to) continue;
        double const square = (to * to - from * from) / 2, cube = (to * to * to - from * from * from) / 3;
        sum.value += ((1 + rise * d) * square + rise * cube) / (2 * l);
        sum.slope += rise * square / (2 * l);
    }
    return sum;
}

//! What an area of the plane stands for: its ring's volume by its area [m]; without symmetry 1.
template <int D>
double girth(Symmetry symmetry, Vec<D> const& place)
{
    return symmetry == Symmetry::axial ? 2 * std::numbers::pi * place[0] : 1;
}

}  // namespace mpm
