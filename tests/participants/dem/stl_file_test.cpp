#include "participants/files/stl_file.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "participants/dem/checkpoint.hpp"
#include "participants/dem/packing_file.hpp"
#include "participants/dem/setup.hpp"
#include "tests/participants/dem/mesh_scenes.hpp"

using namespace unit;

namespace {

std::string const two_facets =
    "solid plate\n"
    "  facet normal 0 0 1\n"
    "    outer loop\n"
    "      vertex 0 0 0\n"
    "      vertex 1 0 0\n"
    "      vertex 1.0e+0 1 -0.5\n"
    "    endloop\n"
    "  endfacet\n"
    "\n"
    "  facet normal 0 0 1\n"
    "    outer loop\n"
    "      vertex 0 0 0\n"
    "      vertex 1 1 -0.5\n"
    "      vertex 0 1 0\n"
    "    endloop\n"
    "  endfacet\n"
    "endsolid plate\n";

Triangles const both{{Vec3{0, 0, 0}, {1, 0, 0}, {1, 1, -0.5}}, {Vec3{0, 0, 0}, {1, 1, -0.5}, {0, 1, 0}}};

void put(std::string& to, std::uint32_t value)
{
    for (int k = 0; k < 4; ++k) to += static_cast<char>(value >> 8 * k & 0xff);
}

std::string binary(Triangles const& triangles, std::string header = "made by nobody")
{
    header.resize(80);
    put(header, static_cast<std::uint32_t>(triangles.size()));
    for (auto const& corners : triangles) {
        header.append(12, '\0');
        for (Vec3 const& v : corners)
            for (double const x : {v.x, v.y, v.z}) put(header, std::bit_cast<std::uint32_t>(static_cast<float>(x)));
        header.append(2, '\0');
    }
    return header;
}

std::string replaced(std::string text, std::string const& from, std::string const& to)
{
    return text.replace(text.find(from), from.size(), to);
}

//! A folder with a file that holds what a test wants.
struct Desk
{
    sluice::ScratchDirectory folder{"stl"};
    std::filesystem::path file = folder.path() / "wall.stl";

    void write(std::string const& content) const { std::ofstream(file, std::ios::binary) << content; }
    Triangles read(std::string const& content) const
    {
        write(content);
        Triangles all;
        for (auto const& [a, b, c] : files::read_stl(file))
            all.push_back({Vec3{a[0], a[1], a[2]}, {b[0], b[1], b[2]}, {c[0], c[1], c[2]}});
        return all;
    }
    void refuses(std::string const& content, std::string const& message) const
    {
        CHECK_THROWS_WITH_AS(read(content), doctest::Contains((file.string() + message).c_str()), sluice::Error);
    }
};

std::string scene_with(std::string const& wall)
{
    return "density: 2650\ncontact: {normal_stiffness: 1e4, damping_ratio: 0.2, friction: 0.5}\nwalls:\n  - {name: "
           "w, " +
           wall + "}\ngrains:\n  - {position: [0.1, 0.1, 0.1], radius: 0.005}\n";
}
std::string in_plane(std::string text)
{
    return replaced(std::move(text), "[0.1, 0.1, 0.1]", "[0.1, 0.1]");
}
dem::Config config_of(std::string const& text, std::filesystem::path const& scene, int dimension = 3)
{
    return dem::read_config(sluice::read_yaml(text, scene.string()), dimension, {});
}

}  // namespace

TEST_CASE("stl: a text and a binary file hold the same facets")
{
    Desk const desk;
    CHECK(desk.read(two_facets) == both);
    CHECK(desk.read(binary(both)) == both);
    CHECK(desk.read(binary(both, "solid ball, as some programs begin a binary file")) == both);
    std::string shouted = two_facets, with_returns;
    for (char& c : shouted) c = static_cast<char>(std::toupper(c));
    CHECK(desk.read(shouted) == both);
    for (char const c : two_facets) with_returns += c == '\n' ? std::string("\r\n") : std::string(1, c);
    CHECK(desk.read(with_returns) == both);
    CHECK(desk.read(two_facets + two_facets).size() == 4);  // several solids
}

TEST_CASE("stl: a broken text is refused with its line")
{
    Desk const desk;
    desk.refuses("solid none\nendsolid none\n", ": holds no facets");
    desk.refuses(replaced(two_facets, "1.0e+0 1 -0.5", "1.0e+0 one -0.5"),
                 ":6: vertex 1.0e+0 one -0.5 (needed: three finite numbers).");
    desk.refuses(replaced(two_facets, "1 0 0", "nan 0 0"), ":5: vertex nan 0 0 (needed: three finite numbers).");
    desk.refuses(replaced(two_facets, "1 0 0", "inf 0 0"), ":5: vertex inf 0 0");
    desk.refuses(replaced(two_facets, "1 0 0", "1 0"), ":5: vertex 1 0 (needed: three finite numbers).");
    desk.refuses(replaced(two_facets, "1 0 0", "1 0 0 0"), ":5: vertex 1 0 0 0 (needed: three numbers and no more).");
    desk.refuses(replaced(two_facets, "      vertex 1 0 0\n", ""), ":6: begins with \"endloop\" (needed: vertex).");
    desk.refuses(replaced(two_facets, "endloop", "vertex 0 0 1"), ":7: begins with \"vertex\" (needed: endloop).");
    desk.refuses(replaced(two_facets, "endsolid", "end"),
                 ":17: begins with \"end\" (needed: facet, endsolid or solid).");
    desk.refuses(replaced(two_facets, "1.0e+0 1 -0.5", "2 0 0"), ":2: the facet has corners on one line");
    desk.refuses(replaced(two_facets, "vertex 1 0 0", "vertex 0 0 0"), ":2: the facet has corners on one line");
}

TEST_CASE("stl: a broken binary file is refused with its facet")
{
    Desk const desk;
    desk.refuses("", ": has 0 bytes");
    desk.refuses(binary({}), ": holds no facets");
    desk.refuses(binary(both) + "x", ": has 185 bytes (a binary STL of 2 facets, as it says, needs 184");
    Triangles wrong = both;
    wrong[1][2] = wrong[1][0];
    desk.refuses(binary(wrong), ": facet 2: has corners on one line (must have an area). Remove it.");
    wrong[1][2].y = std::numeric_limits<double>::quiet_NaN();
    desk.refuses(binary(wrong), ": facet 2: has a corner that is no number (needed: three finite numbers).");
    wrong[1][2].y = std::numeric_limits<double>::infinity();
    desk.refuses(binary(wrong), ": facet 2: has a corner that is no number");
    std::string most = binary(both);
    for (std::size_t k = 80; k < 84; ++k) most[k] = '\xff';
    desk.refuses(most, ": has 184 bytes (a binary STL of 4294967295 facets, as it says, needs 214748364834");
    CHECK_THROWS_WITH_AS(files::read_stl(desk.folder.path() / "none.stl"), doctest::Contains("none.stl cannot be read"),
                         sluice::Error);
    CHECK_THROWS_WITH_AS(files::read_stl(desk.folder.path()), doctest::Contains("cannot be read"), sluice::Error);
}

TEST_CASE("stl: a file cut off anywhere is refused, and one with a changed byte is read or refused")
{
    Desk const desk;
    auto const whole = binary(both), solid = binary(both, "solid");
    for (std::size_t size = 0; size < whole.size(); ++size) {
        CHECK_THROWS_AS(desk.read(whole.substr(0, size)), sluice::Error);
        CHECK_THROWS_AS(desk.read(solid.substr(0, size)), sluice::Error);
    }
    // a text may lose the name behind its last word, and half of that word is none
    for (std::size_t size = 0; size < two_facets.find("endsolid") + 8; ++size)
        CHECK_THROWS_AS(desk.read(two_facets.substr(0, size)), sluice::Error);
    dem::Random random(1);
    int read = 0;
    for (std::string const& good : {whole, two_facets})
        for (int k = 0; k < 1000; ++k) {
            std::string bad = good;
            auto const at = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(bad.size())));
            bad[at] = static_cast<char>(random.uniform(-128.0, 128.0));
            try {
                for (auto const& corners : desk.read(bad))
                    for (Vec3 const& v : corners) CHECK(std::isfinite(norm(v)));
                ++read;
            } catch (sluice::Error const&) {
            }
        }
    CHECK(read > 100);
    CHECK(read < 1900);
}

TEST_CASE("mesh: a scene names a file beside it and its scale, and a packing and a checkpoint know the mesh")
{
    Desk const desk;
    auto const scene = desk.folder.path() / "scene.yaml";
    desk.read(two_facets);
    std::string const text = scene_with("mesh: {file: wall.stl, scale: 1.0e-3}, friction: 0.3, removed_at: 2");
    dem::Config const config = config_of(text, scene);
    REQUIRE(config.walls.at(0).mesh);
    CHECK(config.walls[0].mesh->corner.at(1)[1] == Vec3{1e-3, 1e-3, -0.5e-3});
    CHECK(config.walls[0].contact.friction == 0.3);
    CHECK(config.walls[0].removed_at == 2.0);
    auto const setup = dem::make_setup<3>(config);
    CHECK(std::get<dem::Mesh<3>>(setup.walls[0].shape).facets->facets().size() == 2);

    sluice::State kept;
    dem::keep_source(config, kept);
    CHECK_NOTHROW(dem::require_source(config, kept));
    auto const name = dem::packing_file_name(config);
    desk.read(replaced(two_facets, "1 0 0", "1 0 0.1"));
    dem::Config const other = config_of(text, scene);
    CHECK_THROWS_WITH_AS(dem::require_source(other, kept), doctest::Contains("wall.stl holds other facets"),
                         sluice::Error);
    CHECK(dem::packing_file_name(other) != name);
}

TEST_CASE("mesh: what a scene may not say of one")
{
    Desk const desk;
    auto const scene = desk.folder.path() / "scene.yaml";
    desk.read(two_facets);
    auto const refused = [&](std::string const& text, char const* message, int dimension = 3) {
        CHECK_THROWS_WITH_AS(config_of(text, scene, dimension), doctest::Contains(message), sluice::Error);
    };
    refused(scene_with("mesh: {file: none.stl}"), "none.stl cannot be read");
    refused(scene_with("mesh: {file: wall.stl, scale: 0}"), "scale");
    refused(scene_with("mesh: {file: wall.stl, scael: 1}"), "scael");
    refused(scene_with("mesh: {file: wall.stl}, normal: [0, 0, 1]"), "normal");
    desk.read(replaced(two_facets, "1 0 0", "4 0 0"));
    refused(scene_with("mesh: {file: wall.stl, scale: 5e5}"), "has a corner at 2e+06 m along an axis");
    refused(in_plane(scene_with("mesh: {file: wall.stl}")), "is a surface in space (in the plane give segments)", 2);
    refused(scene_with("segments: [{from: [0, 0], to: [1, 0]}]"), "are walls of the plane (in space give mesh)");
    refused(in_plane(scene_with("segments: []")), "has no entry", 2);
    refused(in_plane(scene_with("segments: [{from: [1, 0], to: [1, 0]}]")), "is where the segment begins", 2);
    refused(scene_with("mesh: {file: wall.stl}") + "periodic: {x: [0, 1]}\n", "has the mesh \"w\" beside periodic");
    desk.write(replaced(two_facets, "1 0 0", "1 0"));
    refused(scene_with("mesh: {file: wall.stl}"), "wall.stl:5: vertex 1 0 (needed: three finite numbers)");

    auto const config =
        config_of(in_plane(scene_with("segments: [{from: [0, 0], to: [1, 0]}, {from: [1, 0], to: [1, 2]}]")), scene, 2);
    auto const setup = dem::make_setup<2>(config);
    auto const& facets = std::get<dem::Mesh<2>>(setup.walls.at(0).shape).facets->facets();
    REQUIRE(facets.size() == 2);
    CHECK(facets[1].corner[1] == dem::Vec2{1, 2});
    CHECK(norm(facets[1].normal) == 1.0);
}
