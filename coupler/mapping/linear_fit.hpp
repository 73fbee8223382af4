#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "coupler/mapping/places.hpp"

namespace sluice {

//! The weighted least-squares linear function through n places x_j, in their principal axes:
//!     f(x) = sum_j w_j (1/W + sum_k g_jk y_k / lambda_k) f_j,   g_j, y: x_j and x in these axes, from the weighted
//!     mean.
//! Axes thinner than 1e-4 of the thickest are left out: the function is constant along them.
template <int D>
class LinearFit
{
 public:
    //! weights >= 0, at least one > 0.
    LinearFit(Places<D> const& at, std::vector<double> const& weight) : weight_(weight)
    {
        double heaviest = 0;
        mean_.setZero();
        for (std::size_t j = 0; j < at.size(); ++j) {
            total_ += weight[j];
            mean_ += weight[j] * (at[j] - at[0]);
            heaviest = std::max(heaviest, weight[j]);
        }
        mean_ = at[0] + mean_ / total_;
        Eigen::Matrix<double, D, D> spread = Eigen::Matrix<double, D, D>::Zero();
        for (std::size_t j = 0; j < at.size(); ++j) spread += weight[j] * (at[j] - mean_) * (at[j] - mean_).transpose();
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D, D>> const solver(spread);
        axes_ = solver.eigenvectors();
        local_.reserve(at.size());
        for (Place<D> const& x : at) local_.push_back(axes_.transpose() * (x - mean_));
        for (int k = 0; k < D; ++k) {
            double const lambda = solver.eigenvalues()[k];
            bool const thick = lambda > 1e-8 * solver.eigenvalues()[D - 1];
            inverse_[k] = thick ? 1 / lambda : 0;
            reach_[k] = thick ? 4 * std::sqrt(lambda / total_) : 0;
            for (std::size_t j = 0; thick && j < at.size(); ++j)
                if (weight[j] == heaviest) reach_[k] = std::max(reach_[k], std::abs(local_[j][k]));
        }
    }

    int rank() const { return static_cast<int>((inverse_.array() > 0).count()); }

    struct Local
    {
        Place<D> place;  //!< in the principal axes
        bool clamped = false;
    };
    //! Where the function is to be evaluated for x: at most 4 standard deviations, or the furthest of the heaviest
    //! places, from the mean along each axis.
    Local local(Place<D> const& x) const
    {
        Place<D> const y = axes_.transpose() * (x - mean_);
        Place<D> const kept = y.cwiseMin(reach_).cwiseMax(-reach_);
        return {kept, ((kept - y).array() != 0 && inverse_.array() > 0).any()};
    }

    //! Adds to a row of n weights what it lacks to be exact at y for linear functions. Twice, for rounding's sake: the
    //! mean and the axes are not exact.
    void complete(Place<D> const& y, double* row) const
    {
        for (int pass = 0; pass < 2; ++pass) {
            double lack = 1;
            Place<D> moment = y;
            for (std::size_t j = 0; j < local_.size(); ++j) {
                lack -= row[j];
                moment -= row[j] * local_[j];
            }
            Place<D> const slope = moment.cwiseProduct(inverse_);
            for (std::size_t j = 0; j < local_.size(); ++j)
                row[j] += weight_[j] * (lack / total_ + local_[j].dot(slope));
        }
    }

 private:
    std::vector<double> const& weight_;
    double total_ = 0;
    Place<D> mean_, inverse_, reach_;
    Eigen::Matrix<double, D, D> axes_;
    Places<D> local_;
};

}  // namespace sluice
