#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "coupler/base/format.hpp"
#include "participants/dem/config_parts.hpp"
#include "participants/dem/periodic_neighbours.hpp"

//! The keys of periodic cells: periodic, shear, fill; and where stresses are averaged: averages.
namespace dem {
namespace {

using sluice::Reader;

constexpr std::array<std::string_view, 3> names{"x", "y", "z"};
constexpr sluice::Bounds lengths{.min = -1e6, .max = 1e6, .unit = "m"};

std::string name_of(int axis)
{
    return std::string(names[static_cast<std::size_t>(axis)]);
}
bool is_periodic(Config const& config, int axis)
{
    return config.periodic.axis[static_cast<std::size_t>(axis)];
}

void read_sides(Reader r, Config& config)
{
    Periodic<3>& cell = config.periodic;
    for (int k = 0; k < config.dimension; ++k) {
        auto const sides = r.numbers_or(name_of(k), {0.0, 0.0}, lengths);
        if (!r.has(name_of(k))) continue;
        component(cell.low, k) = sides.at(0);
        component(cell.extent, k) = sides.at(1) - sides.at(0);
        cell.axis[static_cast<std::size_t>(k)] = true;
        if (!(sides[1] > sides[0])) r.problem(name_of(k), "has no length (needed: [lower, upper], in m).");
    }
    if (!cell.any()) r.problem("", "names no axis (needed: x: [lower, upper], or another axis).");
    r.finish();
}

void read_shear(Reader r, Config& config)
{
    Shear& shear = config.periodic.shear;
    std::vector<std::string_view> const axes(names.begin(), names.begin() + config.dimension);
    shear.along = static_cast<int>(r.choice_or("along", 0, axes));
    shear.across = static_cast<int>(r.choice_or("across", 1, axes));
    shear.rate = r.number("rate", {.above = 0.0, .max = 1e6, .unit = "1/s"});
    shear.pressure = r.number_or("pressure", 0.0, {.min = 0.0, .max = 1e12, .unit = "Pa"});
    shear.steady_from = r.number_or("steady_from", 1.0, {.min = 0.0, .max = 1e6});
    if (shear.along == shear.across)
        r.problem("across", "is the axis along which the cell is sheared (must be another).");
    for (int k = 0; k < config.dimension; ++k)
        if (!is_periodic(config, k))
            r.problem("", "needs sides that are periodic along " + name_of(k) + ", too. Add it to periodic.");
    if (norm(config.gravity) > 0.0 || norm(config.first_gravity) > 0.0)
        r.problem("", "has no wall that gravity could rest on (needed: a scene without gravity).");
    r.finish();
}

//! A wall must look the same from every image of the cell.
void check_walls(Reader& r, Config const& config)
{
    for (WallConfig const& wall : config.walls) {
        if (config.periodic.is_sheared()) {
            r.problem("walls", "has \"" + wall.name + "\", which would have to be sheared with the cell. Remove it.");
            continue;
        }
        if (wall.mesh) {
            r.problem("walls", "has the mesh \"" + wall.name +
                                   "\" beside periodic, across whose sides it does not go on. Give planes instead, or "
                                   "remove the periodic axes.");
            continue;
        }
        bool const round = wall.radius > 0.0;
        for (int k = 0; k < config.dimension; ++k) {
            if (!is_periodic(config, k)) continue;
            double const along = std::abs(component(wall.normal, k));
            if (round ? along > 1.0 - 1e-12 : along < 1e-12) continue;
            r.problem("walls",
                      "has \"" + wall.name + "\", which does not go on across the periodic sides along " + name_of(k) +
                          (round ? " (needed: an axis along it)." : " (needed: a normal without a part along it).") +
                          " Remove the wall or the periodic axis.");
        }
    }
}

void check_grains(Reader& r, Config const& config)
{
    Periodic<3> const& cell = config.periodic;
    auto const [smallest, largest] = diameters(config);
    for (int k = 0; k < config.dimension; ++k) {
        if (!is_periodic(config, k)) continue;
        double const needed = shortest_edge(largest, list_reach(smallest)), extent = component(cell.extent, k);
        if (extent < needed)
            return r.problem(
                "periodic",
                sluice::format("is %g m long, too short for grains to meet one image of each other only (must be at "
                               "least %g m: twice the largest diameter and the reach of the list).",
                               extent, needed));
        for (std::size_t i = 0; i < config.grains.size(); ++i) {
            double const x = component(config.grains[i].position - cell.low, k);
            if (x >= 0.0 && x < extent) continue;
            r.problem("grains", "has number " + std::to_string(i) + " outside the periodic cell, which along " +
                                    name_of(k) +
                                    sluice::format(" is from %g to %g m (must be in it).", component(cell.low, k),
                                                   component(cell.low, k) + extent));
            break;
        }
    }
    if (config.fill && fill_pitch(config) < largest)
        r.problem("fill",
                  sluice::format("has room for grains of %g m (must be at least the largest diameter, %g m). Try a "
                                 "larger cell or fewer grains.",
                                 fill_pitch(config), largest));
}

//! The images move less than a fifth of the list's reach in a step; and the height as a plate that takes up sound: rho
//! c of the grains, with c = d pi / (sqrt(2) t_c), twice.
void set_shear(Reader& r, Config& config)
{
    Shear& shear = config.periodic.shear;
    auto const [smallest, largest] = diameters(config);
    double const slide = shear.rate * component(config.periodic.extent, shear.across);
    double const longest = 0.2 * list_reach(smallest) / slide;
    if (config.step > longest)
        r.problem("shear",
                  sluice::format("moves the sides too far in a step of %g s (must be at most %g s). Try a lower rate "
                                 "or a shorter step.",
                                 config.step, longest));
    double const sound = 0.5 * (smallest + largest) * std::numbers::pi / (std::numbers::sqrt2 * config.contact_time);
    shear.impedance = 2.0 * config.density * sound;
}

}  // namespace

void read_periodic(Reader& r, Config& config)
{
    if (auto sides = r.child_if("periodic")) read_sides(*sides, config);
    if (auto shear = r.child_if("shear")) read_shear(*shear, config);
}

void read_fill(Reader& r, Config& config)
{
    auto block = r.child_if("fill");
    if (!block) return;
    FillConfig fill;
    fill.count = block->integer("count", {.min = 1, .max = 1e7});
    fill.seed = static_cast<std::uint64_t>(block->integer_or("seed", 1, {.min = 0, .max = 1e15}));
    block->finish();
    config.fill = fill;
    read_diameter(r.child("diameter"), config);
    for (int k = 0; k < config.dimension; ++k)
        if (!is_periodic(config, k)) {
            r.problem("fill", "fills a cell that is periodic along every axis; " + name_of(k) + " is not.");
            return;
        }
}

void check_periodic(Reader& r, Config& config)
{
    if (!config.periodic.any() || !r.diagnostics()->problems.empty()) return;
    if (config.scheme == Scheme::liggghts)
        return r.problem("scheme", "liggghts has no periodic sides (leave one of them out).");
    if (config.rotation)
        return r.problem("periodic",
                         "in a frame that rotates: its two sides would not be the same (needs frame: inertial).");
    if (config.column)
        return r.problem("column", "stands against walls, in a cell that is periodic. Give fill or grains instead.");
    if (config.measures.stated && config.measures[Measure::run_out].wanted && is_periodic(config, 0))
        r.problem("measures", "has run_out, along x, where the cell is periodic. Leave it out.");
    check_walls(r, config);
    check_grains(r, config);
    if (config.periodic.is_sheared()) set_shear(r, config);
}

void read_averages(Reader& r, Config& config)
{
    auto const size = static_cast<std::size_t>(config.dimension);
    auto const corner = [&](Reader& box, char const* key) {
        auto const v = box.numbers(key, size, lengths);
        return Vec3{v.at(0), v.at(1), size > 2 ? v[2] : 0.0};
    };
    for (Reader box : r.list("averages")) {
        AverageConfig a;
        a.name = box.text("name");
        a.whole = !box.has("min") && !box.has("max");
        if (!a.whole) {
            a.low = corner(box, "min");
            a.high = corner(box, "max");
        }
        bool closed = true;
        for (int k = 0; k < config.dimension; ++k) {
            closed = closed && is_periodic(config, k);
            if (!a.whole && !(component(a.high - a.low, k) > 0.0))
                box.problem("max", "is not above min along " + name_of(k) + " (needed: a box with a volume).");
        }
        if (a.whole && !closed)
            box.problem("name",
                        "has no box (give min and max; without them it is a cell that is periodic along every "
                        "axis).");
        box.finish();
        config.averages.push_back(a);
    }
}

}  // namespace dem
