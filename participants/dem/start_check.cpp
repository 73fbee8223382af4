#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "participants/dem/config_parts.hpp"
#include "participants/dem/contact.hpp"
#include "participants/dem/neighbours.hpp"
#include "participants/dem/setup.hpp"

namespace dem {
namespace {

//! Energy of a spring at this overlap [J].
double energy_of(ContactConfig const& contact, double overlap, double effective_radius)
{
    return stiffness_of(contact.elasticity, contact_law(contact), overlap, effective_radius).energy;
}

//! The contacts at the start: how deep, and what they hold.
struct Overlaps
{
    double deepest = 0.0;  //!< over Ri + Rj, at a wall over 2 R [-]
    double energy = 0.0;   //!< [J]
    std::string where;     //!< the deepest is

    template <class Name>
    void add(double share, double joule, Name&& name)
    {
        energy += joule;
        if (share <= deepest) return;
        deepest = share;
        where = name();
    }
};

//! Overlapping grains push each other apart: their elastic energy becomes motion (sweep D8). Where one's centre is
//! within the other, nobody knows which way.
template <int D>
void check_overlaps(sluice::Reader& r, char const* key, Config& config, Setup<D> const& setup, Grains<D> const& grains)
{
    std::vector<std::uint32_t> first, other;
    find_pairs(grains, 0.0, first, other);
    Overlaps found;
    auto const name = [&](std::size_t i) { return std::to_string(grains.id[i]); };
    for (std::size_t i = 0; i < grains.size(); ++i)
        for (std::uint32_t slot = first[i]; slot < first[i + 1]; ++slot) {
            std::size_t const j = other[slot];
            auto const &a = grains.place[i], &b = grains.place[j];
            double const reach = a.radius + b.radius, apart = norm(a.centre - b.centre), overlap = reach - apart;
            if (apart < std::max(a.radius, b.radius)) {
                r.problem(key, "the centre of grain " + name(a.radius < b.radius ? i : j) + " lies within grain " +
                                   name(a.radius < b.radius ? j : i) +
                                   " (must be outside). Move one of them, or leave it out.");
                return;
            }
            found.add(overlap / reach, energy_of(config.contact, overlap, a.radius * b.radius / reach),
                      [&] { return "grains " + name(i) + " and " + name(j); });
        }
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        for (std::size_t i = 0; i < grains.size(); ++i) {
            auto const& [centre, radius] = grains.place[i];
            double const overlap = radius - facing_at_start(setup.walls[w], centre).distance;
            if (overlap > 0.0)
                found.add(0.5 * overlap / radius, energy_of(config.walls[w].contact, overlap, radius),
                          [&] { return "grain " + name(i) + " and wall \"" + setup.walls[w].name + "\""; });
        }
    if (found.deepest <= 0.01) return;
    char text[256];
    std::snprintf(text, sizeof text,
                  "dem: grains overlap at the start by up to %g of a diameter; the contacts hold "
                  "%g J that will set them in motion. Deepest: ",
                  found.deepest, found.energy);
    config.warnings.push_back(text + found.where + ".");
}

//! What each wall has behind it: the first grain and how many.
template <int D>
void refuse_outside(sluice::Reader& r, char const* key, Setup<D> const& setup, Grains<D> const& grains)
{
    for (Wall<D> const& wall : setup.walls) {
        std::size_t count = 0, first = 0;
        for (std::size_t i = 0; i < grains.size(); ++i)
            if (!(facing_at_start(wall, grains.place[i].centre).distance > 0.0) && count++ == 0) first = i;
        if (count > 0)
            r.problem(key, "the centre of grain " + std::to_string(grains.id[first]) +
                               (count > 1 ? " (one of " + std::to_string(count) + ")" : "") + " is behind wall \"" +
                               wall.name +
                               "\" (must be on the side its normal points to). Turn the normal or move it.");
    }
}

//! A grain must fit between walls that face each other, and into a cylinder.
void refuse_too_large(sluice::Reader& r, char const* key, Config const& config, double diameter)
{
    auto const refuse = [&](std::string const& where, double room) {
        char text[192];
        std::snprintf(text, sizeof text,
                      "the largest grain, of %g m, is too large for %s, %g m (must be at most that).", diameter,
                      where.c_str(), room);
        r.problem(key, text);
    };
    for (auto a = config.walls.begin(); a != config.walls.end(); ++a) {
        if (a->radius > 0.0 && a->inside && 2.0 * a->radius < diameter)
            refuse("the cylinder \"" + a->name + "\"", 2.0 * a->radius);
        for (auto b = std::next(a); b != config.walls.end(); ++b) {
            if (a->mesh || b->mesh || a->radius > 0.0 || b->radius > 0.0 || norm(a->normal + b->normal) > 1e-9)
                continue;
            double const gap = dot(b->point - a->point, a->normal);
            if (gap > 0.0 && gap < diameter) refuse("the gap of \"" + a->name + "\" and \"" + b->name + "\"", gap);
        }
    }
}

void refuse_several_densities(sluice::Reader& r, Config const& config)
{
    if (config.fluid_density == 0.0) return;
    auto const is_other = [&](GrainConfig const& g) { return g.density > 0.0 && g.density != config.density; };
    if (std::any_of(config.grains.begin(), config.grains.end(), is_other))
        r.problem("buoyancy", "needs grains of one density; " + config.grains_from +
                                  " has several (give density, which then counts for all).");
}

template <int D>
void check(sluice::Reader& r, char const* key, Config& config)
{
    Setup<D> const setup = make_setup<D>(config);
    Grains<D> const grains = listed_grains<D>(config);
    refuse_outside(r, key, setup, grains);
    if (r.diagnostics()->problems.empty()) check_overlaps(r, key, config, setup, grains);
}

}  // namespace

void check_start(sluice::Reader& r, Config& config)
{
    if (!r.diagnostics()->problems.empty()) return;
    char const* const key = config.column ? "column" : config.grains_from.empty() ? "grains" : "packing";
    refuse_too_large(r, key, config, diameters(config).second);
    refuse_several_densities(r, config);
    if (config.grains.empty()) return;
    config.dimension == 2 ? check<2>(r, key, config) : check<3>(r, key, config);
}

}  // namespace dem
