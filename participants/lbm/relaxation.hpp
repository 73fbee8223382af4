#pragma once

#include "participants/lbm/config.hpp"

namespace lbm {

//! Rates [1/step] of the moments of Lallemand and Luo (2000), and what else one collision needs, in lattice units.
//! One collision serves all operators: equal rates are BGK, one rate for the even and one for the odd moments is TRT.
struct Relaxation
{
    double energy;                //!< s_e
    double square;                //!< s_eps
    double flux;                  //!< s_q
    double shear;                 //!< s_nu = 1/tau
    double tau;                   //!< of the molecular viscosity
    double smagorinsky_term;      //!< 18 C_s^2: tau_eff = (tau + sqrt(tau^2 + 18 C_s^2 |(p_xx, 2 p_xy)|/rho))/2
    std::array<double, 3> force;  //!< rho_0 a
};

inline Relaxation relaxation(Config const& c) noexcept
{
    double const tau = c.relaxation_time();
    double const shear = 1 / tau;
    double const odd = 1 / (0.5 + c.magic / (tau - 0.5));
    double const unit = c.units().acceleration_unit();
    Relaxation r{.energy = c.energy_rate,
                 .square = c.square_rate,
                 .flux = c.flux_rate.value_or(odd),
                 .shear = shear,
                 .tau = tau,
                 .smagorinsky_term = 18 * c.smagorinsky * c.smagorinsky,
                 .force = {c.acceleration[0] / unit, c.acceleration[1] / unit, c.acceleration[2] / unit}};
    if (c.collision == Operator::trt) {
        r.energy = r.square = shear;
        r.flux = odd;
    } else if (c.collision == Operator::bgk) {
        r.energy = r.square = r.flux = shear;
    }
    return r;
}

}  // namespace lbm
