#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

//! Vectors and tensors of the plane (x right, y up) and of space (z up). Stress is a tensor of space in both: plane
//! strain has a stress across the plane.
namespace mpm {

template <int D>
using Vec = Eigen::Matrix<double, D, 1>;
template <int D>
using Mat = Eigen::Matrix<double, D, D>;
using Vec3 = Vec<3>;
using Mat3 = Mat<3>;

//! A tensor of the plane as one of space, with `rest` on the diagonal where it has nothing.
inline Mat3 in_space(Mat<2> const& a, double rest)
{
    Mat3 out = rest * Mat3::Identity();
    out.topLeftCorner<2, 2>() = a;
    return out;
}
inline Mat3 const& in_space(Mat3 const& a, double)
{
    return a;
}

//! a : b
inline double contract(Mat3 const& a, Mat3 const& b)
{
    return a.cwiseProduct(b).sum();
}

//! What a step does to the surroundings of a point: the increment of the deformation gradient, I + dt dv/dx, split into
//! stretch and turn about the middle of the step (Hughes and Winget, Int. J. Numer. Meth. Eng. 15 (1980) 1862):
//!
//!     G = (dF - I) ((dF + I)/2)^-1,   strain = sym G,   turn = (I - skew G / 2)^-1 (I + skew G / 2)
//!
//! For a rigid rotation dF = R, strain = 0 and turn = R, exactly, however large.
struct Increment
{
    Mat3 strain;      //!< [-]
    Mat3 turn;        //!< orthogonal
    double ratio;     //!< det dF: volume after over before
    double duration;  //!< [s]; 0 where no law asks

    explicit Increment(Mat3 const& dF, double dt = 0) : ratio(dF.determinant()), duration(dt)
    {
        Mat3 const one = Mat3::Identity();
        Mat3 const G = 2.0 * (dF - one) * (dF + one).inverse();
        strain = 0.5 * (G + G.transpose());
        Mat3 const half = 0.25 * (G - G.transpose());
        turn = (one - half).inverse() * (one + half);
    }
    Mat3 turned(Mat3 const& a) const { return turn * a * turn.transpose(); }
};

//! Principal values, largest first, and their directions as columns.
struct Principal
{
    Vec3 value;
    Mat3 direction;

    Mat3 tensor(Vec3 const& values) const { return direction * values.asDiagonal() * direction.transpose(); }
};
Principal principal(Mat3 const& symmetric);

}  // namespace mpm
