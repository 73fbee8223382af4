#pragma once

#include "participants/mpm/tensor.hpp"

namespace mpm {

//! Isotropic linear elasticity: stress = (K - 2/3 G) tr(strain) I + 2 G strain.
struct Elasticity
{
    double youngs_modulus;  //!< E [Pa]
    double poissons_ratio;  //!< [-], below 1/2

    double shear() const { return youngs_modulus / (2 * (1 + poissons_ratio)); }     //!< G [Pa]
    double bulk() const { return youngs_modulus / (3 * (1 - 2 * poissons_ratio)); }  //!< K [Pa]
    double lame() const { return bulk() - 2.0 / 3 * shear(); }                       //!< K - 2/3 G [Pa]
    double wave() const { return bulk() + 4.0 / 3 * shear(); }                       //!< K + 4/3 G [Pa]

    Mat3 stress(Mat3 const& strain) const { return lame() * strain.trace() * Mat3::Identity() + 2 * shear() * strain; }
    Mat3 strain(Mat3 const& stress) const
    {
        return ((1 + poissons_ratio) * stress - poissons_ratio * stress.trace() * Mat3::Identity()) / youngs_modulus;
    }
    //! Stored by a stress [J/m3].
    double energy(Mat3 const& stress) const { return 0.5 * contract(stress, strain(stress)); }
};

}  // namespace mpm
