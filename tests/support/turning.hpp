#pragma once

#include <cmath>
#include <complex>
#include <utility>

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

//! (across, up) as a vector of the plane of motion, of two numbers or three.
template <class Vector>
Vector in_plane(double x, double up)
{
    if constexpr (sizeof(Vector) == 2 * sizeof(double))
        return {x, up};
    else
        return {x, 0.0, up};
}

//! Steps of about dt to the end [s].
template <class Solver>
void run(Solver& solver, double end, double dt)
{
    auto const steps = std::llround(end / dt);
    for (long long k = 0; k < steps; ++k) solver.step(end / static_cast<double>(steps));
}

struct Path  //!< in a frame that turns about the origin
{
    double w, x0, z0, vx0, vz0;

    //! q = z + ix = [q0 + (q0' + i w q0) t] e^{-iwt}: a straight line in the inertial frame.
    std::pair<double, double> place(double t) const
    {
        std::complex<double> const i(0, 1), q0(z0, x0), v0(vz0, vx0);
        auto const q = (q0 + (v0 + i * w * q0) * t) * std::exp(-i * w * t);
        return {q.imag(), q.real()};
    }
};

}  // namespace verification
