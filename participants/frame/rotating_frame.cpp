#include "participants/frame/rotating_frame.hpp"

#include <algorithm>
#include <cmath>

namespace frame {
namespace {

//! The upper left D x D part: all of it in space, that of the plane perpendicular to the axis in the plane.
template <int D>
Matrix<D> part(Matrix<3> const& whole)
{
    Matrix<D> matrix{};
    for (std::size_t i = 0; i < D; ++i)
        for (std::size_t j = 0; j < D; ++j) matrix[i * D + j] = whole[i * 3 + j];
    return matrix;
}

//! s I + c n n^T + k [n]x for a unit vector n: whatever has only the axis as a direction is of this form.
Matrix<3> about(std::array<double, 3> const& n, double same, double along, double cross)
{
    auto const [x, y, z] = n;
    return {same + along * x * x,      along * x * y - cross * z, along * x * z + cross * y,
            along * y * x + cross * z, same + along * y * y,      along * y * z - cross * x,
            along * z * x - cross * y, along * z * y + cross * x, same + along * z * z};
}

Matrix<3> turn(std::array<double, 3> const& axis, double angle)
{
    return about(axis, std::cos(angle), 1.0 - std::cos(angle), std::sin(angle));
}

}  // namespace

template <int D>
double RotatingFrame<D>::rate(double time) const
{
    double const share = rotation_.ramp > 0.0 ? std::clamp(time / rotation_.ramp, 0.0, 1.0) : 1.0;
    return rotation_.rate * share;
}

template <int D>
double RotatingFrame<D>::angle(double from, double to) const
{
    auto const since_start = [&](double t) {
        double const ramp = rotation_.ramp;
        return rotation_.rate * (t < ramp ? 0.5 * t * t / ramp : t - 0.5 * ramp);
    };
    return since_start(to) - since_start(from);
}

template <int D>
Matrix<D> RotatingFrame<D>::centrifugal(double time) const
{
    double const square = rotation_.centrifugal ? rate(time) * rate(time) : 0.0;
    return part<D>(about(rotation_.direction, square, -square, 0.0));
}

template <int D>
Matrix<D> RotatingFrame<D>::euler(double from, double to) const
{
    return part<D>(about(rotation_.direction, 0.0, 0.0, spin_rate(from, to)));
}

template <int D>
Matrix<D> RotatingFrame<D>::velocity_turn(double from, double to) const
{
    return part<D>(turn(rotation_.direction, rotation_.coriolis ? -2.0 * angle(from, to) : 0.0));
}

template <int D>
Matrix<3> RotatingFrame<D>::spin_turn(double from, double to) const
{
    return turn(rotation_.direction, rotation_.coriolis ? -angle(from, to) : 0.0);
}

template <int D>
double RotatingFrame<D>::spin_rate(double from, double to) const
{
    return rotation_.euler ? (rate(from) - rate(to)) / (to - from) : 0.0;
}

template class RotatingFrame<2>;
template class RotatingFrame<3>;

}  // namespace frame
