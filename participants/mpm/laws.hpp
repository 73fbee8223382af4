#pragma once

#include <cmath>
#include <numbers>
#include <variant>

#include "participants/mpm/drucker_prager.hpp"
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

//! The gap beyond which a point is loose: the points of its cell, two along each axis, are a cell apart then and touch
//! no more. What one by itself knows of the gradient of velocities is its turn: a stretch would go on for ever in
//! flight.
template <int D>
constexpr double loose = double{D} * std::numbers::ln2;

//! Laws whose stress stands for an elastic strain, by Hooke.
struct Hookean
{
    Elasticity elasticity;

    double energy(Matter const& m) const { return elasticity.energy(m.stress); }
    double wave_modulus(Matter const&) const { return elasticity.wave(); }
};

//! Jaumann's rate of Cauchy's stress: s = turn s turn^T + C : strain. Uniaxial strain: s = (K + 4/3 G) ln(stretch), to
//! third order in the step.
struct LinearElastic : Hookean
{
    double respond(Matter& m, Increment const& step) const
    {
        m.stress = step.turned(m.stress) + elasticity.stress(step.strain);
        return 0;
    }
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

//! What tension opened is kept as a gap that has to close before pressure builds up again. Returns the strain that does
//! so without stress.
Mat3 close_gap(Matter& matter, Increment const& step, Elasticity const& elasticity);

//! Mohr and Coulomb: linear elastic as above, then returned to the surface (mohr_coulomb.hpp).
struct MohrCoulomb : Hookean
{
    MohrCoulombSurface surface;

    double respond(Matter& m, Increment const& step) const;
};

//! Drucker and Prager: the same with their surface (drucker_prager.hpp).
struct DruckerPrager : Hookean
{
    DruckerPragerSurface surface;

    double respond(Matter& m, Increment const& step) const;
};

//! Dense grains whose friction grows with the rate g at which they are sheared: linear elastic, and with the pressure
//! p, the deviator s and t = sqrt(s:s / 2)
//!
//!     t <= mu(I) p,   mu(I) = mu_s + (mu_2 - mu_s) / (1 + I0 / I),   I = g d sqrt(rho_s / p)
//!
//! plastic strain along s, which keeps the volume; no tension: what is pulled apart opens a gap. g is the plastic rate,
//! so that below mu_s p nothing flows and nothing has to be regularised. Sources: Jop, Forterre and Pouliquen, Nature
//! 441 (2006) 727; the closed form of a step: Dunatunga and Kamrin, J. Fluid Mech. 779 (2015) 483.
struct MuOfI : Hookean
{
    double static_friction;  //!< mu_s
    double limit_friction;   //!< mu_2
    double inertial_number;  //!< I0
    double grain_diameter;   //!< d [m]
    double grain_density;    //!< rho_s [kg/m3]

    //! t at the end of a step of which `trial` was the elastic one [Pa].
    double shear_stress(double pressure, double trial, double dt) const;
    double respond(Matter& m, Increment const& step) const;
};

using Law = std::variant<LinearElastic, NeoHookean, MohrCoulomb, DruckerPrager, MuOfI>;

//! Whether it yields.
inline bool is_plastic(Law const& law)
{
    return !std::holds_alternative<LinearElastic>(law) && !std::holds_alternative<NeoHookean>(law);
}

}  // namespace mpm
