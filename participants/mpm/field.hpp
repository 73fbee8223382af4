#pragma once

#include <algorithm>

#include "participants/mpm/state.hpp"

//! What acts on matter at a distance: gravity, and a frame of reference that turns.
namespace mpm {

template <int D>
Vec<D> point_of_axis(frame::RotatingFrame<D> const& frame)
{
    Vec<D> point;
    for (int k = 0; k < D; ++k) point[k] = frame.point(k);
    return point;
}

template <int D>
Mat<D> matrix_of(frame::Matrix<D> const& rows)
{
    return Eigen::Map<Eigen::Matrix<double, D, D, Eigen::RowMajor> const>(rows.data());
}

//! The field of one step. A velocity gets half of the acceleration, is turned by Coriolis, and gets the other half (the
//! splitting of Boris for charged particles in a magnetic field): symmetric in time, and the turn keeps every speed.
template <int D>
class Field
{
 public:
    Field(Setup<D> const& setup, double time, double dt) : gravity_(setup.gravity)
    {
        if (!setup.frame) return;
        axis_ = point_of_axis(*setup.frame);
        pull_ =
            matrix_of<D>(setup.frame->centrifugal(time + 0.5 * dt)) + matrix_of<D>(setup.frame->euler(time, time + dt));
        turn_ = matrix_of<D>(setup.frame->velocity_turn(time, time + dt));
    }

    //! Linear in the place, so that the weights of the nodes give a point what its own place would [m/s2].
    Vec<D> acceleration(Vec<D> const& place) const { return gravity_ + pull_ * (place - axis_); }
    Vec<D> turned(Vec<D> const& velocity) const { return turn_ * velocity; }
    Vec<D> const& axis() const { return axis_; }
    Mat<D> const& pull() const { return pull_; }  //!< d(acceleration)/d(place) [1/s2]
    Mat<D> const& turn() const { return turn_; }

 private:
    Vec<D> gravity_, axis_ = Vec<D>::Zero();
    Mat<D> pull_ = Mat<D>::Zero(), turn_ = Mat<D>::Identity();
};

//! Of gravity and of the centrifugal acceleration at a time, zero at the origin and on the axis [J/kg].
template <int D>
class Potential
{
 public:
    Potential(Setup<D> const& setup, double time) : gravity_(setup.gravity)
    {
        if (!setup.frame) return;
        axis_ = point_of_axis(*setup.frame);
        pull_ = matrix_of<D>(setup.frame->centrifugal(time));
    }

    double operator()(Vec<D> const& place) const
    {
        Vec<D> const r = place - axis_;
        return -gravity_.dot(place) - 0.5 * r.dot(pull_ * r);
    }

 private:
    Vec<D> gravity_, axis_ = Vec<D>::Zero();
    Mat<D> pull_ = Mat<D>::Zero();
};

}  // namespace mpm
