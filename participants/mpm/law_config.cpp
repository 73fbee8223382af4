#include "participants/mpm/law_config.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "coupler/scene/reader.hpp"

namespace mpm {
namespace {

constexpr double degree = std::numbers::pi / 180;

//! What both surfaces of soils are made of.
struct Strength
{
    double friction_angle, dilation_angle, cohesion;  //!< [rad], [rad], [Pa]
};

Strength read_strength(sluice::Reader& r)
{
    sluice::Bounds const angle{.min = 0.0, .below = 90.0, .unit = "degrees"};
    double const phi = r.number("friction_angle", angle), psi = r.number_or("dilation_angle", 0.0, angle);
    double const cohesion = r.number_or("cohesion", 0.0, {.min = 0.0, .unit = "Pa"});
    if (psi > phi) {
        char text[160];
        std::snprintf(text, sizeof text, "degrees (must be at most friction_angle = %g degrees)", phi);
        r.refuse("dilation_angle", text);
    }
    if (phi == 0 && cohesion == 0)
        r.problem("friction_angle", "= 0 without cohesion bears no shear (needs friction_angle or cohesion above 0).");
    return {phi * degree, psi * degree, cohesion};
}

//! Default: the tip of the cone, beyond which it may not be.
double read_tension(sluice::Reader& r, double tip, char const* what)
{
    double const tension = r.number_if("tension", {.min = 0.0, .unit = "Pa"}).value_or(tip);
    if (tension > tip) {
        char text[160];
        std::snprintf(text, sizeof text, "Pa (must be at most %s%g Pa, the tip of the cone)", what, tip);
        r.refuse("tension", text);
    }
    return tension;
}

MohrCoulomb read_mohr_coulomb(sluice::Reader& r, Elasticity const& elasticity)
{
    Strength const s = read_strength(r);
    double const tip = s.friction_angle > 0 ? s.cohesion / std::tan(s.friction_angle) : HUGE_VAL;
    MohrCoulombParameters const p{s.friction_angle, s.dilation_angle, s.cohesion,
                                  read_tension(r, tip, "c cot(phi) = ")};
    return {elasticity, MohrCoulombSurface(elasticity, p)};
}

DruckerPrager read_drucker_prager(sluice::Reader& r, Elasticity const& elasticity)
{
    Strength const s = read_strength(r);
    DruckerPragerParameters p{s.friction_angle, s.dilation_angle, s.cohesion, HUGE_VAL, Cone::plane_strain};
    p.cone = static_cast<Cone>(r.choice_or("cone", 0, {"plane_strain", "compression", "extension"}));
    p.tension = read_tension(r, DruckerPragerSurface(elasticity, p).tip(), "");
    return {elasticity, DruckerPragerSurface(elasticity, p)};
}

MuOfI read_mu_of_i(sluice::Reader& r, Elasticity const& elasticity)
{
    MuOfI law{elasticity, 0, 0, 0, 0, 0};
    law.static_friction = r.number("static_friction", {.above = 0.0});
    law.limit_friction = r.number("limit_friction", {.min = law.static_friction});
    law.inertial_number = r.number("inertial_number", {.above = 0.0});
    law.grain_diameter = r.number("grain_diameter", {.above = 0.0, .unit = "m"});
    law.grain_density = r.number("grain_density", {.above = 0.0, .unit = "kg/m3"});
    return law;
}

}  // namespace

Law read_law(sluice::Reader& r)
{
    std::size_t const which =
        r.choice("law", {"mohr_coulomb", "linear_elastic", "neo_hookean", "drucker_prager", "mu_of_i"});
    Elasticity e;
    e.youngs_modulus = r.number("youngs_modulus", {.above = 0.0, .unit = "Pa"});
    e.poissons_ratio = r.number("poissons_ratio", {.min = 0.0, .below = 0.5});
    if (which == 0) return read_mohr_coulomb(r, e);
    if (which == 1) return LinearElastic{e};
    if (which == 3) return read_drucker_prager(r, e);
    if (which == 4) return read_mu_of_i(r, e);
    return NeoHookean{e};
}

Elasticity const& elasticity_of(Law const& law)
{
    return std::visit([](auto const& l) -> Elasticity const& { return l.elasticity; }, law);
}

}  // namespace mpm
