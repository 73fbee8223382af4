#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "participants/dem/measures.hpp"
#include "participants/dem/packing_file.hpp"
#include "tests/participants/dem/scenes.hpp"

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
    CHECK(replaced("count: 60", "count: 61") != name);
    CHECK(replaced("friction_angle: 26", "friction_angle: 25") != name);
}
