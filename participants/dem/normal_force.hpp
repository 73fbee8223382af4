#pragma once

#include <cassert>
#include <cmath>

namespace dem {

//! Normal force of a linear spring and dashpot:  Fn = max(0, kn xi + 2 alpha sqrt(kn m*) xi_dot)   [N].
//! m* is the reduced mass mi mj / (mi + mj); for a wall the grain's own mass. alpha is then the damping ratio.
//! The clamp keeps the dashpot from pulling at the end of a contact: the force is zero from the moment spring and
//! dashpot cancel, the overlap relaxes freely. Restitution then follows restitution.hpp.
//! Source: Cundall and Strack (1979); clamp as Schwager and Poeschel (2007).
struct NormalForce
{
    double stiffness = 0.0;  //!< kn [N/m], > 0
    double damping = 0.0;    //!< 2 alpha sqrt(kn) [sqrt(N/m)]; times sqrt(m*) it is the dashpot [N s/m]

    double operator()(double overlap, double rate, double sqrt_mass) const noexcept  // xi [m], xi_dot [m/s], [sqrt(kg)]
    {
        assert(overlap >= 0.0);
        double const force = stiffness * overlap + damping * sqrt_mass * rate;
        return force > 0.0 ? force : 0.0;
    }
};

inline NormalForce make_normal_force(double stiffness, double damping_ratio)
{
    return {.stiffness = stiffness, .damping = 2.0 * damping_ratio * std::sqrt(stiffness)};
}

}  // namespace dem
