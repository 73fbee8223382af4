#include "participants/mpm/law_config.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "coupler/scene/reader.hpp"

namespace mpm {
namespace {

constexpr double degree = std::numbers::pi / 180;

MohrCoulomb read_mohr_coulomb(sluice::Reader& r, Elasticity const& elasticity)
{
    MohrCoulombParameters p;
    sluice::Bounds const angle{.min = 0.0, .below = 90.0, .unit = "degrees"};
    double const phi = r.number("friction_angle", angle), psi = r.number_or("dilation_angle", 0.0, angle);
    p.friction_angle = phi * degree;
    p.dilation_angle = psi * degree;
    p.cohesion = r.number_or("cohesion", 0.0, {.min = 0.0, .unit = "Pa"});
    double const tip = phi > 0 ? p.cohesion / std::tan(p.friction_angle) : HUGE_VAL;
    p.tension = r.number_if("tension", {.min = 0.0, .unit = "Pa"}).value_or(tip);
    char text[160];
    if (psi > phi) {
        std::snprintf(text, sizeof text, "degrees (must be at most friction_angle = %g degrees)", phi);
        r.refuse("dilation_angle", text);
    }
    if (p.tension > tip) {
        std::snprintf(text, sizeof text, "Pa (must be at most c cot(phi) = %g Pa, the tip of the cone)", tip);
        r.refuse("tension", text);
    }
    if (phi == 0 && p.cohesion == 0)
        r.problem("friction_angle", "= 0 without cohesion bears no shear (needs friction_angle or cohesion above 0).");
    return {elasticity, MohrCoulombSurface(elasticity, p)};
}

}  // namespace

Law read_law(sluice::Reader& r)
{
    std::size_t const which = r.choice("law", {"mohr_coulomb", "linear_elastic", "neo_hookean"});
    Elasticity e;
    e.youngs_modulus = r.number("youngs_modulus", {.above = 0.0, .unit = "Pa"});
    e.poissons_ratio = r.number("poissons_ratio", {.min = 0.0, .below = 0.5});
    if (which == 0) return read_mohr_coulomb(r, e);
    if (which == 1) return LinearElastic{e};
    return NeoHookean{e};
}

Elasticity const& elasticity_of(Law const& law)
{
    return std::visit([](auto const& l) -> Elasticity const& { return l.elasticity; }, law);
}

}  // namespace mpm
