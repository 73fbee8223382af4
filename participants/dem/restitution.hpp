#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

//! Closed forms of one collision under NormalForce, with w = sqrt(1 - alpha^2), w0 = sqrt(kn/m*). They hold for hertz
//! as well: in the plane of velocity and xi^(5/4) its equation is the linear one.
//! Source: Schwager and Poeschel, Granular Matter 9 (2007) 465; Antypov and Elliott, EPL 94 (2011) 50004.
namespace dem {

//! Phase at which spring and dashpot cancel: pi - atan2(2 alpha w, 1 - 2 alpha^2)   [rad]
inline double release_phase(double damping_ratio)
{
    double const w = std::sqrt(1.0 - damping_ratio * damping_ratio);
    return std::numbers::pi - std::atan2(2.0 * damping_ratio * w, 1.0 - 2.0 * damping_ratio * damping_ratio);
}

//! e = exp(-(alpha/w) phase)   [-];  0 <= alpha < 1. Phase: release_phase, or pi for a force that may pull.
inline double restitution(double damping_ratio, bool may_pull = false)
{
    double const phase = may_pull ? std::numbers::pi : release_phase(damping_ratio);
    return std::exp(-damping_ratio / std::sqrt(1.0 - damping_ratio * damping_ratio) * phase);
}

//! Time from first touch until the force is zero: phase / (w0 w)   [s]; linear law
inline double release_time(double damping_ratio, double stiffness, double reduced_mass)
{
    double const w = std::sqrt(1.0 - damping_ratio * damping_ratio);
    return release_phase(damping_ratio) / (std::sqrt(stiffness / reduced_mass) * w);
}

//! The damping ratio that gives a restitution, by bisection;  restitution(0.999) < e <= 1
inline double damping_ratio_for(double wanted, bool may_pull = false)
{
    double low = 0.0, high = 0.999;  // e falls with alpha
    for (int i = 0; i < 60; ++i) {
        double const middle = 0.5 * (low + high);
        (restitution(middle, may_pull) > wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

//! Half period of the stiffest mode of a pair, t_c = pi sqrt(m*/kn)   [s]: what a step is a fraction of.
//! The tangential mode has stiffness kt (1 + m R^2/I) = 3 kt for discs, 3.5 kt for spheres: the stiffer of the two.
inline double contact_time(double normal_stiffness, double tangential_stiffness, double reduced_mass, int dimension = 2)
{
    double const lever = dimension == 2 ? 3.0 : 3.5;
    return std::numbers::pi * std::sqrt(reduced_mass / std::max(normal_stiffness, lever * tangential_stiffness));
}

}  // namespace dem
