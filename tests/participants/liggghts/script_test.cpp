#include "participants/liggghts/script.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "coupler/scene/reader.hpp"
#include "participants/dem/setup.hpp"
#include "tests/support/changed.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

std::string const spheres =
    "density: 2500\n"
    "contact: {normal_stiffness: 1e5, damping_ratio: 0.08, tangential_damping: 0.1, friction: 0.3, rolling_friction: "
    "0.05}\n"
    "walls:\n"
    "  - {name: floor, point: [0, 0, 0.01], normal: [0, 0, 1]}\n"
    "  - {name: side, point: [0, 0, 0], normal: [1, 0, 0], friction: 0}\n"
    "grains:\n"
    "  - {position: [0.02, 0.01, 0.02], radius: 0.004, velocity: [1, 2, 3], spin: [4, 5, 6]}\n"
    "  - {position: [0.04, 0.01, 0.02], radius: 0.002}\n";

dem::Config read(std::string const& text, int dimension = 3)
{
    return dem::read_config(sluice::read_yaml(text, "scene.yaml"), dimension,
                            dimension == 3 ? dem::Vec3{0, 0, -9.81} : dem::Vec3{0, -9.81, 0});
}

template <int D>
liggghts::SizeClasses classes(dem::Config const& config)
{
    auto const grains = dem::listed_grains<D>(config);
    std::vector<double> radius;
    for (auto const& place : grains.place) radius.push_back(place.radius);
    return liggghts::classes_of(grains.mass, radius, 32);
}

template <int D = 3>
std::string script(dem::Config const& config, double now = 0.0)
{
    return liggghts::script_of(config, classes<D>(config), "read_data grains", now);
}

//! The numbers of a property of pairs of types, row by row.
std::vector<double> matrix(std::string const& text, std::string const& name)
{
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        auto const key = "property/global " + name + " peratomtypepair ";
        auto const at = line.find(key);
        if (at == std::string::npos) continue;
        std::istringstream words(line.substr(at + key.size()));
        std::vector<double> numbers;
        std::size_t types = 0;
        words >> types;
        for (double number; words >> number;) numbers.push_back(number);
        REQUIRE(numbers.size() == types * types);
        return numbers;
    }
    FAIL("no property " << name);
    return {};
}

std::string refused(std::string const& text, int dimension = 3)
{
    std::string all;
    for (auto const& [key, why] : liggghts::refusals(read(text, dimension))) all += key + " " + why + "\n";
    return all;
}

}  // namespace

TEST_CASE("script: dashpots of each pair of types are those of the masses, at walls of the grain's own")
{
    auto const config = read(spheres);
    auto const gamma = matrix(script(config), "gamman_abs"), tangential = matrix(script(config), "gammat_abs");
    double const pi = std::acos(-1.0), light = 2500.0 * 4.0 / 3.0 * pi * 8e-9, heavy = 8.0 * light;
    auto const of = [](double alpha, double k, double mass) { return 2.0 * alpha * std::sqrt(k * mass); };
    // types: light, heavy, floor, side
    CHECK(gamma[0] == close_to(of(0.08, 1e5, light / 2)).epsilon(1e-12));
    CHECK(gamma[1] == close_to(of(0.08, 1e5, light * heavy / (light + heavy))).epsilon(1e-12));
    CHECK(gamma[2] == close_to(of(0.08, 1e5, light)).epsilon(1e-12));
    CHECK(gamma[7] == close_to(of(0.08, 1e5, heavy)).epsilon(1e-12));
    CHECK(tangential[1] == close_to(of(0.1, 2e5 / 7, light * heavy / (light + heavy))).epsilon(1e-12));
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            CHECK(gamma[static_cast<std::size_t>(4 * i + j)] == gamma[static_cast<std::size_t>(4 * j + i)]);
}

TEST_CASE("script: each wall has a type of its own, with its friction, and one that is gone is left out")
{
    auto const gate = changed(spheres, "friction: 0}", "friction: 0, removed_at: 0.5}");
    auto const text = script(read(gate));
    auto const friction = matrix(text, "coefficientFriction");
    CHECK(friction[0] == 0.3);
    CHECK(friction[2] == 0.3);
    CHECK(friction[3] == 0.0);
    CHECK(contains(text,
                   "fix wall_0 all wall/gran model hooke/stiffness tangential history rolling_friction epsd3 "
                   "primitive type 3 zplane 0.01"));
    CHECK(contains(text, "primitive type 4 xplane 0 "));
    auto const later = script(read(gate), 0.5);
    CHECK(!contains(later, "fix wall_1 "));
    CHECK(contains(later, "fix wall_0 "));
}

TEST_CASE("script: the resistance to rolling has our stiffness and dashpot")
{
    auto const config = read(spheres);
    auto const text = script(config);
    CHECK(contains(text, "rollingStiffness scalar"));
    auto const at = text.find("rollingStiffness scalar") + 24;
    // kr = number kn mu_r^2 R*^2 is to be kt R*^2
    CHECK(std::stod(text.substr(at)) == close_to(2.0 / 7.0 / (0.05 * 0.05)).epsilon(1e-12));
    auto const share = matrix(text, "coefficientRollingViscousDamping");
    // a wall: ours 2 a sqrt(kr m) R^2, LIGGGHTS' 2 v sqrt(1.4 m R^2 kr R^2)
    CHECK(share[2] == close_to(0.3 / std::sqrt(1.4)).epsilon(1e-12));
    // two equal grains: R* = R/2, m* = m/2; I = 1.4 m R^2 / 2
    CHECK(share[0] == close_to(0.3 * 0.5 / std::sqrt(1.4)).epsilon(1e-12));
}

TEST_CASE("script: a wall with another resistance to rolling has the law with our stiffness, without a dashpot")
{
    auto const config = read(changed(spheres, "friction: 0}", "contact: {rolling_friction: 0.2}}"));
    CHECK(liggghts::refusals(config).empty());
    auto const text = script(config);
    CHECK(contains(text, "rolling_friction epsd3 primitive type 3 "));
    CHECK(contains(text, "rolling_friction epsd2 primitive type 4 "));
    CHECK(matrix(text, "coefficientRollingFriction")[3] == 0.2);
    auto const said = liggghts::differences(config, classes<3>(config));
    REQUIRE(said.size() == 1);
    CHECK(contains(said[0], "rolling on \"side\" is by epsd2"));
}

TEST_CASE("script: gravity is less the buoyancy")
{
    auto const text = script(read(spheres + "buoyancy: {density: 1000}\n"));
    auto const at = text.find("fix gravity all gravity ") + 24;
    CHECK(std::stod(text.substr(at)) == close_to(9.81 * (1.0 - 1000.0 / 2500.0)).epsilon(1e-12));
    CHECK(contains(text, "vector 0 0 -1\n"));
}

TEST_CASE("script: grains are listed as they are, discs in a plane")
{
    auto const config = read(spheres);
    auto const data = liggghts::data_of(config, dem::listed_grains<3>(config), classes<3>(config));
    CHECK(contains(data, "\n2 atoms\n4 atom types\n"));
    CHECK(contains(data, "\n1 2 0.0080000000000000002 2500"));
    CHECK(contains(data, "\n1 1 2 3 4 5 6\n"));
    auto const disc = read(
        "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n"
        "grains: [{position: [0.1, 0.2], radius: 0.001, velocity: [1, 2], spin: 3}]\n",
        2);
    auto const flat = liggghts::data_of(disc, dem::listed_grains<2>(disc), classes<2>(disc));
    CHECK(contains(flat, "0.10000000000000001 0.20000000000000001 0\n"));
    CHECK(contains(flat, "\n1 1 2 0 0 0 3\n"));
    CHECK(contains(script<2>(disc), "dimension 2\nboundary m m p\n"));
    CHECK(contains(script<2>(disc), "enforce2d"));
}

TEST_CASE("script: what LIGGGHTS cannot do is refused, key by key, with what to try")
{
    CHECK(refused(spheres).empty());
    struct
    {
        char const *from, *to, *says;
    } const cases[] = {
        {"normal: [1, 0, 0]", "normal: [1, 0, 1]", "walls \"side\" is oblique"},
        {"friction: 0}", "velocity: [0.1, 0, 0]}", "walls \"side\" moves"},
        {"friction: 0}", "contact: {rolling_friction: 0.1, rolling_ratio: 0.5}}",
         "walls \"side\" resists rolling with rolling_ratio 0.5"},
        {"density: 2500\n", "density: 2500\nsleep: {speed: 1e-5, time: 0.005}\n", "sleep is nothing"},
        {"density: 2500\n", "density: 2500\ngravity_ramp: {time: 0.5}\n", "gravity_ramp is not handed"},
        {"density: 2500\n", "density: 2500\nlubrication: {viscosity: 1e-3, cutoff: 1e-3}\n", "lubrication is no"},
        {"density: 2500\n", "density: 2500\nmeasures: [force_chains]\n", "measures asks for"},
        {"density: 2500\n", "density: 2500\naverages: [{name: b, min: [0, 0, 0], max: [1, 1, 1]}]\n", "averages needs"},
        {"normal_stiffness: 1e5, damping_ratio: 0.08, tangential_damping: 0.1",
         "law: hertz, youngs_modulus: 1e8, damping_ratio: 0.08, tangential_damping: 0.1",
         "contact contacts have tangential_damping 0.1"},
    };
    for (auto const& [from, to, says] : cases) {
        auto const said = refused(changed(spheres, from, to));
        CAPTURE(said);
        CHECK(contains(said, says));
    }
}

TEST_CASE("script: classes that are not exact are told")
{
    auto const config = read(spheres);
    CHECK(liggghts::differences(config, classes<3>(config)).empty());
    liggghts::SizeClasses some = classes<3>(config);
    some.spread = 0.009;
    auto const said = liggghts::differences(config, some);
    REQUIRE(said.size() == 1);
    CHECK(contains(said[0], "off by up to 0.9 %"));
}
