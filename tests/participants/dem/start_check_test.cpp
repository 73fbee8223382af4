#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "tests/participants/dem/scenes.hpp"

using namespace unit;

namespace {

std::string const head = "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n";
std::string const floor_and_sides =
    "walls:\n"
    "  - {name: floor, point: [0, 0], normal: [0, 1]}\n"
    "  - {name: left, point: [0, 0], normal: [1, 0]}\n"
    "  - {name: right, point: [0.1, 0], normal: [-1, 0]}\n";

std::string grain(char const* position, char const* radius = "0.001")
{
    return std::string("  - {position: ") + position + ", radius: " + radius + "}\n";
}

void check_refused(std::string const& text, std::string const& message, int dimension = 2)
{
    dem::Vec3 const gravity = dimension == 2 ? dem::Vec3{0, -9.81, 0} : dem::Vec3{0, 0, -9.81};
    CHECK_THROWS_WITH_AS(dem::read_config(sluice::read_yaml(text, "grains.yaml"), dimension, gravity),
                         doctest::Contains(message.c_str()), sluice::Error);
}

}  // namespace

TEST_CASE("start: grains behind a wall are refused when the scene is read, with the first of them and how many")
{
    std::string const text = head + floor_and_sides + "grains:\n";
    CHECK(config(text + grain("[0.05, 0.001]")).warnings.empty());
    check_refused(text + grain("[0.05, 0.001]") + grain("[0.05, -0.001]"),
                  "grains.yaml:7:1: grains: the centre of grain 1 is behind wall \"floor\"");
    check_refused(text + grain("[0.05, -0.001]") + grain("[0.05, -0.002]"),
                  "grain 0 (one of 2) is behind wall \"floor\"");
    sluice::ScratchDirectory const folder("start");
    auto const file = folder.path() / "grains.csv";
    std::ofstream(file) << "id,x,y,radius\n12,0.05,0.01,0.001\n77,0.2,0.01,0.001\n";
    check_refused(head + floor_and_sides + "packing: {file: " + file.string() + "}\n",
                  "packing: the centre of grain 77 is behind wall \"right\"");
}

TEST_CASE("start: a grain that is larger than its box or its cylinder is refused")
{
    check_refused(head + floor_and_sides + "grains:\n" + grain("[0.05, 0.06]", "0.0501"),
                  "the largest grain, of 0.1002 m, is too large for the gap of \"left\" and \"right\", 0.1 m");
    CHECK_NOTHROW(config(head + floor_and_sides + "grains:\n" + grain("[0.05, 0.06]", "0.05")));
    check_refused(head +
                      "walls:\n  - {name: drum, cylinder: {point: [0, 0], radius: 0.01, grains: inside}}\ngrains:\n" +
                      grain("[0, 0]", "0.011"),
                  "too large for the cylinder \"drum\", 0.02 m");
    CHECK_NOTHROW(
        config(head + "walls:\n  - {name: pin, cylinder: {point: [0, 0], radius: 0.01, grains: outside}}\ngrains:\n" +
               grain("[0, 0.03]", "0.011")));
    check_refused(
        "density: 2650\ndiameter: {min: 7.0e-3, max: 9.0e-3}\n"
        "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\nwalls:\n"
        "  - {name: floor, point: [0, 0, 0], normal: [0, 0, 1]}\n  - {name: x, point: [0, 0, 0], normal: [1, 0, 0]}\n"
        "  - {name: y, point: [0, 0, 0], normal: [0, 1, 0]}\n  - {name: back, point: [0, 8e-3, 0], normal: [0, -1, "
        "0]}\n"
        "column: {container: box, depth: 8e-3, count: 200, aspect_ratio: 1}\n",
        "too large for the gap of \"y\" and \"back\", 0.008 m", 3);
}

TEST_CASE("start: overlaps with grains and walls are warned about, the deepest by name")
{
    auto const warnings = [](std::string const& grains) {
        return config(head + floor_and_sides + "grains:\n" + grains).warnings;
    };
    auto const at_wall = warnings(grain("[0.0005, 0.01]"));
    REQUIRE(at_wall.size() == 1);
    // a quarter of the diameter: the spring holds 1e6 (0.5e-3)^2 / 2
    CHECK(at_wall[0].find("up to 0.25 of a diameter; the contacts hold 0.125 J") != std::string::npos);
    CHECK(at_wall[0].find("Deepest: grain 0 and wall \"left\".") != std::string::npos);
    auto const pair = warnings(grain("[0.01, 0.01]") + grain("[0.02, 0.01]") + grain("[0.0212, 0.01]"));
    REQUIRE(pair.size() == 1);
    CHECK(pair[0].find("Deepest: grains 1 and 2.") != std::string::npos);
    CHECK(warnings(grain("[0.00099, 0.01]")).empty());  // half a percent, as under a load
}

TEST_CASE("start: what is no number, or no stiffness, is refused")
{
    check_refused(head + "grains:\n" + grain("[.nan, 0]"), "position");
    check_refused(head + "grains:\n" + grain("[.inf, 0]"), "position");
    check_refused(head + "grains:\n" + grain("[0, 0]", "0"), "radius");
    check_refused(head + "grains:\n" + grain("[0, 0]", "-1"), "radius");
    check_refused("density: .nan\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\ngrains:\n" +
                      grain("[0, 0]"),
                  "density");
    check_refused(
        "density: 2650\ncontact: {normal_stiffness: 0, damping_ratio: 0.2, friction: 0.5}\ngrains:\n" + grain("[0, 0]"),
        "contact.normal_stiffness = 0 N/m (must be");
    check_refused(
        "density: 2650\ncontact: {law: hertz, youngs_modulus: 0, damping_ratio: 0.2, friction: 0.5}\ngrains:\n" +
            grain("[0, 0]"),
        "contact.youngs_modulus = 0 Pa (must be");
}
