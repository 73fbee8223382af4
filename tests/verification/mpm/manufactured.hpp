#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/verification/mpm/bars.hpp"

//! M09: the method of manufactured solutions in a unit square whose displacement is along the axes (Wallstedt and
//! Guilkey, J. Comput. Phys. 227 (2008) 9628; file M09_gimp_mms.csv):
//!
//!     u = A sin(pi X) sin(c pi t),   v = A sin(pi Y) sin(c pi t + pi),   c = sqrt(E / rho)
//!
//! with the body force that makes it a solution of each law, at a point's first place X, Y. Large deformation, points
//! cross cells. Places, and with them F and stress, run half a step ahead of velocities, so a run starts.
namespace verification::manufactured {

constexpr double A = 0.05, modulus = 1e7, density = 1000, pi = std::numbers::pi;
inline double const c = std::sqrt(modulus / density);
inline mpm::Elasticity const elastic{modulus, 0.3};

inline double phase(int axis, double t)
{
    return c * pi * t + axis * pi;
}
inline double displacement(double X, int axis, double t)
{
    return A * std::sin(pi * X) * std::sin(phase(axis, t));
}
inline double stretch(double X, int axis, double t)
{
    return 1 + A * pi * std::cos(pi * X) * std::sin(phase(axis, t));
}

//! Force per mass [m/s2].
inline mpm::Vec<2> body_force(mpm::Law const& law, mpm::Vec<2> const& X, double t)
{
    mpm::Vec<2> out;
    double const lame = elastic.lame(), shear = elastic.shear();
    double const J = stretch(X[0], 0, t) * stretch(X[1], 1, t);
    for (int k : {0, 1}) {
        double const u = displacement(X[k], k, t), own = stretch(X[k], k, t), other = stretch(X[1 - k], 1 - k, t);
        if (std::holds_alternative<mpm::NeoHookean>(law))
            out[k] = pi * pi * u / density *
                     (lame * (1 - std::log(J)) / (own * own) + shear * (1 + 1 / (own * own)) - modulus);
        else  // stress = C : ln(stretch)
            out[k] = -std::pow(c * pi, 2) * u + pi * pi * u / density * elastic.wave() * other / own;
    }
    return out;
}

inline mpm::Law true_strain()
{
    return mpm::LinearElastic{elastic};
}

//! Root of the mean square of what lies between places and the solution, by A; over points and one period.
inline double rms_deviation(mpm::Law const& law, int cells, mpm::Scheme scheme, bool affine, mpm::Width width,
                            mpm::BasisKind basis = mpm::BasisKind::gimp)
{
    mpm::Config config;
    config.cell = 1.0 / cells;
    config.size = {1, 1, 0};
    config.flip = 1;
    config.density = density;
    config.law = law;
    config.scheme = scheme;
    config.affine = affine;
    config.width = width;
    config.basis = basis;
    config.bodies.push_back({.low = {0, 0, 0}, .high = {1, 1, 0}});
    for (int axis : {0, 1})
        for (int side : {-1, 1}) config.walls.push_back({.axis = axis, .side = side, .place = side < 0 ? 0.0 : 1.0});
    auto const setup = mpm::make_setup<2>(config);
    auto state = mpm::make_state<2>(config);
    double const period = 2 / c, fastest = std::sqrt(elastic.wave() / density) + A * c * pi;
    double const dt = period / std::ceil(period / (0.2 * config.cell / fastest));
    std::vector<mpm::Vec<2>> first, loads(state.points.size());
    for (auto& p : state.points) {
        first.push_back(p.place);
        for (int k : {0, 1}) {
            double const X = first.back()[k];
            p.velocity[k] = A * c * pi * std::sin(pi * X) * std::cos(phase(k, 0));
            p.slope(k, k) = A * c * pi * pi * std::cos(pi * X) * std::cos(phase(k, 0)) / stretch(X, k, 0.5 * dt);
            p.place[k] += displacement(X, k, 0.5 * dt);
            p.matter.gradient(k, k) = stretch(X, k, 0.5 * dt);
        }
        auto& m = p.matter;
        m.ratio = m.gradient.determinant();
        mpm::Mat3 const logarithm = m.gradient.diagonal().array().log().matrix().asDiagonal();
        m.stress = elastic.stress(logarithm);
        if (std::holds_alternative<mpm::NeoHookean>(law))
            std::get<mpm::NeoHookean>(law).respond(m, mpm::Increment(mpm::Mat3::Identity()));
    }
    mpm::Solver<2> solver(setup, state);
    double sum = 0, count = 0;
    while (solver.time() < period - 0.5 * dt) {
        double const t = solver.time() + 0.5 * dt;
        for (std::size_t p = 0; p < loads.size(); ++p) loads[p] = state.points[p].mass * body_force(law, first[p], t);
        solver.set_loads(loads);
        solver.step(dt);
        for (std::size_t p = 0; p < loads.size(); ++p) {
            mpm::Vec<2> off = solver.state().points[p].place - first[p];
            for (int k : {0, 1}) off[k] -= displacement(first[p][k], k, t + dt);
            sum += off.squaredNorm() / (A * A), ++count;
        }
    }
    return std::sqrt(sum / count);
}

}  // namespace verification::manufactured
