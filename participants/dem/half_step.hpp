#pragma once

#include <type_traits>

#include "participants/dem/pack.hpp"
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

//! A matrix for products with many vectors: in space by its columns, all rows at once, added up in the same order.
template <int D>
struct Factor
{
    Factor(frame::Matrix<D> const& m) : matrix(m) {}
    Vec<D> operator()(Vec<D> const& v) const { return times(matrix, v); }

    frame::Matrix<D> matrix;
};
template <>
struct Factor<3>
{
    Factor(frame::Matrix<3> const& m) : x{m[0], m[3], m[6], 0.0}, y{m[1], m[4], m[7], 0.0}, z{m[2], m[5], m[8], 0.0} {}
    Vec3 operator()(Vec3 const& v) const
    {
        Pack const product = x * all(v.x) + y * all(v.y) + z * all(v.z);
        return {product[0], product[1], product[2]};
    }

    Pack x, y, z;
};

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
          pull_(pull(setup, from, kick_time, dt)),
          turn_(setup.frame->velocity_turn(from, from + 0.5 * dt)),
          spin_turn_(setup.frame->spin_turn(from, from + 0.5 * dt)),
          twist_(spin_of<D>(0.5 * dt * setup.frame->spin_rate(from, from + 0.5 * dt), setup.frame->direction()))
    {}

    Vec<D> fall(Vec<D> const& centre) const { return fall_ + pull_(centre - axis_); }
    Vec<D> velocity(Vec<D> const& v) const { return turn_(v); }
    Spin<D> spin(Spin<D> const& s) const
    {
        if constexpr (D == 2)
            return s;
        else
            return spin_turn_(s);
    }
    Spin<D> twist(Spin<D> const& turn) const { return turn + twist_; }

 private:
    //! What the distance from the axis is multiplied with for the kick [1/s].
    static frame::Matrix<D> pull(Setup<D> const& setup, double from, double kick_time, double dt)
    {
        auto matrix = setup.frame->centrifugal(kick_time);
        auto const push = setup.frame->euler(from, from + 0.5 * dt);
        for (std::size_t k = 0; k < matrix.size(); ++k) matrix[k] = 0.5 * dt * (setup.weight * matrix[k] + push[k]);
        return matrix;
    }

    Vec<D> axis_, fall_;
    Factor<D> pull_, turn_;
    Factor<3> spin_turn_;
    Spin<D> twist_;
};

}  // namespace dem
