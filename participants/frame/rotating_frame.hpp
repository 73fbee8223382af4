#pragma once

#include <array>

#include "coupler/scene/scene.hpp"

//! What a frame of reference that turns does to bodies in it, as linear maps: a solver asks once a step, and applies
//! them to its grains, nodes or cells.
//!     acceleration = -w x (w x r) - dw/dt x r - 2 w x u,   r from the axis, u and all else as seen in the frame
namespace frame {

//! Row by row.
template <int D>
using Matrix = std::array<double, D * D>;

template <int D>
class RotatingFrame
{
 public:
    explicit RotatingFrame(sluice::Rotation const& rotation) : rotation_(rotation) {}

    double point(int axis) const { return rotation_.point[static_cast<std::size_t>(axis)]; }  //!< on the axis [m]
    double rate(double time) const;                                                           //!< w [rad/s]
    double angle(double from, double to) const;  //!< by which the frame turns between two times [rad]
    bool changes(double time) const { return time < rotation_.ramp; }

    //! M, so that M (x - point) is the centrifugal acceleration at a time [1/s2].
    Matrix<D> centrifugal(double time) const;
    //! M, so that M (x - point) is the Euler acceleration, as its mean between two times [1/s2].
    Matrix<D> euler(double from, double to) const;
    //! The rotation that the Coriolis acceleration alone gives to a velocity between two times: exact, keeps its
    //! length.
    Matrix<D> velocity_turn(double from, double to) const;
    //! The rotation of a spin (an angular velocity as seen in the frame): a free sphere keeps its own in space. With
    //! the Coriolis part. In the plane a spin stays.
    Matrix<3> spin_turn(double from, double to) const;
    //! d(spin)/dt of a free body, along the axis, as its mean [rad/s2]; with the Euler part.
    double spin_rate(double from, double to) const;
    std::array<double, 3> const& direction() const { return rotation_.direction; }

 private:
    sluice::Rotation rotation_;
};

}  // namespace frame
