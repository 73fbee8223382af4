#pragma once

#include "participants/mpm/elasticity.hpp"

namespace mpm {

//! Which circle the cone of Drucker and Prager is drawn through, of Mohr and Coulomb's hexagon.
enum class Cone
{
    plane_strain,  //!< fails alike in plane strain, for this dilation
    compression,   //!< through the edges of triaxial compression: the outer one
    extension      //!< through those of triaxial extension
};

//! Angles in radians.
struct DruckerPragerParameters
{
    double friction_angle = 0;  //!< phi, 0 to below pi/2
    double dilation_angle = 0;  //!< psi, 0 to phi
    double cohesion = 0;        //!< c [Pa]
    double tension = 0;         //!< largest mean stress T [Pa], at most that of the tip; infinity: none (phi = 0)
    Cone cone = Cone::plane_strain;
};

//! A cone about the axis of equal stress, cut off at a mean stress: with the mean stress p > 0 in tension, the deviator
//! s and t = sqrt(s:s / 2)
//!
//!     t + slope p <= limit,   p <= T,   plastic strain along s / (2 t) + flow / 3 I; along I at the cut-off
//!
//! and the return to it, in closed form: to the cone, to the cut-off, to the circle where they meet, to the tip.
class DruckerPragerSurface
{
 public:
    DruckerPragerSurface(Elasticity const& elasticity, DruckerPragerParameters const& parameters);

    //! In terms of the two invariants.
    struct Returned
    {
        double mean, shear;  //!< p, t [Pa]
        double opened = 0;   //!< volume strain that tension made [-]
        bool plastic = false;
    };
    Returned bring_back(double mean, double shear) const;
    //! The larger excess over cone and cut-off [Pa]; <= 0: within.
    double excess(double mean, double shear) const;
    double slope() const { return slope_; }
    double flow() const { return flow_; }
    double limit() const { return limit_; }  //!< [Pa]
    double tip() const { return tip_; }      //!< largest mean stress [Pa]

 private:
    double slope_, flow_, limit_, tip_;
    double shear_, bulk_;
};

}  // namespace mpm
