#pragma once

#include <cmath>
#include <variant>

#include "participants/mpm/elasticity.hpp"
#include "participants/mpm/mohr_coulomb.hpp"

//! How stress follows deformation. Each law is a policy with
//!
//!     respond(matter, increment)  the stress at the end of a step; what it dissipated [J/m3 at the end of the step]
//!     energy(matter)              stored elastically [J/m3]
//!     wave_modulus(matter)        rho c^2 of the fastest wave [Pa]
namespace mpm {

//! What a law knows of a point. Stress is Cauchy's, > 0 in tension.
struct Matter
{
    Mat3 gradient = Mat3::Identity();  //!< F, at the end of the step
    double ratio = 1;                  //!< J: volume over that at the start of the run
    Mat3 stress = Mat3::Zero();        //!< [Pa]
    double plastic_strain = 0;         //!< integral of sqrt(2/3 e:e) over plastic deviatoric increments e [-]
    double gap = 0;                    //!< logarithm of the volume opened by tension, that no stress holds [-]
};

//! Jaumann's rate of Cauchy's stress: s = turn s turn^T + C : strain. Uniaxial strain: s = (K + 4/3 G) ln(stretch), to
//! third order in the step.
struct LinearElastic
{
    Elasticity elasticity;

    double respond(Matter& m, Increment const& step) const
    {
        m.stress = step.turned(m.stress) + elasticity.stress(step.strain);
        return 0;
    }
    double energy(Matter const& m) const { return elasticity.energy(m.stress); }
    double wave_modulus(Matter const&) const { return elasticity.wave(); }
};

//! Compressible neo-Hookean solid, J s = G (F F^T - I) + L ln J I, L = K - 2/3 G. Source: Bonet and Wood, Nonlinear
//! Continuum Mechanics for Finite Element Analysis (2008), sec. 6.4.3.
struct NeoHookean
{
    Elasticity elasticity;

    double respond(Matter& m, Increment const&) const
    {
        Mat3 const one = Mat3::Identity();
        m.stress = (elasticity.shear() * (m.gradient * m.gradient.transpose() - one) +
                    elasticity.lame() * std::log(m.ratio) * one) /
                   m.ratio;
        return 0;
    }
    double energy(Matter const& m) const
    {
        double const ln = std::log(m.ratio);
        double const stored = 0.5 * elasticity.shear() * (m.gradient.squaredNorm() - 3) - elasticity.shear() * ln +
                              0.5 * elasticity.lame() * ln * ln;
        return stored / m.ratio;
    }
    //! Along a principal direction of stretch k: (L (1 - ln J) + G (1 + k^2)) / J; k^2 <= |F|^2 - 2 for the largest if
    //! the others are 1, and never above |F|^2.
    double wave_modulus(Matter const& m) const
    {
        double const ln = std::log(m.ratio);
        return (elasticity.lame() * std::max(0.0, 1 - ln) + elasticity.shear() * (1 + m.gradient.squaredNorm())) /
               m.ratio;
    }
};

//! Mohr and Coulomb: linear elastic as above, then returned to the surface (mohr_coulomb.hpp). What tension opens is
//! kept as a gap that has to close before pressure builds up again.
struct MohrCoulomb
{
    Elasticity elasticity;
    MohrCoulombSurface surface;

    double respond(Matter& m, Increment const& step) const;
    double energy(Matter const& m) const { return elasticity.energy(m.stress); }
    double wave_modulus(Matter const&) const { return elasticity.wave(); }
};

using Law = std::variant<LinearElastic, NeoHookean, MohrCoulomb>;

}  // namespace mpm
