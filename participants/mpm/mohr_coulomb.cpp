#include "participants/mpm/mohr_coulomb.hpp"

#include <algorithm>
#include <cmath>

#include "participants/mpm/laws.hpp"

namespace mpm {
namespace {

constexpr double rounding = 1e-13;  //!< of the stresses at hand: how far beyond a face still counts as on it

Vec3 axis(int i)
{
    return Vec3::Unit(i);
}

}  // namespace

MohrCoulombSurface::MohrCoulombSurface(Elasticity const& e, MohrCoulombParameters const& p)
    : parameters_(p), shear_(e.shear()), bulk_(e.bulk())
{
    double const sin_phi = std::sin(p.friction_angle), sin_psi = std::sin(p.dilation_angle);
    cone_ = sin_phi > 0 ? p.cohesion / std::tan(p.friction_angle) : HUGE_VAL;
    tip_ = std::min(p.tension, cone_);
    auto const add = [&](Vec3 const& normal, Vec3 const& flow, double limit, bool tension) {
        Vec3 const relief = e.lame() * flow.sum() * Vec3::Ones() + 2 * shear_ * flow;
        face_[faces_++] = {normal, flow, relief, limit, tension};
    };
    for (auto const& [i, j] : {std::pair{0, 2}, std::pair{0, 1}, std::pair{1, 2}})
        add((1 + sin_phi) * axis(i) - (1 - sin_phi) * axis(j), (1 + sin_psi) * axis(i) - (1 - sin_psi) * axis(j),
            2 * p.cohesion * std::cos(p.friction_angle), false);
    if (std::isfinite(tip_))
        for (int i = 0; i < 3; ++i) add(axis(i), axis(i), tip_, true);
    for (std::size_t a = 0; a < faces_; ++a) set_[sets_++] = {{a, 0, 0}, 1};
    for (std::size_t a = 0; a < faces_; ++a)
        for (std::size_t b = a + 1; b < faces_; ++b) set_[sets_++] = {{a, b, 0}, 2};
    for (std::size_t a = 0; a < faces_; ++a)
        for (std::size_t b = a + 1; b < faces_; ++b)
            for (std::size_t c = b + 1; c < faces_; ++c) set_[sets_++] = {{a, b, c}, 3};
}

double MohrCoulombSurface::excess(Vec3 const& stress) const
{
    double largest = -HUGE_VAL;
    for (std::size_t k = 0; k < faces_; ++k) largest = std::max(largest, face_[k].normal.dot(stress) - face_[k].limit);
    return largest;
}

//! Multipliers x of K faces: normal_a . (trial - sum_b x_b relief_b) = limit_a.
template <int K>
bool MohrCoulombSurface::try_set(Set const& set, Vec3 const& trial, double tolerance, Returned& out) const
{
    Mat<K> matrix;
    Vec<K> right;
    for (int a = 0; a < K; ++a) {
        Face const& row = face_[set.face[static_cast<std::size_t>(a)]];
        right[a] = row.normal.dot(trial) - row.limit;
        for (int b = 0; b < K; ++b) matrix(a, b) = row.normal.dot(face_[set.face[static_cast<std::size_t>(b)]].relief);
    }
    if (std::abs(matrix.determinant()) <= 1e-12 * std::pow(matrix.cwiseAbs().maxCoeff(), K)) return false;
    Vec<K> const multiplier = matrix.inverse() * right;
    if (!(multiplier.minCoeff() * shear_ >= -tolerance)) return false;
    Vec3 stress = trial;
    double opened = 0;
    for (int a = 0; a < K; ++a) {
        Face const& face = face_[set.face[static_cast<std::size_t>(a)]];
        stress -= multiplier[a] * face.relief;
        if (face.tension) opened += multiplier[a];
    }
    if (!(excess(stress) <= tolerance)) return false;
    out = {stress, opened, true};
    return true;
}

MohrCoulombSurface::Returned MohrCoulombSurface::bring_back(Vec3 const& trial) const
{
    double const tolerance = rounding * (trial.cwiseAbs().maxCoeff() + face_[0].limit) * (1 + bulk_ / shear_);
    if (excess(trial) <= tolerance) return {trial, 0, false};
    Returned out;
    for (std::size_t k = 0; k < sets_; ++k) {
        Set const& set = set_[k];
        bool const found = set.count == 1   ? try_set<1>(set, trial, tolerance, out)
                           : set.count == 2 ? try_set<2>(set, trial, tolerance, out)
                                            : try_set<3>(set, trial, tolerance, out);
        if (found) return out;
    }
    Vec3 const tip = tip_ * Vec3::Ones();
    return {tip, std::max(0.0, (trial.mean() - tip_) / bulk_), true};
}

Mat3 close_gap(Matter& m, Increment const& step, Elasticity const& elasticity)
{
    double const closing = std::min(m.gap, -step.strain.trace());
    if (!(closing > 0 && m.stress.trace() <= rounding * elasticity.youngs_modulus)) return Mat3::Zero();
    m.gap -= closing;
    return -closing / 3 * Mat3::Identity();
}

double MohrCoulomb::respond(Matter& m, Increment const& step) const
{
    Mat3 flow = close_gap(m, step, elasticity);  // strain that no stress follows
    Mat3 const trial = step.turned(m.stress) + elasticity.stress(step.strain - flow);
    Principal const p = principal(trial);
    auto const back = surface.bring_back(p.value);
    m.stress = back.plastic ? p.tensor(back.stress) : trial;
    if (back.plastic) {
        Mat3 const yielded = elasticity.strain(trial - m.stress);
        Mat3 const deviator = yielded - yielded.trace() / 3 * Mat3::Identity();
        m.gap += back.opened;
        m.plastic_strain += std::sqrt(2.0 / 3 * deviator.squaredNorm());
        flow += yielded;
    }
    return contract(m.stress, flow);
}

}  // namespace mpm
