#pragma once

namespace dem {

enum class Rolling : unsigned char
{
    none,
    elastic_plastic,  //!< spring, dashpot and limit: a grain that rolls stops, and stays
    constant          //!< torque mu_r Fn R* against the relative spin, whatever its size: chatters at rest
};

//! Resistance to relative rolling. The rolling velocity is R* (wi - wj) x n, with R* = Ri Rj/(Ri + Rj), for a wall R; a
//! quasi-force Fr against it, as friction has it (tangential_force.hpp), acts as the torque -R* n x Fr on i and the
//! opposite on j.
//!   elastic_plastic   spring kr, dashpot 2 alpha_r sqrt(kr m*), limit mu_r Fn; kr = ratio kt. The dashpot is gone when
//!                     the limit is reached.
//!   constant          Fr = mu_r Fn along the rolling velocity
//! Source: Luding, Granular Matter 10 (2008), sec. 3; Ai, Chen, Rotter and Ooi, Powder Technology 206 (2011) 269 (types
//! A and C).
struct RollingResistance
{
    double friction = 0.0;   //!< mu_r [-], >= 0
    double stiffness = 0.0;  //!< kr/kt [-]
    double damping = 0.0;    //!< 2 alpha_r sqrt(kr/kt) [-]: times sqrt(kt m*) it is the dashpot
};

}  // namespace dem
