#pragma once

#include "participants/dem/normal_force.hpp"
#include "participants/dem/rolling_resistance.hpp"
#include "participants/dem/tangential_force.hpp"

namespace dem {

//! All that acts in one contact: between grains, or between grains and one wall.
struct ContactLaw
{
    NormalForce normal;
    TangentialForce tangential;
    RollingResistance rolling;
};

//! Which velocities a law sees, and what belongs to the Coulomb limit.
enum class Scheme : unsigned char
{
    predicted,  //!< dashpots at the velocity predicted for the end of the step, contacts begin within the step: order 2
    liggghts    //!< as LIGGGHTS 3.8: all at the half step, dashpot outside the Coulomb test, spring projected, its arms
};

}  // namespace dem
