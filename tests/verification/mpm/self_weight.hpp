#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/verification/mpm/bars.hpp"

namespace verification {

//! Mean error of the vertical stress of a column of 10 m under its own weight, by rho0 g L0.
inline double self_weight_error(mpm::BasisKind basis, mpm::Width width, int cells, double& settlement)
{
    double const length = 10, gravity = 9.81, density = 80;
    mpm::Config c = bar(length, cells, 2, 1);
    c.basis = basis;
    c.affine = basis != mpm::BasisKind::linear;
    c.width = width;
    c.density = density;
    c.law = mpm::LinearElastic{{1e4, 0}};
    c.damping = 1.0;  // 1/s: a quarter of critical for the first mode
    auto solver = mpm::make_solver<2>(c);
    std::vector<double> depth;  // L0 - Y
    for (auto const& p : solver.state().points) depth.push_back(length - p.place[1]);
    double const ramp = 40 * length / std::sqrt(1e4 / density);
    while (solver.time() < 1.5 * ramp) {
        solver.set_gravity({0, -gravity * std::min(1.0, solver.time() / ramp)});
        solver.step(solver.longest_step());
    }
    double sum = 0;
    for (std::size_t p = 0; p < depth.size(); ++p)
        sum += std::abs(solver.state().points[p].matter.stress(1, 1) + density * gravity * depth[p]);
    settlement = 0;
    for (std::size_t p = 0; p < depth.size(); ++p)
        settlement = std::max(settlement, length - depth[p] - solver.state().points[p].place[1]);
    return sum / (density * gravity * length * static_cast<double>(depth.size()));
}

}  // namespace verification
