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
    std::array<double, 3> force;  //!< rho_0 a, of the coming step; in a frame that turns, of the cell x = 0 of a row
    //! In a frame that turns: by how much `force` grows from cell to cell along x, and the angular velocity (1/step),
    //! for the Coriolis force -2 w x j.
    std::array<double, 3> slope{}, turn{};
};

//! j of a cell, which has half of the force but of Coriolis', gets that half as well: j + w x j = b.
template <class V>
[[gnu::always_inline]] inline void turn_with_half(std::array<double, 3> const& w, V& x, V& y, V& z) noexcept
{
    double const share = 1 / (1 + w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    V const along = w[0] * x + w[1] * y + w[2] * z;
    V const a = share * (x + w[0] * along - (w[1] * z - w[2] * y)),
            b = share * (y + w[1] * along - (w[2] * x - w[0] * z)),
            c = share * (z + w[2] * along - (w[0] * y - w[1] * x));
    x = a, y = b, z = c;
}

//! The same in the plane, about its normal.
template <class V>
[[gnu::always_inline]] inline void turn_in_plane(double w, V& x, V& y) noexcept
{
    double const share = 1 / (1 + w * w);
    V const a = share * (x + w * y);
    y = share * (y - w * x);
    x = a;
}

inline Relaxation relaxation(Config const& c) noexcept
{
    double const tau = c.relaxation_time();
    double const shear = 1 / tau;
    double const unit = c.units().acceleration_unit();
    double const odd = 1 / (0.5 + c.magic / (tau - 0.5));
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
