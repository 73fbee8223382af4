#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/dem/fill.hpp"
#include "participants/dem/neighbours.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/changed.hpp"
#include "tests/support/close_to.hpp"

namespace {

std::string const cell =
    "density: 2650\n"
    "diameter: {min: 1.0e-3, max: 1.8e-3}\n"
    "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction_angle: 26}\n"
    "periodic: {x: [-0.01, 0.01], y: [0, 0.025]}\n"
    "fill: {count: 120, seed: 3}\n"
    "shear: {along: x, across: y, rate: 5.0, pressure: 1000}\n"
    "averages:\n"
    "  - {name: cell}\n"
    "  - {name: core, min: [-0.002, 0.005], max: [0.002, 0.01]}\n";
std::string const slope =
    "density: 2650\n"
    "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction_angle: 26}\n"
    "periodic: {x: [0, 0.02]}\n"
    "walls: [{name: floor, point: [0, 0], normal: [0, 1]}]\n"
    "grains:\n"
    "  - {position: [0.01, 0.002], radius: 0.001}\n";

dem::Config read(std::string const& text, double gravity, int dimension = 2)
{
    dem::Vec3 const down = dimension == 2 ? dem::Vec3{0, -gravity, 0} : dem::Vec3{0, 0, -gravity};
    return dem::read_config(sluice::read_yaml(text, "grains.yaml"), dimension, down);
}

//! Refused with one message that holds `part` and where it is.
void check_refused(std::string const& text, std::string const& part, double gravity = 0.0, int dimension = 2)
{
    std::string message;
    try {
        read(text, gravity, dimension);
    } catch (sluice::Error const& e) {
        message = e.what();
    }
    CHECK_MESSAGE(message.find(part) != std::string::npos, "\"" << message << "\" should hold \"" << part << "\"");
    CHECK_MESSAGE(message.find("grains.yaml:") == 0, message);
    CHECK_MESSAGE(message.find('\n') == std::string::npos, message);
}

}  // namespace

TEST_CASE("periodic config: sides, shear, filling, averages")
{
    dem::Config const c = read(cell, 0.0);
    dem::Setup<2> const s = dem::make_setup<2>(c);
    CHECK(s.features.periodic);
    CHECK(s.periodic.low == dem::Vec2{-0.01, 0.0});
    CHECK(s.periodic.extent == dem::Vec2{0.02, 0.025});
    CHECK(s.periodic.shear.rate == 5.0);
    CHECK(s.periodic.shear.pressure == 1000.0);
    CHECK(s.periodic.shear.steady_from == 1.0);
    // twice rho c of sound, c = d sqrt(kn / m) for the mean diameter and the lightest pair
    double const lightest = 2650 * std::numbers::pi * 0.25e-6;
    CHECK(s.periodic.shear.impedance == close_to(2 * 2650 * 1.4e-3 * std::sqrt(1e6 / lightest)));
    REQUIRE(c.averages.size() == 2);
    CHECK(c.averages[0].whole);
    CHECK(c.averages[1].high == dem::Vec3{0.002, 0.01, 0.0});
    dem::Config const along = read(slope, 9.81);
    CHECK(dem::make_setup<2>(along).features.periodic);
    CHECK_FALSE(dem::make_setup<2>(along).periodic.axis[1]);
    CHECK_FALSE(dem::make_setup<2>(unit::config()).features.periodic);
}

TEST_CASE("periodic config: a filling is within its cell, does not overlap, moves with the shear and can be repeated")
{
    dem::Config const c = read(cell, 0.0);
    dem::Grains<2> const g = dem::filling<2>(c), again = dem::filling<2>(c);
    REQUIRE(g.size() == 120);
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [centre, radius] = g.place[i];
        CHECK(centre.x - radius >= -0.01);
        CHECK(centre.x + radius <= 0.01);
        CHECK(centre.y + radius <= 0.025);
        CHECK(g.motion[i].velocity.x == close_to(5.0 * (centre.y - 0.0125)));
        CHECK(centre == again.place[i].centre);
    }
    std::vector<std::uint32_t> first, other;
    dem::find_pairs(g, 0.0, first, other);
    CHECK(other.empty());
    CHECK(dem::fill_pitch(c) >= 1.8e-3);
}

TEST_CASE("periodic config: each mistake gives one clear message")
{
    check_refused(changed(cell, "[-0.01, 0.01]", "[0.01, 0.01]"), "periodic.x: has no length");
    check_refused(changed(cell, "across: y", "across: x"), "shear.across: is the axis along which");
    check_refused(changed(cell, "along: x", "along: z"), "along = z");
    check_refused(changed(cell, "rate: 5.0", "rate: 0"), "rate");
    check_refused(changed(cell, "rate: 5.0", "rate: 5e4"), "shear: moves the sides too far in a step");
    check_refused(changed(cell, "count: 120", "count: 400"), "fill: has room for grains of");
    check_refused(changed(cell, "seed: 3", "sed: 3"), "Did you mean seed?");
    check_refused(cell + "scheme: liggghts\n", "scheme: liggghts has no periodic sides");
    check_refused(changed(cell, "[0, 0.025]", "[0, 0.0039]"), "periodic: is 0.0039 m long, too short");
    check_refused(changed(cell, "max: [0.002, 0.01]", "max: [0.002, 0.004]"), "averages[1].max: is not above min");
    check_refused(cell, "has no wall that gravity could rest on", 9.81);
    check_refused(cell + "walls: [{name: lid, point: [0, 0.025], normal: [0, -1]}]\n", "would have to be sheared");
    check_refused(changed(slope, "normal: [0, 1]", "normal: [1, 10]"),
                  "\"floor\", which does not go on across the periodic sides along x", 9.81);
    check_refused(changed(slope, "position: [0.01", "position: [0.02"), "number 0 outside the periodic cell", 9.81);
    check_refused(slope + "averages: [{name: all}]\n", "has no box", 9.81);
    check_refused(changed(slope, "grains:\n  - {position: [0.01, 0.002], radius: 0.001}\n",
                          "diameter: {min: 1e-3, max: 1e-3}\nfill: {count: 10}\n"),
                  "y is not", 9.81);
    check_refused(std::string(unit::scene) + "periodic: {x: [0, 0.1]}\n", "column: stands against walls", 9.81);
    check_refused(
        "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.4}\n"
        "periodic: {x: [0, 0.02], z: [0, 0.02]}\n"
        "walls: [{name: pipe, cylinder: {point: [0.01, 0, 0.01], axis: [1, 0, 0], radius: 0.005}}]\n"
        "grains: [{position: [0.01, 0, 0.01], radius: 0.001}]\n",
        "needed: an axis along it", 0.0, 3);
}
