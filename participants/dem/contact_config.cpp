#include <cmath>
#include <limits>
#include <numbers>

#include "participants/dem/config.hpp"
#include "participants/dem/restitution.hpp"

namespace dem {
namespace {

using sluice::Reader;

void read_damping(Reader& r, ContactConfig& c, bool has_fallback)
{
    bool const ratio = r.has("damping_ratio"), restitution_given = r.has("restitution");
    if (ratio == restitution_given && (ratio || !has_fallback))
        r.problem(ratio ? "restitution" : "damping_ratio",
                  ratio ? "is a second damping (give damping_ratio or restitution)."
                        : "is missing (give damping_ratio or restitution).");
    auto const alpha = r.number_if("damping_ratio", {.min = 0.0, .max = 0.95});
    auto const e = r.number_if("restitution", {.min = 0.15, .max = 1.0});
    if (alpha)
        c.damping_ratio = *alpha;
    else if (e)
        c.damping_ratio = damping_ratio_for(*e, c.may_pull);
}

void read_linear(Reader& r, ContactConfig& c, bool has_fallback)
{
    double const ratio = c.normal_stiffness > 0.0 ? c.tangential_stiffness / c.normal_stiffness : 2.0 / 7.0;
    auto const bounds = sluice::Bounds{.min = 1.0, .max = 1e12, .unit = "N/m"};
    c.normal_stiffness = has_fallback ? r.number_or("normal_stiffness", c.normal_stiffness, bounds)
                                      : r.number("normal_stiffness", bounds);
    c.tangential_stiffness = c.normal_stiffness * r.number_or("tangential_ratio", ratio, {.min = 0.01, .max = 1.0});
}

void read_hertz(Reader& r, ContactConfig& c, bool has_fallback)
{
    sluice::Bounds const modulus{.min = 1e3, .max = 1e13, .unit = "Pa"}, poisson{.min = 0.0, .max = 0.5};
    c.youngs_modulus =
        has_fallback ? r.number_or("youngs_modulus", c.youngs_modulus, modulus) : r.number("youngs_modulus", modulus);
    c.poissons_ratio = r.number_or("poissons_ratio", has_fallback ? c.poissons_ratio : 0.25, poisson);
}

void read_rolling(Reader& r, ContactConfig& c)
{
    c.rolling_friction = r.number_or("rolling_friction", c.rolling_friction, {.min = 0.0, .max = 6.0});
    if (c.rolling_friction == 0.0) {
        c.rolling = Rolling::none;
        return;
    }
    auto const law = r.choice_or("rolling", c.rolling == Rolling::constant ? 1 : 0, {"elastic_plastic", "constant"});
    c.rolling = law == 0 ? Rolling::elastic_plastic : Rolling::constant;
    if (c.rolling == Rolling::constant) return;
    // kr = kt as Luding (2008); alpha_r = 0.3 as Ai et al. (2011): without it a grain at rest keeps rocking
    c.rolling_stiffness = r.number_or("rolling_ratio", c.rolling_stiffness > 0.0 ? c.rolling_stiffness : 1.0,
                                      {.min = 0.001, .max = 10.0});
    c.rolling_damping =
        r.number_or("rolling_damping", c.rolling_damping > 0.0 ? c.rolling_damping : 0.3, {.min = 0.0, .max = 0.95});
}

}  // namespace

double read_friction(Reader& r, std::optional<double> fallback)
{
    bool const coefficient = r.has("friction"), angle = r.has("friction_angle");
    if (coefficient && angle) r.problem("friction_angle", "is a second friction (give friction or friction_angle).");
    if (!coefficient && !angle && !fallback)
        r.problem("friction", "is missing (give friction [-] or friction_angle [degrees]).");
    auto const degrees = r.number_if("friction_angle", {.min = 0.0, .max = 80.0, .unit = "degrees"});
    auto const mu = r.number_if("friction", {.min = 0.0, .max = 6.0});
    if (mu) return *mu;
    if (degrees) return std::tan(*degrees * std::numbers::pi / 180.0);
    return fallback.value_or(0.0);
}

ContactConfig read_contact(Reader r, std::optional<ContactConfig> const& fallback)
{
    ContactConfig c = fallback.value_or(ContactConfig{});
    if (!fallback)  // where the word is wrong, what stands beside it tells which law was meant: one mistake, one
                    // message
        c.elasticity = static_cast<Elasticity>(
            r.choice_or("law", r.has("law") && r.has("youngs_modulus") ? 1 : 0, {"linear", "hertz"}));
    c.may_pull = r.flag_or("may_pull", c.may_pull);
    if (c.elasticity == Elasticity::linear)
        read_linear(r, c, fallback.has_value());
    else
        read_hertz(r, c, fallback.has_value());
    read_damping(r, c, fallback.has_value());
    double const tangential = fallback                            ? c.tangential_damping
                              : c.elasticity == Elasticity::hertz ? c.damping_ratio
                                                                  : 0.0;
    c.tangential_damping = r.number_or("tangential_damping", tangential, {.min = 0.0, .max = 0.95});
    c.friction = read_friction(r, fallback ? std::optional(c.friction) : std::nullopt);
    read_rolling(r, c);
    if (c.rolling != Rolling::none && c.friction == 0.0)
        r.problem("rolling_friction", "needs friction (a contact without friction does not make grains roll).");
    r.finish();
    return c;
}

ContactLaw contact_law(ContactConfig const& c)
{
    ContactLaw law;
    law.normal.floor = c.may_pull ? -std::numeric_limits<double>::infinity() : 0.0;
    double kt = 0.0, c_t = 0.0;
    if (c.elasticity == Elasticity::linear) {
        law.normal.stiffness = c.normal_stiffness;
        law.normal.damping = 2.0 * c.damping_ratio * std::sqrt(c.normal_stiffness);
        kt = c.tangential_stiffness;
        c_t = 2.0 * c.tangential_damping * std::sqrt(kt);
    } else {  // E* and G* of two partners of the same matter
        double const nu = c.poissons_ratio, modulus = c.youngs_modulus / (2.0 * (1.0 - nu * nu));
        double const shear = c.youngs_modulus / (4.0 * (1.0 + nu) * (2.0 - nu));
        double const tsuji = 2.0 * std::sqrt(5.0 / 6.0);
        law.normal.stiffness = 4.0 / 3.0 * modulus;
        law.normal.damping = tsuji * c.damping_ratio * std::sqrt(2.0 * modulus);
        kt = 8.0 * shear;
        c_t = tsuji * c.tangential_damping * std::sqrt(kt);
    }
    if (c.friction > 0.0) law.tangential = {.stiffness = kt, .damping = c_t, .friction = c.friction};
    if (c.rolling != Rolling::none)
        law.rolling = {.friction = c.rolling_friction,
                       .stiffness = c.rolling_stiffness,
                       .damping = 2.0 * c.rolling_damping * std::sqrt(c.rolling_stiffness)};
    return law;
}

double contact_time_of(ContactConfig const& c, int dimension, double mass, double radius)
{
    double normal = c.normal_stiffness, tangential = c.tangential_stiffness;
    if (c.elasticity == Elasticity::hertz) {
        ContactLaw const law = contact_law(c);
        double const pair = 0.5 * radius, patch = std::sqrt(pair * 0.01 * radius);  // R*, sqrt(R* xi)
        normal = 1.5 * law.normal.stiffness * patch;                                // 2 E* sqrt(R* xi)
        tangential = law.tangential.stiffness * patch;
    }
    return contact_time(normal, c.friction > 0.0 ? tangential : 0.0, 0.5 * mass, dimension);
}

}  // namespace dem
