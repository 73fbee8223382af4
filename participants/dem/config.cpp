#include "participants/dem/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "coupler/base/format.hpp"
#include "coupler/scene/threads.hpp"
#include "participants/dem/config_parts.hpp"
#include "participants/dem/half_step.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/motion/read_motion.hpp"

namespace dem {
namespace {

using sluice::Reader;

constexpr sluice::Bounds lengths{.min = -1e6, .max = 1e6, .unit = "m"};

Vec3 vector_from(std::vector<double> const& v)
{
    return {v.at(0), v.at(1), v.size() > 2 ? v[2] : 0.0};
}
std::size_t size_of(int dimension)
{
    return static_cast<std::size_t>(dimension);
}
std::vector<double> zeros(int dimension)
{
    return std::vector<double>(size_of(dimension), 0.0);
}

//! A direction of length 1; none given: {0, 0, 0}, and a mistake.
Vec3 read_direction(Reader& r, char const* key, int dimension, char const* needed)
{
    Vec3 const v = vector_from(r.numbers(key, size_of(dimension), {.min = -1e6, .max = 1e6}));
    double const length = norm(v);
    if (!(length > 0.0) && r.has(key)) r.problem(key, std::string("has no length (needed: ") + needed + ").");
    return length > 0.0 ? (1.0 / length) * v : v;
}

void read_cylinder(Reader r, int dimension, WallConfig& w)
{
    w.point = vector_from(r.numbers("point", size_of(dimension), lengths));
    if (dimension == 3) w.normal = read_direction(r, "axis", dimension, "the direction of the axis");
    w.radius = r.number("radius", {.above = 1e-9, .max = 1e6, .unit = "m"});
    w.inside = r.choice_or("grains", 0, {"inside", "outside"}) == 0;
    r.finish();
}

WallConfig read_wall(Reader r, int dimension, ContactConfig const& grains)
{
    WallConfig w;
    w.name = r.text("name");
    if (auto cylinder = r.child_if("cylinder")) {
        read_cylinder(*cylinder, dimension, w);
    } else if (r.has("mesh") || r.has("segments")) {
        w.mesh = read_mesh(r, dimension);
    } else {
        w.point = vector_from(r.numbers("point", size_of(dimension), lengths));
        w.normal = read_direction(r, "normal", dimension, "a vector towards the grains");
    }
    w.contact = grains;
    if (auto own = r.child_if("contact"))
        w.contact = read_contact(*own, grains);
    else
        w.contact.friction = read_friction(r, grains.friction);
    if (w.contact.rolling != grains.rolling)
        r.problem("contact", "has another law of rolling than the grains (use one law; only its numbers may differ).");
    w.motion = motion::read_motion(r, size_of(dimension), vector_from);
    if (auto const time = r.number_if("removed_at", {.min = 0.0, .unit = "s"})) w.removed_at = *time;
    r.finish();
    return w;
}

ColumnConfig read_column(Reader r, int dimension)
{
    ColumnConfig c;
    if (dimension == 3) {
        std::size_t const meant = r.has("container") && !r.has("depth") ? 1 : 0;  // if the word is wrong
        c.container = static_cast<Container>(r.choice_or("container", meant, {"box", "quarter", "cylinder"}));
        if (c.container == Container::box) c.depth = r.number("depth", {.above = 0.0, .max = 1e6, .unit = "m"});
    }
    c.count = r.integer("count", {.min = 1, .max = 1e7});
    c.aspect_ratio = r.number("aspect_ratio", {.min = 0.05, .max = 50.0});
    c.seed = static_cast<std::uint64_t>(r.integer_or("seed", 1, {.min = 0, .max = 1e15}));
    c.gate_removed_at = r.number_or("gate_removed_at", 0.0, {.min = 0.0, .unit = "s"});
    c.preparation = static_cast<Preparation>(r.choice_or("preparation", 0, {"poured", "random", "regular"}));
    if (c.preparation == Preparation::poured)
        c.packing_friction = r.number_or("packing_friction", 0.1, {.min = 0.0, .max = 6.0});
    double const usual = assumed_packing_fraction(dimension);
    c.packing_fraction = usual;
    if (c.preparation != Preparation::regular)  // denser: crystals (discs), or nothing that growth reaches (spheres)
        c.packing_fraction = r.number_or("packing_fraction", usual, {.min = 0.2, .max = dimension == 2 ? 0.86 : 0.64});
    c.pouring_gravity = r.number_or("pouring_gravity", 0.0, {.min = 0.0, .max = 1e5, .unit = "m/s2"});
    r.finish();
    return c;
}

GrainConfig read_grain(Reader r, int dimension)
{
    GrainConfig g{};
    sluice::Bounds const spins{.min = -1e6, .max = 1e6, .unit = "rad/s"};
    g.position = vector_from(r.numbers("position", size_of(dimension), lengths));
    g.velocity = vector_from(r.numbers_or("velocity", zeros(dimension), {.min = -1e4, .max = 1e4, .unit = "m/s"}));
    g.radius = r.number("radius", {.above = 1e-9, .max = 1e3, .unit = "m"});
    g.spin = dimension == 2 ? Vec3{0, 0, r.number_or("spin", 0.0, spins)}
                            : vector_from(r.numbers_or("spin", zeros(3), spins));
    r.finish();
    return g;
}

//! The walls that a column stands against; the floor is the last.
std::vector<std::pair<Vec3, Vec3>> walls_of(ColumnConfig const& column, int dimension)  // point, normal
{
    if (dimension == 2) return {{{}, {1, 0, 0}}, {{}, {0, 1, 0}}};
    switch (column.container) {
        case Container::box:
            return {{{}, {1, 0, 0}}, {{}, {0, 1, 0}}, {{0, column.depth, 0}, {0, -1, 0}}, {{}, {0, 0, 1}}};
        case Container::quarter:
            return {{{}, {1, 0, 0}}, {{}, {0, 1, 0}}, {{}, {0, 0, 1}}};
        case Container::cylinder:
            break;
    }
    return {{{}, {0, 0, 1}}};
}

//! A column is poured against its walls and onto its floor: they must be there. The gate is added.
void check_column_walls(Reader& r, Config& config)
{
    auto const holds = [&](Vec3 point, Vec3 normal) {
        return std::any_of(config.walls.begin(), config.walls.end(), [&](WallConfig const& w) {
            return w.radius == 0.0 && norm(w.normal - normal) < 1e-12 &&
                   std::abs(dot(w.point - point, w.normal)) < 1e-12 * (1.0 + norm(point));
        });
    };
    std::string missing;
    int const dimension = config.dimension;
    auto const text = [&](Vec3 v) {
        char line[96];
        if (dimension == 2)
            std::snprintf(line, sizeof line, "[%g, %g]", v.x, v.y);
        else
            std::snprintf(line, sizeof line, "[%g, %g, %g]", v.x, v.y, v.z);
        return std::string(line);
    };
    for (auto const& [point, normal] : walls_of(*config.column, dimension))
        if (!holds(point, normal))
            missing += (missing.empty() ? "" : ", ") + ("{point: " + text(point) + ", normal: " + text(normal) + "}");
    if (!missing.empty())
        r.problem("column", "needs a floor and walls to stand against; missing: " + missing + ". Add them to walls.");
    if (std::any_of(config.walls.begin(), config.walls.end(), [](WallConfig const& w) { return w.name == "gate"; }))
        r.problem("walls", "has a wall named gate (a column brings its own). Rename or remove it.");
    Vec3 const gravity = settling_gravity(config);
    if (config.column->pouring_gravity > 0.0 && norm(gravity) == 0.0)
        r.problem("column", "has a pouring_gravity in a scene without gravity (leave it out).");
    bool const weightless = norm(gravity) == 0.0 && config.column->preparation != Preparation::poured;
    if (!weightless && !((dimension == 2 ? gravity.y : gravity.z) < 0.0))
        r.problem("column", std::string("cannot settle: gravity does not point down (needed: gravity ") +
                                (dimension == 2 ? "y" : "z") + " < 0).");
    WallConfig gate;
    gate.name = "gate";
    gate.contact = config.contact;
    gate.removed_at = config.column->gate_removed_at;
    if (dimension == 2 || config.column->container == Container::box) {
        gate.point = {column_width(config), 0.0, 0.0};
        gate.normal = {-1.0, 0.0, 0.0};
    } else {
        gate.normal = {0.0, 0.0, 1.0};
        gate.radius = column_width(config);
    }
    config.walls.push_back(gate);
}

double mass_of(Config const& config, double radius, double density)
{
    return density * (config.dimension == 2 ? volume_of<2>(radius) : volume_of<3>(radius));
}

//! t_c of the lightest pair, and of the lightest grain at a wall, which is heavier than any grain: twice the mass of a
//! pair [s].
double contact_time_of(Config const& config, double radius, double mass)
{
    double time = contact_time_of(config.contact, config.dimension, mass, radius);
    for (WallConfig const& w : config.walls)
        time = std::min(time, contact_time_of(w.contact, config.dimension, 2.0 * mass, radius));
    return time;
}

//! `step: auto` is t_c/50; above t_c/5 refused (Verlet with several contacts a grain), above t_c/15 warned (D06).
void read_step(Reader& r, Config& config)
{
    auto const [radius, mass] = lightest_grain(config);
    config.contact_time = contact_time_of(config, radius, mass);
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
        r.problem("step", sluice::format("%g s is too long (must be at most t_c/5 = %g s). Leave it out for t_c/50.",
                                         step, config.contact_time / 5.0));
    else if (share < 15.0)
        config.warnings.push_back(
            sluice::format("dem: step = %g s is above t_c/15 = %g s: collisions lose or gain energy. "
                           "t_c/50 is the default.",
                           step, config.contact_time / 15.0));
    config.step = step;
}

//! A lattice of the largest diameter is as full as its grains make it, and fits between wall and gate.
void complete_column(Reader& r, Config& config)
{
    ColumnConfig& c = *config.column;
    if (!r.diagnostics()->problems.empty() || c.preparation != Preparation::regular) return;
    double const pi = std::numbers::pi, d = config.diameter_max;
    c.packing_fraction = config.dimension == 2 ? pi / (2.0 * std::sqrt(3.0)) * config.sizes.moment(2) / (d * d)
                                               : pi / (3.0 * std::sqrt(2.0)) * config.sizes.moment(3) / (d * d * d);
}

void read_matter(Reader& r, Config& config)
{
    for (Reader const& wall : r.list("walls"))
        config.walls.push_back(read_wall(wall, config.dimension, config.contact));
    if (auto column = r.child_if("column")) {
        config.column = read_column(*column, config.dimension);
        read_diameter(r.child("diameter"), config);
        complete_column(r, config);
    }
    for (Reader const& grain : r.list("grains")) config.grains.push_back(read_grain(grain, config.dimension));
    bool const file = r.has("packing");
    read_fill(r, config);
    if (config.column.has_value() + config.fill.has_value() + !config.grains.empty() + file > 1)
        r.problem(config.fill             ? "fill"
                  : config.grains.empty() ? "packing"
                                          : "grains",
                  std::string("stands beside ") +
                      (config.column ? "column"
                       : file        ? "packing"
                                     : "grains") +
                      " (give one of them).");
    else if (!config.column && !config.fill && config.grains.empty() && !file)
        r.problem("column", "is missing (give column, fill, grains or packing).");
    if (auto packing = r.child_if("packing")) read_packing(*packing, config);
    read_density(r, config);
    if (config.column && r.diagnostics()->problems.empty()) {
        if (column_width(config) < 4.0 * config.diameter_max)
            r.problem("column",
                      sluice::format("is %g m wide, less than 4 largest grains (%g m). Try more grains or a smaller "
                                     "aspect_ratio.",
                                     column_width(config), 4.0 * config.diameter_max));
        check_column_walls(r, config);
    }
}

//! What a column's width would be if any were possible [m].
double any_width(Config const& config)
{
    double const pi = std::numbers::pi;
    ColumnConfig const& c = *config.column;
    double const matter = static_cast<double>(c.count) / c.packing_fraction;
    if (config.dimension == 2) return std::sqrt(matter * pi / 4.0 * config.sizes.moment(2) / c.aspect_ratio);
    double const volume = matter * pi / 6.0 * config.sizes.moment(3);
    switch (c.container) {
        case Container::box:
            return std::sqrt(volume / (c.aspect_ratio * c.depth));
        case Container::quarter:
            return std::cbrt(volume / (c.aspect_ratio * pi / 4.0));
        case Container::cylinder:
            break;
    }
    return std::cbrt(volume / (c.aspect_ratio * pi));
}

}  // namespace

Lightest lightest_grain(Config const& config)
{
    double const radius = 0.5 * diameters(config).first;
    double mass = config.column || config.fill ? mass_of(config, radius, config.density)
                                               : std::numeric_limits<double>::infinity();
    for (GrainConfig const& g : config.grains)
        mass = std::min(mass, mass_of(config, g.radius, g.density > 0.0 ? g.density : config.density));
    return {radius, mass};
}

std::pair<double, double> diameters(Config const& config)
{
    bool const drawn = config.column || config.fill;
    double smallest = drawn ? config.diameter_min : std::numeric_limits<double>::infinity();
    double largest = drawn ? config.diameter_max : 0.0;
    for (GrainConfig const& g : config.grains) {
        smallest = std::min(smallest, 2.0 * g.radius);
        largest = std::max(largest, 2.0 * g.radius);
    }
    return {smallest, largest};
}

Vec3 starting_gravity(Config const& config)
{
    return config.gravity_ramp > 0.0 && norm(config.first_gravity) > 0.0 ? config.first_gravity : config.gravity;
}

Vec3 settling_gravity(Config const& config)
{
    Vec3 const gravity = starting_gravity(config);
    if (!config.rotation) return gravity;
    frame::RotatingFrame<3> const turning(*config.rotation);
    return gravity - times(turning.centrifugal(0.0), point_of_axis(turning));
}

double column_width(Config const& config)
{
    double const width = any_width(config), d = config.diameter_max;
    bool const rows = config.column->preparation == Preparation::regular && config.column->container == Container::box;
    return rows ? (std::max(1.0, std::round(width / d - 0.5)) + 0.5) * d : width;  // each row touches one side
}

Config read_config(Reader r, int dimension, Vec3 gravity, std::optional<sluice::Rotation> const& rotation)
{
    Config config;
    config.dimension = dimension;
    config.gravity = gravity;
    config.rotation = rotation;
    config.contact = read_contact(r.child("contact"));
    config.scheme = r.choice_or("scheme", 0, {"predicted", "liggghts"}) == 0 ? Scheme::predicted : Scheme::liggghts;
    config.threads = sluice::read_threads(r, "1");
    if (config.scheme == Scheme::liggghts && config.contact.rolling == Rolling::elastic_plastic)
        r.problem("scheme", "liggghts has no elastic_plastic rolling (give contact.rolling: constant).");
    if (auto ramp = r.child_if("gravity_ramp")) {
        config.gravity_ramp = ramp->number("time", {.above = 0.0, .unit = "s"});
        config.first_gravity = vector_from(ramp->numbers_or("from", zeros(dimension), {.unit = "m/s2"}));
        ramp->finish();
    }
    read_periodic(r, config);
    read_lubrication(r, config);
    read_matter(r, config);
    if (auto buoyancy = r.child_if("buoyancy")) {
        config.fluid_density = buoyancy->number("density", {.above = 0.0, .max = 1e5, .unit = "kg/m3"});
        buoyancy->finish();
    }
    config.measures = read_measures(r, config);
    read_step(r, config);
    check_lubrication(r, config);
    read_sleep(r, config);
    check_periodic(r, config);
    read_averages(r, config);
    check_start(r, config);
    r.finish();
    return config;
}

}  // namespace dem
