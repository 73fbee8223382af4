#include "participants/mpm/tensor.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <utility>

namespace mpm {
namespace {

void sort(Principal& p)
{
    auto const order = [&](int a, int b) {
        if (p.value[a] >= p.value[b]) return;
        std::swap(p.value[a], p.value[b]);
        p.direction.col(a).swap(p.direction.col(b));
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
}

//! Nothing couples z to the plane.
Principal of_plane(Mat3 const& a)
{
    double const mean = 0.5 * (a(0, 0) + a(1, 1)), half = 0.5 * (a(0, 0) - a(1, 1));
    double const radius = std::hypot(half, a(0, 1));
    double const angle = 0.5 * std::atan2(a(0, 1), half);
    double const c = std::cos(angle), s = std::sin(angle);
    Principal p{{mean + radius, mean - radius, a(2, 2)}, Mat3::Identity()};
    p.direction.col(0) << c, s, 0;
    p.direction.col(1) << -s, c, 0;
    return p;
}

}  // namespace

Principal principal(Mat3 const& a)
{
    if (a(0, 2) == 0 && a(1, 2) == 0) {
        Principal p = of_plane(a);
        sort(p);
        return p;
    }
    Eigen::SelfAdjointEigenSolver<Mat3> const solver(a);
    Principal p{solver.eigenvalues(), solver.eigenvectors()};
    sort(p);
    return p;
}

}  // namespace mpm
