#pragma once

#include <type_traits>

#include "participants/dem/state.hpp"

//! What acts on every grain in half a step besides contacts and loads: in the first half a kick, then a turn of the
//! velocity; in the second a turn, then a kick. Both halves together are symmetric in time, hence of second order, and
//! turns keep the speed (the splitting of Boris for charged particles in a magnetic field).
namespace dem {

template <std::size_t N>
Vec2 times(std::array<double, N> const& m, Vec2 v) requires(N == 4)
{
    return {m[0] * v.x + m[1] * v.y, m[2] * v.x + m[3] * v.y};
}
template <std::size_t N>
Vec3 times(std::array<double, N> const& m, Vec3 v) requires(N == 9)
{
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
            m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

template <int D>
Vec<D> point_of_axis(frame::RotatingFrame<D> const& frame)
{
    Vec<D> point{};
    for (int k = 0; k < D; ++k) component<D>(point, k) = frame.point(k);
    return point;
}

//! A spin of this size about an axis.
template <int D>
Spin<D> spin_of(double size, std::array<double, 3> const& axis)
{
    if constexpr (D == 2)
        return size * axis[2];
    else
        return size * Vec3{axis[0], axis[1], axis[2]};
}

//! Gravity alone, the same everywhere.
template <int D>
struct StillHalf
{
    Vec<D> half_fall;  //!< dt/2 g [m/s]

    Vec<D> fall(Vec<D> const&) const { return half_fall; }
    Vec<D> velocity(Vec<D> const& v) const { return v; }
    Spin<D> const& spin(Spin<D> const& s) const { return s; }
    Spin<D> const& twist(Spin<D> const& turn) const { return turn; }
};

//! Gravity in a frame that turns. Buoyancy takes its share of gravity and of the centrifugal part, which a fluid at
//! rest in the frame bears by its pressure; not of the others.
template <int D>
class TurningHalf
{
 public:
    //! The half of a step of dt that begins at `from` [s]; gravity and the centrifugal part are those at `kick_time`.
    TurningHalf(Setup<D> const& setup, double from, double kick_time, double dt)
        : axis_(point_of_axis(*setup.frame)),
          fall_(0.5 * dt * setup.gravity_at(kick_time)),
          pull_(setup.frame->centrifugal(kick_time)),
          turn_(setup.frame->velocity_turn(from, from + 0.5 * dt)),
          spin_turn_(setup.frame->spin_turn(from, from + 0.5 * dt)),
          twist_(spin_of<D>(0.5 * dt * setup.frame->spin_rate(from, from + 0.5 * dt), setup.frame->direction()))
    {
        auto const push = setup.frame->euler(from, from + 0.5 * dt);
        for (std::size_t k = 0; k < pull_.size(); ++k) pull_[k] = 0.5 * dt * (setup.weight * pull_[k] + push[k]);
    }

    Vec<D> fall(Vec<D> const& centre) const { return fall_ + times(pull_, centre - axis_); }
    Vec<D> velocity(Vec<D> const& v) const { return times(turn_, v); }
    Spin<D> spin(Spin<D> const& s) const
    {
        if constexpr (D == 2)
            return s;
        else
            return times(spin_turn_, s);
    }
    Spin<D> twist(Spin<D> const& turn) const { return turn + twist_; }

 private:
    Vec<D> axis_, fall_;
    frame::Matrix<D> pull_, turn_;
    frame::Matrix<3> spin_turn_;
    Spin<D> twist_;
};

}  // namespace dem
