#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <type_traits>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/packing_file.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

struct Folder
{
    std::filesystem::path path = std::filesystem::temp_directory_path() / ("dem_packing_" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
};

bool same(dem::Packing<2> const& a, dem::Packing<2> const& b)
{
    auto const same_place = [](auto const& p, auto const& q) { return p.centre == q.centre && p.radius == q.radius; };
    return std::equal(a.place.begin(), a.place.end(), b.place.begin(), b.place.end(), same_place) &&
           a.kinetic_ratio == b.kinetic_ratio && a.records == b.records;
}

}  // namespace

TEST_CASE("packing: settled, within its box, the same for the same seed, and quiet when the run starts from it")
{
    dem::Config c = config();
    dem::Packing<2> const p = dem::pour_packing<2>(c);
    CHECK(p.kinetic_ratio <= dem::settled_kinetic_ratio);
    CHECK(p.place.size() == 60);
    CHECK_FALSE(p.records.empty());
    CHECK(same(p, dem::pour_packing<2>(c)));
    c.column->seed = 4;
    CHECK_FALSE(same(p, dem::pour_packing<2>(c)));

    c.walls.back().removed_at = 1e9;
    dem::Solver<2> solver = dem::make_solver<2>(c, p);
    double weight = 0.0;
    for (double m : solver.grains().mass) weight += 9.81 * m;
    for (int n = 0; n < 5000; ++n) solver.step(c.step);
    CHECK(dem::measure(solver).kinetic / (weight * 1.4e-3) < dem::settled_kinetic_ratio);
    CHECK(dem::measure(solver).foremost < dem::column_width(c) * 1.01);
}

TEST_CASE("packing: written once, then read back bit for bit and a damaged file is made again")
{
    Folder const folder;
    dem::Config const c = config();
    std::vector<std::string> said;
    auto const progress = [&](std::string const& line) { said.push_back(line); };
    dem::Packing<2> const made = dem::prepare_packing<2>(c, folder.path, progress);
    auto const file = folder.path / dem::packing_file_name(c);
    REQUIRE(std::filesystem::exists(file));
    CHECK_FALSE(said.empty());
    said.clear();
    CHECK(same(made, dem::prepare_packing<2>(c, folder.path, progress)));
    CHECK(said.empty());

    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('x');
    CHECK(same(made, dem::prepare_packing<2>(c, folder.path, progress)));
    CHECK(said.at(0).find("damaged") != std::string::npos);

    std::filesystem::resize_file(file, 300);
    std::string damage;
    CHECK_FALSE(dem::load_packing<2>(file, damage));
    CHECK(damage.find("damaged") != std::string::npos);
    std::filesystem::resize_file(file, 3);
    CHECK_FALSE(dem::load_packing<2>(file, damage));
    damage.clear();
    CHECK_FALSE(dem::load_packing<2>(folder.path / "none.bin", damage));
    CHECK(damage.empty());
}

TEST_CASE("packing: its file is shared by runs that differ in buoyancy, gate and step, and by no others")
{
    std::string const text = scene;
    std::string const name = dem::packing_file_name(config());
    CHECK(dem::packing_file_name(config(text + "buoyancy: {density: 1000}\n")) == name);
    CHECK(dem::packing_file_name(config(text + "step: 1e-6\n")) == name);
    auto replaced = [&](std::string const& from, std::string const& to) {
        std::string changed = text;
        return dem::packing_file_name(config(changed.replace(changed.find(from), from.size(), to)));
    };
    CHECK(replaced("seed: 3", "seed: 3, gate_removed_at: 0.5") == name);
    CHECK(replaced("seed: 3", "seed: 4") != name);
    CHECK(replaced("seed: 3", "seed: 3, preparation: random") != name);
    CHECK(replaced("seed: 3", "seed: 3, preparation: random, packing_fraction: 0.8") !=
          replaced("seed: 3", "seed: 3, preparation: random"));
    CHECK(replaced("seed: 3", "seed: 3, pouring_gravity: 1") != name);
    CHECK(replaced("max: 1.8e-3", "max: 1.8e-3, law: uniform_mass") != name);
    CHECK(replaced("count: 60", "count: 61") != name);
    CHECK(replaced("friction_angle: 26", "friction_angle: 25") != name);
}

namespace {

//! A column of discs; `diameter` and more keys of `column`.
dem::Config column(std::string const& diameter, std::string const& more, double gravity = 9.81, int count = 150)
{
    std::string const text =
        "density: 2650\ndiameter: " + diameter +
        "\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\nwalls:\n"
        "  - {name: floor, point: [0, 0], normal: [0, 1]}\n  - {name: back, point: [0, 0], normal: [1, 0]}\n"
        "column: {count: " +
        std::to_string(count) + ", aspect_ratio: 1, " + more + "}\n";
    return dem::read_config(sluice::read_yaml(text, "column.yaml"), 2, {0.0, -gravity, 0.0});
}

dem::Config quarter(std::string const& more, double gravity = 9.81)
{
    std::string const text =
        "density: 2650\ndiameter: {min: 7e-3, max: 9e-3}\n"
        "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\nwalls:\n"
        "  - {name: floor, point: [0, 0, 0], normal: [0, 0, 1]}\n  - {name: x, point: [0, 0, 0], normal: [1, 0, 0]}\n"
        "  - {name: y, point: [0, 0, 0], normal: [0, 1, 0]}\n"
        "column: {container: quarter, count: 150, aspect_ratio: 1, " +
        more + "}\n";
    return dem::read_config(sluice::read_yaml(text, "column.yaml"), 3, {0.0, 0.0, -gravity});
}

template <int D>
double highest(dem::Packing<D> const& packing)
{
    double height = 0.0;
    for (auto const& [centre, radius] : packing.place) height = std::max(height, up(centre) + radius);
    return height;
}

template <int D>
double deepest(dem::Config const& c, dem::Packing<D> const& packing)
{
    dem::Config held = c;
    held.walls.back().removed_at = 1e9;
    return dem::measure(dem::make_solver<D>(held, packing)).largest_overlap;
}

}  // namespace

TEST_CASE("packing: grown at random without weight, near the fraction that is asked for, without overlaps")
{
    auto const check = [](auto dimension, dem::Config const& c) {
        constexpr int D = decltype(dimension)::value;
        auto const packing = dem::pour_packing<D>(c);
        CHECK(packing.place.size() == 150);
        CHECK(deepest<D>(c, packing) <= 1e-4);
        // walls keep grains apart: over a layer of half a diameter along each the density of spheres and discs falls to
        // nothing, which in so small a column may take a tenth of its height
        double const height = c.column->aspect_ratio * dem::column_width(c);
        CHECK(highest(packing) < 1.1 * height);
        CHECK(highest(packing) > height - c.diameter_max);
    };
    check(std::integral_constant<int, 2>{}, column("{min: 1e-3, max: 1.8e-3}", "preparation: random", 0.0));
    check(std::integral_constant<int, 2>{},
          column("{min: 1e-3, max: 5e-3, law: uniform_mass}", "preparation: random, packing_fraction: 0.8", 0.0));
    check(std::integral_constant<int, 3>{}, quarter("preparation: random, packing_fraction: 0.55", 0.0));
    dem::Config c = column("{min: 1e-3, max: 1.8e-3}", "preparation: random, packing_fraction: 0.7", 0.0);
    auto const once = dem::pour_packing<2>(c);
    CHECK(same(once, dem::pour_packing<2>(c)));
    c.column->seed = 2;
    CHECK_FALSE(same(once, dem::pour_packing<2>(c)));
}

TEST_CASE("packing: grown at random, then settled under its weight, near the height it was reckoned with")
{
    dem::Config const c = column("{min: 1e-3, max: 1.8e-3}", "preparation: random");
    auto const packing = dem::pour_packing<2>(c);
    CHECK(packing.kinetic_ratio <= dem::settled_kinetic_ratio);
    CHECK_FALSE(packing.records.empty());
    double const height = dem::column_width(c);
    CHECK(std::abs(highest(packing) - height) < 2.0 * c.diameter_max);
}

TEST_CASE("packing: a lattice of equal discs stays one under its weight")
{
    dem::Config const c = column("{min: 1e-3, max: 1e-3}", "preparation: regular");
    double const d = 1e-3, width = dem::column_width(c);
    double const rows = width / d - 0.5;
    CHECK(rows == close_to(std::round(rows)));
    auto const packing = dem::pour_packing<2>(c);
    CHECK(packing.kinetic_ratio <= dem::settled_kinetic_ratio);
    auto const across = static_cast<std::size_t>(std::lround(rows));
    double worst = 0.0;
    for (std::size_t k = 0; k < packing.place.size(); ++k) {
        double const row = static_cast<double>(k / across);
        dem::Vec2 const site{(0.5 + static_cast<double>(k % across) + (k / across % 2 ? 0.5 : 0.0)) * d,
                             0.5 * d + row * d * std::sqrt(3.0) / 2.0};
        worst = std::max(worst, norm(packing.place[k].centre - site));
    }
    CHECK(worst < 0.01 * d);
    auto const spheres = quarter("preparation: regular", 0.0);
    auto const layers = dem::pour_packing<3>(spheres);
    CHECK(layers.place.size() == 150);
    CHECK(deepest<3>(spheres, layers) <= 1e-12);  // sites are one largest diameter apart
}

TEST_CASE("packing: poured with a wide law of sizes, from a loose state that does not prefer any")
{
    dem::Config const c =
        column("{min: 0.5e-3, max: 4e-3, law: fractal, fractal_dimension: 1.5}", "seed: 2", 9.81, 300);
    auto const packing = dem::pour_packing<2>(c);
    CHECK(packing.kinetic_ratio <= dem::settled_kinetic_ratio);
    std::vector<double> drawn, there;
    dem::Random random(2);
    for (auto const& place : packing.place) {
        drawn.push_back(0.5 * c.sizes.draw(random));
        there.push_back(place.radius);
    }
    std::sort(drawn.begin(), drawn.end());
    std::sort(there.begin(), there.end());
    CHECK(drawn == there);
    CHECK(std::abs(highest(packing) - dem::column_width(c)) < 2.0 * c.diameter_max);
}

TEST_CASE("packing: poured under one gravity, then consolidated under the scene's own")
{
    // fifty times its weight presses the springs fifty times as deep: 50 m g / k a row, some 5e-4 of the height here
    dem::Config const c = column("{min: 1e-3, max: 1.8e-3}", "pouring_gravity: 9.81", 50 * 9.81);
    std::vector<std::string> said;
    auto const packing = dem::pour_packing<2>(c, [&](std::string const& line) { said.push_back(line); });
    CHECK(packing.kinetic_ratio <= dem::settled_kinetic_ratio);
    auto const stage = [&](char const* name) {
        return std::find_if(said.begin(), said.end(),
                            [&](auto const& line) { return line.find(name) != std::string::npos; });
    };
    CHECK(stage("pouring") < stage("resting under its first weight"));
    CHECK(stage("resting under its first weight") < stage("relaxing"));
    dem::Config light = c;
    light.gravity.y = -9.81;
    light.column->pouring_gravity = 0.0;
    auto const before = dem::pour_packing<2>(light);
    CHECK(deepest<2>(c, packing) > 10.0 * deepest<2>(light, before));
    CHECK(highest(packing) < highest(before) + 0.1e-3);
}

TEST_CASE("packing: a column that a wall leaves no room for is an error, not a loop without end")
{
    for (std::string const preparation : {"poured", "random", "regular"}) {
        dem::Config c = column("{min: 1e-3, max: 1.8e-3}", "preparation: " + preparation);
        dem::WallConfig lid = c.walls[0];
        lid.name = "lid";
        lid.point = {0.0, 2.5e-3, 0.0};
        lid.normal = {0.0, -1.0, 0.0};
        c.walls.push_back(lid);
        CHECK_THROWS_WITH_AS(dem::pour_packing<2>(c), doctest::Contains("has room for"), sluice::Error);
    }
}
