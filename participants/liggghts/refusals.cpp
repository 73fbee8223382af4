#include <cmath>
#include <cstdio>
#include <limits>

#include "participants/liggghts/script.hpp"

namespace liggghts {
namespace {

using dem::ContactConfig;

//! Whether a vector lies along x, y or z.
bool is_axial(dem::Vec3 const& v)
{
    return (v.x != 0.0) + (v.y != 0.0) + (v.z != 0.0) == 1;
}

std::string number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

void look_at_contact(ContactConfig const& c, std::string const& whose, std::vector<Refusal>& found)
{
    bool const hertz = c.elasticity == dem::Elasticity::hertz;
    if (hertz && c.tangential_damping > 0.0 && c.tangential_damping != c.damping_ratio)
        found.push_back({"contact", whose + "have tangential_damping " + number(c.tangential_damping) +
                                        ", which is not damping_ratio (LIGGGHTS' hertz has one dashpot for both, or "
                                        "none along the contact). Leave it out, or give 0."});
    if (hertz && c.damping_ratio > 0.68)  // LIGGGHTS takes a restitution of 0.05 or more
        found.push_back({"contact", whose + "have damping_ratio " + number(c.damping_ratio) +
                                        " (LIGGGHTS' hertz takes at most 0.68). Try a smaller one, or law: linear."});
}

void look_at_rolling(ContactConfig const& c, ContactConfig const& grains, char const* key, std::string const& who,
                     std::vector<Refusal>& found)
{
    if (c.rolling == dem::Rolling::elastic_plastic && !rolls_by_epsd3(c, grains) && c.rolling_stiffness != 1.0)
        found.push_back({key, who + " rolling with rolling_ratio " + number(c.rolling_stiffness) +
                                  " (LIGGGHTS' epsd3 has one stiffness for grains and walls of one rolling_friction, "
                                  "at most the root of rolling_ratio kt/kn; its epsd2 has rolling_ratio: 1). Give 1."});
}

void look_at_wall(dem::WallConfig const& wall, dem::Config const& config, std::vector<Refusal>& found)
{
    auto const refuse = [&](std::string const& text) { found.push_back({"walls", "\"" + wall.name + "\" " + text}); };
    std::string const by_script = " Give it as a mesh in an input script of yours (config.script).";
    if (wall.mesh)
        refuse("is a mesh, which is not handed to LIGGGHTS." + by_script);
    else if (!(wall.radius > 0.0 && config.dimension == 2) && !is_axial(wall.normal))
        refuse("is oblique (LIGGGHTS' own walls are normal to x, y or z)." + by_script);
    if (wall.motion.moves()) refuse("moves (LIGGGHTS' own walls stand still)." + by_script);
    ContactConfig const &own = wall.contact, &grains = config.contact;
    if (own.elasticity == dem::Elasticity::hertz &&
        (own.youngs_modulus != grains.youngs_modulus || own.poissons_ratio != grains.poissons_ratio))
        refuse("is of other matter than the grains (needed with hertz: the same youngs_modulus and poissons_ratio).");
    look_at_rolling(own, grains, "walls", "\"" + wall.name + "\" resists", found);
    look_at_contact(own, "contacts of \"" + wall.name + "\" ", found);
}

}  // namespace

double rolling_stiffness(ContactConfig const& c)
{
    double kn = c.normal_stiffness, kt = c.tangential_stiffness;
    if (c.elasticity == dem::Elasticity::hertz) {  // both go with the root of R* xi
        auto const law = dem::contact_law(c);
        kn = law.normal.stiffness;
        kt = law.tangential.stiffness;
    }
    return c.rolling_stiffness * kt / (kn * c.rolling_friction * c.rolling_friction);
}

bool rolls_by_epsd3(ContactConfig const& c, ContactConfig const& grains)
{
    double const number = rolling_stiffness(grains);
    return number >= 1.0 && c.rolling_friction == grains.rolling_friction &&  // LIGGGHTS takes no smaller one
           std::abs(rolling_stiffness(c) - number) < 1e-12 * number;
}

std::vector<Refusal> refusals(dem::Config const& config)
{
    std::vector<Refusal> found;
    auto const none = [&](bool wanted, char const* key, char const* text) {
        if (wanted) found.push_back({key, text});
    };
    none(config.periodic.any(), "periodic", "is not handed to LIGGGHTS. Try solver: dem.");
    none(config.gravity_ramp > 0.0, "gravity_ramp", "is not handed to LIGGGHTS. Try solver: dem.");
    none(config.lubrication.any(), "lubrication", "is no force that LIGGGHTS has. Try solver: dem.");
    none(config.sleep.any(), "sleep", "is nothing that LIGGGHTS can do. Leave it out.");
    none(config.measures[dem::Measure::drift].wanted || config.measures[dem::Measure::force_chains].wanted, "measures",
         "asks for what LIGGGHTS keeps to itself: drift, force_chains. Leave them out, or try solver: dem.");
    none(!config.averages.empty(), "averages", "needs contact forces, which LIGGGHTS keeps to itself. Leave it out.");
    look_at_contact(config.contact, "contacts ", found);
    look_at_rolling(config.contact, config.contact, "contact", "resists", found);
    for (auto const& wall : config.walls) look_at_wall(wall, config, found);
    return found;
}

std::vector<std::string> differences(dem::Config const& config, SizeClasses const& classes)
{
    std::vector<std::string> said;
    ContactConfig const& c = config.contact;
    if (classes.spread > 0.0 && c.elasticity == dem::Elasticity::linear &&
        (c.damping_ratio > 0.0 || c.tangential_damping > 0.0))
        said.push_back("LIGGGHTS: dashpots go by " + std::to_string(classes.classes.size()) +
                       " classes of grains, not by each grain's mass: they are off by up to " +
                       number(100.0 * classes.spread) + " %.");
    if (c.rolling == dem::Rolling::constant)
        said.emplace_back(
            "LIGGGHTS: cdt, its constant resistance to rolling, goes with the elastic part of the normal force.");
    auto const without_dashpot = [&](ContactConfig const& of, std::string const& where) {
        if (of.rolling == dem::Rolling::elastic_plastic && !rolls_by_epsd3(of, c) && of.rolling_damping > 0.0)
            said.push_back("LIGGGHTS: rolling " + where + " is by epsd2, without rolling_damping.");
    };
    without_dashpot(c, "of grains on grains");
    for (auto const& wall : config.walls) without_dashpot(wall.contact, "on \"" + wall.name + "\"");
    if (config.threads > 1) said.emplace_back("LIGGGHTS: it has no threads. Give ranks instead.");
    return said;
}

}  // namespace liggghts
