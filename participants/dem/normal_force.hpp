#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace dem {

enum class Elasticity : unsigned char
{
    linear,  //!< spring and dashpot, Cundall and Strack (1979)
    hertz    //!< elastic spheres, Hertz (1882), damped as Tsuji et al., Powder Technology 71 (1992) 239
};

//! How stiff one contact is at its present overlap.
struct Stiffness
{
    double force;       //!< elastic normal force [N]
    double energy;      //!< that it has stored [J]
    double normal;      //!< of the dashpot: c sqrt(m*) is its coefficient; here c [sqrt(N/m)]
    double tangential;  //!< kt [N/m]
    double slip;        //!< of the tangential dashpot, as `normal` [sqrt(N/m)]
};

//! Normal force  Fn = max(floor, Fe + c sqrt(m*) xi_dot)   [N], m* = mi mj/(mi + mj), for a wall the grain's mass.
//!   linear  Fe = kn xi,                      c = 2 alpha sqrt(kn):              alpha is the damping ratio
//!   hertz   Fe = 4/3 E* sqrt(R* xi) xi,      c = 2 alpha sqrt(5/6) sqrt(Sn),    Sn = 2 E* sqrt(R* xi)
//! floor = 0 keeps the dashpot from pulling at the end of a contact: the force is zero from the moment spring and
//! dashpot cancel, the overlap relaxes freely. Restitution then follows restitution.hpp. floor = -inf leaves it.
//! For hertz c is the form of Antypov and Elliott, EPL 94 (2011) 50004: e does not depend on the speed.
struct NormalForce
{
    double stiffness = 0.0;  //!< linear: kn [N/m]; hertz: 4/3 E* [Pa]
    double damping = 0.0;    //!< linear: 2 alpha sqrt(kn) [sqrt(N/m)]; hertz: 2 alpha sqrt(5/6) sqrt(2 E*) [sqrt(Pa)]
    double floor = 0.0;      //!< 0: never pulls; -infinity: may pull [N]

    double limited(double force) const noexcept { return std::max(floor, force); }
};

}  // namespace dem
