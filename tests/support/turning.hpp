#pragma once

#include "coupler/scene/scene.hpp"

//! The frame of the cases R: in space w e_y, motion in (x, z); in the plane the axis points out of (x, y), so that the
//! same motion has the other sign of w.
namespace verification {

struct Parts
{
    bool centrifugal = true, coriolis = true;
};

//! `rate` is w [rad/s]; `axis_height` that of the axis [m].
template <int D>
sluice::Rotation rotation(double rate, double axis_height, Parts parts = {})
{
    if constexpr (D == 2)
        return {{0, axis_height, 0}, {0, 0, 1}, -rate, 0, parts.centrifugal, parts.coriolis, true};
    else
        return {{0, 0, axis_height}, {0, 1, 0}, rate, 0, parts.centrifugal, parts.coriolis, true};
}

}  // namespace verification
