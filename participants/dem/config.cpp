#include "participants/dem/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "coupler/scene/threads.hpp"
#include "participants/dem/contact.hpp"
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

WallMotion<3> read_motion(Reader& r, int dimension)
{
    WallMotion<3> m;
    m.velocity = vector_from(r.numbers_or("velocity", zeros(dimension), {.min = -1e3, .max = 1e3, .unit = "m/s"}));
    if (auto swing = r.child_if("oscillation")) {
        m.amplitude = vector_from(swing->numbers("amplitude", size_of(dimension), lengths));
        m.frequency = swing->number("frequency", {.above = 0.0, .max = 1e6, .unit = "Hz"});
        swing->finish();
    }
    if (!m.moves()) return m;
    m.begin = r.number_or("moves_from", 0.0, {.min = 0.0, .unit = "s"});
    if (auto const end = r.number_if("moves_until", {.min = m.begin, .unit = "s"})) m.end = *end;
    return m;
}

WallConfig read_wall(Reader r, int dimension, ContactConfig const& grains)
{
    WallConfig w;
    w.name = r.text("name");
    if (auto cylinder = r.child_if("cylinder")) {
        read_cylinder(*cylinder, dimension, w);
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
    w.motion = read_motion(r, dimension);
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
    c.packing_friction = r.number_or("packing_friction", 0.1, {.min = 0.0, .max = 6.0});
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

}  // namespace

void read_diameter(Reader r, Config& config)
{
    config.diameter_min = r.number("min", {.above = 1e-9, .max = 1e3, .unit = "m"});
    config.diameter_max = r.number("max", {.above = 1e-9, .max = 1e3, .unit = "m"});
    if (config.diameter_max < config.diameter_min)
        r.problem("max",
                  format("%g m is below min = %g m (must be at least min).", config.diameter_max, config.diameter_min));
    if (config.diameter_max > 50.0 * config.diameter_min)
        r.problem("max", format("%g m is more than 50 times min = %g m (a step for the smallest would take the largest "
                                "nowhere).",
                                config.diameter_max, config.diameter_min));
    r.finish();
}

namespace {

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
    if (!((dimension == 2 ? config.gravity.y : config.gravity.z) < 0.0))
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

double mass_of(Config const& config, double radius)
{
    double const pi = std::numbers::pi;
    return config.density * (config.dimension == 2 ? pi * radius * radius : 4.0 / 3.0 * pi * radius * radius * radius);
}

//! `step: auto` is t_c/50; above t_c/5 refused (Verlet with several contacts a grain), above t_c/15 warned (D06).
void read_step(Reader& r, Config& config)
{
    double const radius = 0.5 * diameters(config).first;
    config.contact_time = contact_time_of(config.contact, config.dimension, mass_of(config, radius), radius);
    for (WallConfig const& w : config.walls)  // a wall is heavier than any grain: twice the mass of a pair
        config.contact_time = std::min(
            config.contact_time, contact_time_of(w.contact, config.dimension, 2.0 * mass_of(config, radius), radius));
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
template <int D>
void warn_of_overlaps(Config& config)
{
    Grains<D> grains;
    for (GrainConfig const& g : config.grains) grains.add(to_dimension<D>(g.position), g.radius, config.density);
    std::vector<std::uint32_t> first, other;
    find_pairs(grains, 0.0, first, other);
    ContactLaw const law = contact_law(config.contact);
    double deepest = 0.0, energy = 0.0;  // [-], [J]
    for (std::size_t i = 0; i < grains.size(); ++i)
        for (std::uint32_t slot = first[i]; slot < first[i + 1]; ++slot) {
            auto const &a = grains.place[i], &b = grains.place[other[slot]];
            double const reach = a.radius + b.radius, overlap = reach - norm(a.centre - b.centre);
            double const effective = a.radius * b.radius / reach;
            deepest = std::max(deepest, overlap / reach);
            energy += (config.contact.elasticity == Elasticity::linear
                           ? stiffness_at<Elasticity::linear>(law, overlap, effective)
                           : stiffness_at<Elasticity::hertz>(law, overlap, effective))
                          .energy;
        }
    if (deepest > 0.01)
        config.warnings.push_back(
            format("dem: grains overlap at the start by up to %g of a diameter; the contacts hold "
                   "%g J that will set them in motion.",
                   deepest, energy));
}

void read_matter(Reader& r, Config& config)
{
    for (Reader const& wall : r.list("walls"))
        config.walls.push_back(read_wall(wall, config.dimension, config.contact));
    if (auto column = r.child_if("column")) {
        config.column = read_column(*column, config.dimension);
        read_diameter(r.child("diameter"), config);
    }
    for (Reader const& grain : r.list("grains")) config.grains.push_back(read_grain(grain, config.dimension));
    read_fill(r, config);
    bool const listed = !config.grains.empty();
    if (config.column ? listed || config.fill : listed == config.fill.has_value())
        r.problem(listed ? "grains" : "column", listed          ? "stands beside column or fill (give one of them)."
                                                : config.column ? "stands beside fill (give one of them)."
                                                                : "is missing (give column, fill or grains).");
    if (config.column && r.diagnostics()->problems.empty()) {
        if (column_width(config) < 4.0 * config.diameter_max)
            r.problem("column", format("is %g m wide, less than 4 largest grains (%g m). Try more grains or a smaller "
                                       "aspect_ratio.",
                                       column_width(config), 4.0 * config.diameter_max));
        check_column_walls(r, config);
    }
}

}  // namespace

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

double column_width(Config const& config)
{
    double const a = config.diameter_min, b = config.diameter_max, pi = std::numbers::pi;
    ColumnConfig const& c = *config.column;
    double const matter = static_cast<double>(c.count) / assumed_packing_fraction(config.dimension);
    if (config.dimension == 2) {
        double const mean_square = (a * a + a * b + b * b) / 3.0;  // of a uniform distribution
        return std::sqrt(matter * pi / 4.0 * mean_square / c.aspect_ratio);
    }
    double const mean_cube = (a + b) * (a * a + b * b) / 4.0;
    double const volume = matter * pi / 6.0 * mean_cube;
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

Config read_config(Reader r, int dimension, Vec3 gravity)
{
    Config config;
    config.dimension = dimension;
    config.gravity = gravity;
    config.density = r.number("density", {.min = 1.0, .max = 1e5, .unit = "kg/m3"});
    config.contact = read_contact(r.child("contact"));
    config.scheme = r.choice_or("scheme", 0, {"predicted", "liggghts"}) == 0 ? Scheme::predicted : Scheme::liggghts;
    config.threads = sluice::read_threads(r, "1");
    if (auto buoyancy = r.child_if("buoyancy")) {
        config.fluid_density = buoyancy->number("density", {.above = 0.0, .max = 1e5, .unit = "kg/m3"});
        buoyancy->finish();
    }
    if (config.scheme == Scheme::liggghts && config.contact.rolling == Rolling::elastic_plastic)
        r.problem("scheme", "liggghts has no elastic_plastic rolling (give contact.rolling: constant).");
    read_periodic(r, config);
    read_matter(r, config);
    read_step(r, config);
    check_periodic(r, config);
    read_averages(r, config);
    if (r.diagnostics()->problems.empty()) dimension == 2 ? warn_of_overlaps<2>(config) : warn_of_overlaps<3>(config);
    r.finish();
    return config;
}

}  // namespace dem
