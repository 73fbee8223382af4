#pragma once

#include <array>

#include "participants/mpm/elasticity.hpp"

namespace mpm {

//! Angles in radians. Stress > 0 in tension.
struct MohrCoulombParameters
{
    double friction_angle = 0;  //!< phi, 0 to below pi/2
    double dilation_angle = 0;  //!< psi, 0 to phi
    double cohesion = 0;        //!< c [Pa]
    double tension = 0;         //!< largest principal stress T [Pa], at most c cot(phi); infinity: none (phi = 0)
};

//! The convex set of principal stresses s1 >= s2 >= s3 with
//!
//!     (1 + sin phi) si - (1 - sin phi) sj <= 2 c cos phi    for ij = 13, 12, 23
//!     si <= T                                               for i = 1, 2, 3
//!
//! and the return to it: s = trial - C (sum of multiplier x flow), flow as the left side with psi in place of phi,
//! along si for tension. All of it is linear, hence a return to a face, an edge or a corner is a small linear system;
//! the first set of faces (fewest first) with multipliers >= 0 whose stress breaks no other face is the answer
//! (Koiter). With psi < phi there may be none for stress beyond the tip: then the tip, T I, is.
class MohrCoulombSurface
{
 public:
    MohrCoulombSurface(Elasticity const& elasticity, MohrCoulombParameters const& parameters);

    struct Returned
    {
        Vec3 stress;        //!< principal, in the order of the trial
        double opened = 0;  //!< volume strain that tension made [-]
        bool plastic = false;
    };
    //! `trial`: largest first [Pa].
    Returned bring_back(Vec3 const& trial) const;
    //! The largest excess over any face [Pa]; <= 0: within.
    double excess(Vec3 const& stress) const;
    MohrCoulombParameters const& parameters() const { return parameters_; }
    double tip() const { return tip_; }  //!< largest stress that is the same along all axes [Pa]
    //! Whether the tip is that of the cone, and no tension cuts it off.
    bool tip_is_of_cone() const { return parameters_.tension >= cone_; }

 private:
    static constexpr std::size_t most = 6;
    struct Face
    {
        Vec3 normal, flow, relief;  //!< relief = C flow: stress taken by a multiplier of one
        double limit = 0;           //!< [Pa]
        bool tension = false;
    };
    struct Set
    {
        std::array<std::size_t, 3> face{};
        std::size_t count = 0;
    };
    template <int K>
    bool try_set(Set const& set, Vec3 const& trial, double tolerance, Returned& out) const;

    MohrCoulombParameters parameters_;
    double cone_;  //!< c cot(phi), or infinity [Pa]
    double tip_;   //!< T, or the tip of the cone [Pa]
    double shear_, bulk_;
    std::array<Face, most> face_{};
    std::size_t faces_ = 0;
    std::array<Set, 41> set_{};
    std::size_t sets_ = 0;
};

}  // namespace mpm
