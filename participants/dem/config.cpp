#include "participants/dem/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "participants/dem/neighbours.hpp"
#include "participants/dem/restitution.hpp"

namespace dem {
namespace {

using sluice::Reader;

std::string format(char const* pattern, double a, double b)
{
    char text[256];
    std::snprintf(text, sizeof text, pattern, a, b);
    return text;
}

//! `friction: mu` or `friction_angle: degrees`; exactly one where there is no fallback.
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

ContactConfig read_contact(Reader r)
{
    ContactConfig c;
    c.normal_stiffness = r.number("normal_stiffness", {.min = 1.0, .max = 1e12, .unit = "N/m"});
    bool const ratio = r.has("damping_ratio"), restitution_given = r.has("restitution");
    if (ratio == restitution_given)
        r.problem(ratio ? "restitution" : "damping_ratio",
                  ratio ? "is a second damping (give damping_ratio or restitution)."
                        : "is missing (give damping_ratio or restitution).");
    auto const alpha = r.number_if("damping_ratio", {.min = 0.0, .max = 0.95});
    auto const e = r.number_if("restitution", {.min = 0.15, .max = 1.0});
    if (alpha)
        c.damping_ratio = *alpha;
    else if (e)
        c.damping_ratio = damping_ratio_for(*e);
    c.tangential_stiffness = c.normal_stiffness * r.number_or("tangential_ratio", 2.0 / 7.0, {.min = 0.01, .max = 1.0});
    c.tangential_damping = r.number_or("tangential_damping", 0.0, {.min = 0.0, .max = 0.95});
    c.friction = read_friction(r, std::nullopt);
    r.finish();
    return c;
}

WallConfig read_wall(Reader r, double grain_friction)
{
    WallConfig w;
    w.name = r.text("name");
    auto const point = r.numbers("point", 2, {.min = -1e6, .max = 1e6, .unit = "m"});
    auto const normal = r.numbers("normal", 2, {.min = -1e6, .max = 1e6});
    double const length = std::hypot(normal.at(0), normal.at(1));
    if (!(length > 0.0) && r.has("normal")) r.problem("normal", "has no length (needed: a vector towards the grains).");
    w.point = {point.at(0), point.at(1)};
    if (length > 0.0) w.normal = (1.0 / length) * Vec2{normal.at(0), normal.at(1)};
    w.friction = read_friction(r, grain_friction);
    if (auto const time = r.number_if("removed_at", {.min = 0.0, .unit = "s"})) w.removed_at = *time;
    r.finish();
    return w;
}

ColumnConfig read_column(Reader r)
{
    ColumnConfig c;
    c.count = r.integer("count", {.min = 1, .max = 1e6});
    c.aspect_ratio = r.number("aspect_ratio", {.min = 0.05, .max = 50.0});
    c.seed = static_cast<std::uint64_t>(r.integer_or("seed", 1, {.min = 0, .max = 1e15}));
    c.gate_removed_at = r.number_or("gate_removed_at", 0.0, {.min = 0.0, .unit = "s"});
    c.packing_friction = r.number_or("packing_friction", 0.1, {.min = 0.0, .max = 6.0});
    r.finish();
    return c;
}

GrainConfig read_grain(Reader r)
{
    GrainConfig g{};
    auto const position = r.numbers("position", 2, {.min = -1e6, .max = 1e6, .unit = "m"});
    auto const velocity = r.numbers_or("velocity", {0.0, 0.0}, {.min = -1e4, .max = 1e4, .unit = "m/s"});
    g.position = {position.at(0), position.at(1)};
    g.velocity = {velocity.at(0), velocity.at(1)};
    g.radius = r.number("radius", {.above = 1e-9, .max = 1e3, .unit = "m"});
    g.spin = r.number_or("spin", 0.0, {.min = -1e6, .max = 1e6, .unit = "rad/s"});
    r.finish();
    return g;
}

void read_diameter(Reader r, Config& config)
{
    config.diameter_min = r.number("min", {.above = 1e-9, .max = 1e3, .unit = "m"});
    config.diameter_max = r.number("max", {.above = 1e-9, .max = 1e3, .unit = "m"});
    if (config.diameter_max < config.diameter_min)
        r.problem("max",
                  format("%g m is below min = %g m (must be at least min).", config.diameter_max, config.diameter_min));
    if (config.diameter_max > 20.0 * config.diameter_min)
        r.problem("max", format("%g m is more than 20 times min = %g m (the neighbour grid is made for similar sizes).",
                                config.diameter_max, config.diameter_min));
    r.finish();
}

//! A column is poured against x = 0 and onto y = 0: both walls must be there. The gate is added.
void check_column_walls(Reader& r, Config& config)
{
    auto holds = [&](double nx, double ny) {
        return std::any_of(config.walls.begin(), config.walls.end(), [&](WallConfig const& w) {
            return std::abs(w.normal.x - nx) + std::abs(w.normal.y - ny) < 1e-12 &&
                   std::abs(dot(w.point, w.normal)) < 1e-12;
        });
    };
    if (!holds(0.0, 1.0) || !holds(1.0, 0.0))
        r.problem("column",
                  "needs a floor and a back wall to stand on (walls through [0, 0] with normal [0, 1] and with "
                  "normal [1, 0]). Add them to walls.");
    if (std::any_of(config.walls.begin(), config.walls.end(), [](WallConfig const& w) { return w.name == "gate"; }))
        r.problem("walls", "has a wall named gate (a column brings its own). Rename or remove it.");
    if (!(config.gravity.y < 0.0))
        r.problem("column", "cannot settle: gravity does not point down (needed: gravity y < 0).");
    config.walls.push_back({.name = "gate",
                            .point = {column_width(config), 0.0},
                            .normal = {-1.0, 0.0},
                            .friction = config.contact.friction,
                            .removed_at = config.column->gate_removed_at});
}

double lightest_mass(Config const& config)
{
    double radius = config.column ? 0.5 * config.diameter_min : std::numeric_limits<double>::infinity();
    for (GrainConfig const& g : config.grains) radius = std::min(radius, g.radius);
    return config.density * std::numbers::pi * radius * radius;
}

//! `step: auto` is t_c/50; above t_c/5 refused (Verlet with several contacts a grain), above t_c/15 warned (D06).
void read_step(Reader& r, Config& config)
{
    config.contact_time = contact_time(config.contact.normal_stiffness,
                                       config.contact.friction > 0.0 ? config.contact.tangential_stiffness : 0.0,
                                       0.5 * lightest_mass(config));
    config.step = config.contact_time / 50.0;
    if (!r.diagnostics()->problems.empty()) {
        r.has("step") ? void(r.subtree("step")) : void();  // t_c is not known: say nothing about the step
        return;
    }
    if (!r.has("step") || (r.is_scalar("step") && r.text_or("step", "auto") == "auto")) {
        r.text_or("step", "auto");
        return;
    }
    auto const given = r.number_if("step", {.above = 0.0, .unit = "s"});
    if (!given) return;
    double const step = *given;
    double const share = config.contact_time / step;
    if (share < 5.0)
        r.problem("step", format("%g s is too long (must be at most t_c/5 = %g s). Leave it out for t_c/50.", step,
                                 config.contact_time / 5.0));
    else if (share < 15.0)
        config.warnings.push_back(
            format("dem: step = %g s is above t_c/15 = %g s: collisions lose or gain energy. "
                   "t_c/50 is the default.",
                   step, config.contact_time / 15.0));
    config.step = step;
}

//! Overlapping grains push each other apart: their elastic energy becomes motion (D08).
void warn_of_overlaps(Config& config)
{
    Grains grains;
    for (GrainConfig const& g : config.grains) grains.add(g.position, g.radius, config.density);
    std::vector<std::uint32_t> first, other;
    find_pairs(grains, 0.0, first, other);
    double deepest = 0.0, energy = 0.0;  // [-], [J]
    for (std::size_t i = 0; i < grains.size(); ++i)
        for (std::uint32_t slot = first[i]; slot < first[i + 1]; ++slot) {
            std::size_t const j = other[slot];
            double const reach = grains.radius[i] + grains.radius[j];
            double const overlap = reach - std::hypot(grains.x[i] - grains.x[j], grains.y[i] - grains.y[j]);
            deepest = std::max(deepest, overlap / reach);
            energy += 0.5 * config.contact.normal_stiffness * overlap * overlap;
        }
    if (deepest > 0.01)
        config.warnings.push_back(
            format("dem: grains overlap at the start by up to %g of a diameter; the contacts hold "
                   "%g J that will set them in motion.",
                   deepest, energy));
}

void read_matter(Reader& r, Config& config)
{
    for (Reader const& wall : r.list("walls")) config.walls.push_back(read_wall(wall, config.contact.friction));
    if (auto column = r.child_if("column")) {
        config.column = read_column(*column);
        read_diameter(r.child("diameter"), config);
    }
    for (Reader const& grain : r.list("grains")) config.grains.push_back(read_grain(grain));
    if (config.column.has_value() == !config.grains.empty())
        r.problem(config.column ? "grains" : "column",
                  config.column ? "stands beside column (give one of them)." : "is missing (give column or grains).");
    if (config.column && r.diagnostics()->problems.empty()) {
        if (column_width(config) < 4.0 * config.diameter_max)
            r.problem("column", format("is %g m wide, less than 4 largest grains (%g m). Try more grains or a smaller "
                                       "aspect_ratio.",
                                       column_width(config), 4.0 * config.diameter_max));
        check_column_walls(r, config);
    }
}

}  // namespace

double column_width(Config const& config)
{
    double const a = config.diameter_min, b = config.diameter_max;
    double const mean_square = (a * a + a * b + b * b) / 3.0;  // of a uniform distribution
    double const area = static_cast<double>(config.column->count) * std::numbers::pi / 4.0 * mean_square;
    return std::sqrt(area / assumed_packing_fraction / config.column->aspect_ratio);
}

Config read_config(Reader r, Vec2 gravity)
{
    Config config;
    config.gravity = gravity;
    config.density = r.number("density", {.min = 1.0, .max = 1e5, .unit = "kg/m3"});
    config.contact = read_contact(r.child("contact"));
    if (auto buoyancy = r.child_if("buoyancy")) {
        config.fluid_density = buoyancy->number("density", {.above = 0.0, .max = 1e5, .unit = "kg/m3"});
        buoyancy->finish();
    }
    read_matter(r, config);
    read_step(r, config);
    if (r.diagnostics()->problems.empty()) warn_of_overlaps(config);
    r.finish();
    return config;
}

}  // namespace dem
