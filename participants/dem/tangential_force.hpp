#pragma once

#include <cmath>

namespace dem {

//! Tangential force of a spring with memory and a dashpot, limited by Coulomb:
//!     trial = kt zeta + 2 alpha_t sqrt(kt m*) s,      |Ft| = min(mu Fn, |trial|)   [N], against the slip s.
//! The dashpot is inside the limit. In sliding the spring is cut back so that spring + dashpot equals the limit.
//! In the plane the spring is one signed number along the tangent, so it turns with the contact by itself.
//! Source: Cundall and Strack (1979); cut as in Luding, Granular Matter 10 (2008), sec. 3.
struct TangentialForce
{
    double stiffness = 0.0;          //!< kt [N/m], > 0 where there is friction
    double inverse_stiffness = 0.0;  //!< 1/kt [m/N]
    double damping = 0.0;            //!< 2 alpha_t sqrt(kt) [sqrt(N/m)]
    double friction = 0.0;           //!< mu [-], >= 0

    struct Result
    {
        double force;   //!< spring + dashpot after the limit [N]
        double spring;  //!< elongation after the cut [m]
        bool slides;
    };

    //! zeta [m], already stretched by this step's slip; s [m/s]; Fn [N]; sqrt(m*) [sqrt(kg)]
    Result operator()(double spring, double slip, double normal_force, double sqrt_mass) const noexcept
    {
        double const dashpot = damping * sqrt_mass * slip;
        double const trial = stiffness * spring + dashpot;
        double const limit = friction * normal_force;
        bool const sticks = std::abs(trial) <= limit;
        double const force = sticks ? trial : std::copysign(limit, trial);
        return {force, sticks ? spring : (force - dashpot) * inverse_stiffness, !sticks};
    }
};

inline TangentialForce make_tangential_force(double stiffness, double damping_ratio, double friction)
{
    return {.stiffness = stiffness,
            .inverse_stiffness = stiffness > 0.0 ? 1.0 / stiffness : 0.0,
            .damping = 2.0 * damping_ratio * std::sqrt(stiffness),
            .friction = friction};
}

}  // namespace dem
