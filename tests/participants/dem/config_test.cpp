#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/changed.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

dem::Config in_space(std::string const& text)
{
    return dem::read_config(sluice::read_yaml(text, "grains.yaml"), 3, {0.0, 0.0, -9.81});
}

std::string message_of(std::string const& text, int dimension)
{
    try {
        dimension == 2 ? config(text) : in_space(text);
    } catch (sluice::Error const& e) {
        return e.what();
    }
    return {};
}

//! The text is refused, with one message that holds `part`.
void check_refused(std::string const& text, std::string const& part, int dimension = 2)
{
    std::string const message = message_of(text, dimension);
    CHECK_MESSAGE(message.find(part) != std::string::npos, "\"" << message << "\" should hold \"" << part << "\"");
    CHECK_MESSAGE(message.find('\n') == std::string::npos, message);
}

}  // namespace

TEST_CASE("config: a column with its walls, gate and defaults")
{
    dem::Config const c = config();
    CHECK(c.contact.friction == close_to(std::tan(26.0 * std::numbers::pi / 180.0)));
    CHECK(c.contact.tangential_stiffness == close_to(2e6 / 7.0));
    REQUIRE(c.walls.size() == 3);
    CHECK(c.walls[2].name == "gate");
    CHECK(c.walls[2].point.x == close_to(dem::column_width(c)));
    auto const looser = config(changed(scene, "seed: 3", "packing_fraction: 0.41"));  // half of what is assumed
    CHECK(dem::column_width(looser) == close_to(std::sqrt(2) * dem::column_width(c)));
    CHECK(c.walls[2].removed_at == 0.0);
    CHECK(c.walls[0].contact.friction == c.contact.friction);
    CHECK(c.step == close_to(c.contact_time / 50.0));
    CHECK(c.contact_time == close_to(std::numbers::pi * std::sqrt(0.5 * 2650 * std::numbers::pi * 0.25e-6 / 1e6)));
    CHECK(c.warnings.empty());
}

TEST_CASE("config: restitution instead of the damping ratio, friction instead of the angle")
{
    dem::Config const c =
        config(changed(scene, "damping_ratio: 0.2, friction_angle: 26", "restitution: 0.8, friction: 0.3"));
    CHECK(dem::restitution(c.contact.damping_ratio) == close_to(0.8));
    CHECK(c.contact.friction == 0.3);
}

TEST_CASE("config: a long step is warned about above t_c/15 and refused above t_c/5")
{
    double const tc = config().contact_time;
    auto with_step = [](double step) { return std::string(scene) + "step: " + std::to_string(step * 1e6) + "e-6\n"; };
    CHECK(config(with_step(tc / 16.0)).warnings.empty());
    REQUIRE(config(with_step(tc / 14.0)).warnings.size() == 1);
    CHECK(config(with_step(tc / 14.0)).warnings[0].find("t_c/15") != std::string::npos);
    check_refused(with_step(tc / 4.9), "at most t_c/5");
    check_refused(std::string(scene) + "step: fast\n", "step = fast is not a number (must be > 0");
    CHECK(config(std::string(scene) + "step: auto\n").step == config().step);
}

TEST_CASE("config: overlaps of listed grains are stated with their energy")
{
    std::string const head =
        "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\ngrains:\n";
    auto pair = [&](char const* x) {
        return config(head + "  - {position: [0, 0], radius: 0.001}\n  - {position: [" + x + ", 0], radius: 0.001}\n");
    };
    CHECK(pair("0.002").warnings.empty());
    REQUIRE(pair("0.001").warnings.size() == 1);
    CHECK(pair("0.001").warnings[0].find("up to 0.5 of a diameter; the contacts hold 0.5 J") != std::string::npos);
    for (char const* within : {"0.0009", "0"})
        CHECK_THROWS_WITH_AS(pair(within),
                             doctest::Contains("grains.yaml:3:1: grains: the centre of grain 1 lies within grain 0"),
                             sluice::Error);
}

TEST_CASE("config: each mistake gives one clear message")
{
    check_refused(changed(scene, "density: 2650", "density: -1"), "density");
    check_refused(changed(scene, "damping_ratio: 0.2, ", ""), "give damping_ratio or restitution");
    check_refused(changed(scene, "damping_ratio: 0.2", "damping_ratio: 0.2, restitution: 0.5"), "second damping");
    check_refused(changed(scene, "friction_angle: 26", "friction_angle: 26, friction: 0.5"), "second friction");
    check_refused(changed(scene, ", friction_angle: 26", ""), "give friction [-] or friction_angle");
    check_refused(changed(scene, "min: 1.0e-3", "min: 3.0e-3"), "must be at least min");
    check_refused(changed(scene, "min: 1.0e-3", "min: 1.0e-5"), "50 times");
    check_refused(changed(scene, "normal: [1, 0]", "normal: [-1, 0]"), "missing: {point: [0, 0], normal: [1, 0]}");
    check_refused(changed(scene, "normal: [1, 0]", "normal: [0, 0]"), "no length");
    check_refused(changed(scene, "name: back", "name: gate"), "a wall named gate");
    check_refused(changed(scene, "aspect_ratio: 0.8", "aspect_ratio: 40"), "less than 4 largest grains");
    check_refused(changed(scene, "seed: 3", "sed: 3"), "Did you mean seed?");
    check_refused(std::string(scene) + "grains:\n  - {position: [0, 1], radius: 0.001}\n", "beside column");
    CHECK_THROWS_WITH_AS(dem::read_config(sluice::read_yaml(scene, "grains.yaml"), 2, {9.81, 0.0, 0.0}),
                         doctest::Contains("gravity does not point down"), sluice::Error);
    check_refused(changed(scene, "seed: 3", "preparation: radnom"), "Did you mean random?");
    check_refused(changed(scene, "seed: 3", "preparation: random, packing_fraction: 0.9"), "packing_fraction = 0.9");
    check_refused(changed(scene, "seed: 3", "preparation: random, packing_friction: 0.1"),
                  "packing_friction is not a key");
    check_refused(changed(scene, "seed: 3", "preparation: regular, packing_fraction: 0.8"),
                  "packing_fraction is not a key");
    auto const weightless = [](std::string const& column) {
        return dem::read_config(sluice::read_yaml(changed(scene, "seed: 3", column), "grains.yaml"), 2, {});
    };
    CHECK_NOTHROW(weightless("preparation: regular"));
    CHECK_THROWS_WITH_AS(weightless("preparation: poured"), doctest::Contains("gravity does not point down"),
                         sluice::Error);
    CHECK_THROWS_WITH_AS(weightless("preparation: random, pouring_gravity: 9.81"),
                         doctest::Contains("pouring_gravity in a scene without gravity"), sluice::Error);
}

namespace {

char const* const spheres =
    "density: 2650\n"
    "diameter: {min: 7.0e-3, max: 9.0e-3}\n"
    "contact: {law: hertz, youngs_modulus: 1e7, poissons_ratio: 0.3, restitution: 0.6, friction: 0.4,"
    " rolling_friction: 0.05}\n"
    "walls:\n"
    "  - {name: floor, point: [0, 0, 0], normal: [0, 0, 2], contact: {youngs_modulus: 5e7, friction: 0.2}}\n"
    "  - {name: x, point: [0, 0, 0], normal: [1, 0, 0], friction: 0}\n"
    "  - {name: y, point: [0, 0, 0], normal: [0, 1, 0]}\n"
    "  - {name: drum, cylinder: {point: [0, 0, 0], axis: [0, 0, 3], radius: 1.5, grains: inside}, velocity: [0, 0, "
    "0.1],"
    " moves_until: 2}\n"
    "column: {container: quarter, count: 200, aspect_ratio: 1}\n";

}  // namespace

TEST_CASE("config: spheres with a law of Hertz, walls with their own matter, a cylinder that moves")
{
    dem::Config const c = in_space(spheres);
    CHECK(c.contact.elasticity == dem::Elasticity::hertz);
    CHECK(dem::restitution(c.contact.damping_ratio) == close_to(0.6));
    CHECK(c.contact.tangential_damping == c.contact.damping_ratio);
    CHECK(c.contact.rolling == dem::Rolling::elastic_plastic);
    REQUIRE(c.walls.size() == 5);
    CHECK(c.walls[0].normal == dem::Vec3{0, 0, 1});
    CHECK(c.walls[0].contact.youngs_modulus == 5e7);
    CHECK(c.walls[0].contact.poissons_ratio == 0.3);
    CHECK(c.walls[0].contact.rolling_friction == 0.05);
    CHECK(c.walls[1].contact.friction == 0.0);
    CHECK(c.walls[3].radius == 1.5);
    CHECK(c.walls[3].motion.shift(3.0).z == close_to(0.2));
    CHECK(c.walls[4].name == "gate");
    // a quarter of a cylinder as high as wide: N pi d3/6 / 0.61 = pi r^3 / 4, with the mean of d^3 of a uniform d
    double const cube = (7e-3 + 9e-3) * (7e-3 * 7e-3 + 9e-3 * 9e-3) / 4.0;
    CHECK(c.walls[4].radius == close_to(std::cbrt(200 * cube / 6.0 / 0.61 * 4.0)));
    dem::ContactLaw const floor = dem::contact_law(c.walls[0].contact), grains = dem::contact_law(c.contact);
    CHECK(floor.normal.stiffness == close_to(5.0 * grains.normal.stiffness));
    CHECK(floor.rolling.friction == 0.05);
    auto const setup = dem::make_setup<3>(c);
    CHECK(setup.features.rolling == dem::Rolling::elastic_plastic);
    CHECK(std::holds_alternative<dem::Cylinder<3>>(setup.walls[3].shape));
}

TEST_CASE("config: mistakes in space give one clear message each")
{
    auto const check = [](std::string const& from, std::string const& to, std::string const& part) {
        check_refused(changed(spheres, from, to), part, 3);
    };
    check("law: hertz", "law: hertzian", "Did you mean hertz?");
    check("youngs_modulus: 1e7, ", "", "youngs_modulus");
    check("poissons_ratio: 0.3", "poissons_ratio: 0.7", "poissons_ratio");
    check("youngs_modulus: 1e7", "youngs_modulus: 1e7, normal_stiffness: 1e5", "normal_stiffness is not a key");
    check("friction: 0.4, rolling_friction: 0.05", "friction: 0, rolling_friction: 0.05", "needs friction");
    check("container: quarter, count", "container: box, count", "depth");
    check("container: quarter", "container: cylindre", "Did you mean cylinder?");
    check("normal: [0, 1, 0]", "normal: [0, -1, 0]", "missing: {point: [0, 0, 0], normal: [0, 1, 0]}");
    check("normal: [0, 0, 2]", "normal: [0, 2]", "normal");
    check("axis: [0, 0, 3]", "axis: [0, 0, 0]", "no length");
    check("grains: inside", "grains: insde", "Did you mean inside?");
    check("moves_until: 2", "moves_til: 2", "Did you mean moves_until?");
    check("density: 2650", "scheme: liggghts\ndensity: 2650", "scheme: liggghts has no elastic_plastic rolling");
}
