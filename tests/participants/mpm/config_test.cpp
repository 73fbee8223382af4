#include "participants/mpm/config.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/scene/reader.hpp"
#include "participants/mpm/law_config.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

std::string const domain = "domain: {size: [0.4, 0.2]}\ncell: 0.01\n";
std::string const material =
    "material: {law: mohr_coulomb, density: 1900, youngs_modulus: 2e6, poissons_ratio: 0.25, friction_angle: 23}\n";
std::string const column = "column: {width: 0.1, aspect_ratio: 0.8}\n";

mpm::Config read(std::string const& text, int dimension = 2, bool grains = false, bool fluid = false)
{
    sluice::Reader reader = sluice::read_yaml(text, "scene.yaml");
    return mpm::read_config(reader, dimension, {0, -9.81, 0}, {.grains = grains, .fluid = fluid});
}

std::string errors(std::string const& text, int dimension = 2, bool grains = false, bool fluid = false)
{
    try {
        read(text, dimension, grains, fluid);
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::config);
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("config: defaults")
{
    mpm::Config const c = read(domain + material + column);
    CHECK(c.points == 2);
    CHECK(c.basis == mpm::BasisKind::gimp);
    CHECK(c.width == mpm::Width::fixed);
    CHECK(c.scheme == mpm::Scheme::musl);
    CHECK(c.flip == 0.99);
    CHECK(c.affine);
    CHECK(c.shared_volume);
    CHECK(!c.front_depth);
    CHECK(c.threads == 1);
    CHECK(!read(domain + "material: {law: linear_elastic, density: 1900, youngs_modulus: 2e6, poissons_ratio: 0}\n" +
                column)
               .shared_volume);
    CHECK(c.damping == 0);
    CHECK(!c.rotation);
    CHECK(c.courant == 0.4);
    CHECK(!c.step);
    CHECK(!c.geostatic);
    REQUIRE(c.walls.size() == 4);
    for (mpm::Wall const& wall : c.walls) CHECK(wall.kind == mpm::WallKind::roller);
    CHECK(c.walls[1].place == 0.4);
    auto const solver = mpm::make_solver<2>(c);
    CHECK(solver.state().points.size() == 20 * 16);
    double mass = 0;
    for (auto const& p : solver.state().points) mass += p.mass;
    CHECK(mass == close_to(1900 * 0.1 * 0.08).epsilon(1e-12));
    CHECK(solver.longest_step() == close_to(0.4 * 0.01 / std::sqrt(2.4e6 / 1900)));  // K + 4/3 G = 1.2 E at nu = 1/4
}

TEST_CASE("config: every key")
{
    mpm::Config const c = read(domain + column + R"(
points: 3
basis: gimp
width: stretch
scheme: usl
flip: 0.9
affine: false
shared_volume: false
front_depth: 0.002
threads: 2
damping: 5
courant: 0.2
step: 1e-5
material: {law: mohr_coulomb, density: 1900, youngs_modulus: 2e6, poissons_ratio: 0.25, friction_angle: 30,
           dilation_angle: 10, cohesion: 1000, tension: 100}
walls: {left: fixed, right: open, bottom: {friction: 0.4}, top: roller}
gates: [{at: 0.1, removed_at: 0.5}, {across: y, at: 0.15, removed_at: 0.2, friction: 0.3}]
bodies:
  - {box: {low: [0.2, 0.1], high: [0.3, 0.2]}, velocity: [1, 2]}
  - {ball: {centre: [0.35, 0.05], radius: 0.04}}
geostatic: {surface: 0.08, k0: 0.5}
grains: {friction: 0.3}
)");
    CHECK(*c.grain_friction == 0.3);
    CHECK(c.points == 3);
    CHECK(c.basis == mpm::BasisKind::gimp);
    CHECK(c.width == mpm::Width::stretch);
    CHECK(c.scheme == mpm::Scheme::usl);
    CHECK(c.flip == 0.9);
    CHECK(!c.affine);
    CHECK(!c.shared_volume);
    CHECK(*c.front_depth == 0.002);
    CHECK(c.threads == 2);
    CHECK(c.damping == 5);
    CHECK(c.courant == 0.2);
    CHECK(*c.step == 1e-5);
    CHECK(std::holds_alternative<mpm::MohrCoulomb>(c.law));
    REQUIRE(c.walls.size() == 6);
    CHECK(c.walls[0].kind == mpm::WallKind::fixed);
    CHECK(c.walls[1].kind == mpm::WallKind::open);
    CHECK(c.walls[2].kind == mpm::WallKind::rough);
    CHECK(c.walls[2].friction == 0.4);
    CHECK(c.walls[4].removed_at == 0.5);
    CHECK(c.walls[5].axis == 1);
    CHECK(c.walls[5].kind == mpm::WallKind::rough);
    REQUIRE(c.bodies.size() == 3);
    CHECK(c.bodies[1].velocity[1] == 2);
    CHECK(c.bodies[2].radius == 0.04);
    CHECK(c.geostatic->k0 == 0.5);
}

TEST_CASE("config: laws by name")
{
    auto const with = [](char const* law) {
        return read(domain + column + "material: {law: " + law +
                    ", density: 1, youngs_modulus: 3, poissons_ratio: 0.1}\n");
    };
    CHECK(std::holds_alternative<mpm::LinearElastic>(with("linear_elastic").law));
    CHECK(std::holds_alternative<mpm::NeoHookean>(with("neo_hookean").law));
    CHECK(mpm::elasticity_of(with("neo_hookean").law).youngs_modulus == 3);
}

TEST_CASE("config: in space walls have six names")
{
    mpm::Config const c =
        read("domain: {size: [0.4, 0.1, 0.2]}\ncell: 0.05\nwalls: {front: fixed, back: open, bottom: {friction: 1}}\n" +
                 material + column,
             3);
    REQUIRE(c.walls.size() == 6);
    CHECK(c.walls[2].kind == mpm::WallKind::fixed);
    CHECK(c.walls[2].axis == 1);
    CHECK(c.walls[3].kind == mpm::WallKind::open);
    CHECK(c.walls[4].axis == 2);
    CHECK(c.walls[4].friction == 1);
    CHECK(c.bodies[0].high[1] == 0.1);
    CHECK(c.bodies[0].high[2] == close_to(0.08));
}

TEST_CASE("config: what cannot run is refused, with the key")
{
    CHECK(contains(errors("domain: {size: [0.405, 0.2]}\ncell: 0.01\n" + material + column), "40.5 cells"));
    CHECK(contains(errors("domain: {size: [400, 200]}\ncell: 1e-3\n" + material + column), "at most 1e9"));
    // 31619 cells each way: 31622^2 nodes with one ring around, 31626^2 > 1e9 with the three of corners
    std::string const nearly = "domain: {size: [316.19, 316.19]}\ncell: 0.01\n" + material + column;
    CHECK(errors(nearly).empty());
    CHECK(contains(errors(nearly + "basis: cpdi\n"), "at most 1e9"));
    CHECK(contains(errors(domain + material), "give column, bodies"));
    CHECK(contains(errors(domain + material + column, 2, true), "is missing (a partner sends grains"));
    CHECK(contains(errors(domain + material + column + "grains: {friction: -1}\n"), "grains.friction = -1"));
    CHECK(contains(errors(domain + column), "material"));
    CHECK(contains(errors(domain + material + column + "basis: hat\n"), "basis"));
    CHECK(contains(errors(domain + material + column + "basis: linear\naffine: true\n"), "affine = true beside"));
    CHECK(!read(domain + material + column + "basis: linear\n").affine);
    CHECK(contains(errors(domain + material + column + "flipp: 1\n"), "Did you mean flip"));
    CHECK(contains(errors(domain + material + column + "flip: 1.5\n"), "flip = 1.5"));
    CHECK(contains(errors(domain + material + column + "courant: 2\n"), "courant = 2"));
    CHECK(contains(errors(domain + material + column + "walls: {bottom: slippery}\n"), "walls.bottom"));
    CHECK(contains(errors(domain + material + column + "gates: [{at: 0.1003, removed_at: 1}]\n"), "grid line"));
    CHECK(contains(errors(domain + material + "bodies: [{velocity: [1, 0]}]\n"), "one of box, ball"));
    CHECK(contains(errors(domain + material + "bodies: [{box: {low: [0.2, 0], high: [0.1, 0.1]}}]\n"), "above it"));
    std::string const round = domain + material + column + "walls: {left: periodic, right: periodic}\n";
    CHECK(read(round).walls[1].kind == mpm::WallKind::joined);
    CHECK(contains(errors(domain + material + column + "walls: {left: periodic}\n"), "needs right: periodic"));
    CHECK(contains(errors(round + "plates: [{point: [0, 0], normal: [0, 1]}]\n"), "beside plates"));
    CHECK(contains(errors(round + "gates: [{at: 0.1, removed_at: 1}]\n"), "beside periodic sides across x"));
    CHECK(errors(round + "gates: [{across: y, at: 0.1, removed_at: 1}]\n").empty());
    std::string const rings = domain + material + column + "symmetry: axial\n";
    CHECK(read(rings).symmetry == mpm::Symmetry::axial);
    CHECK(contains(errors(rings + "basis: spline\n"), "symmetry = axial beside basis: linear or spline"));
    CHECK(read(rings + "basis: cpdi\n").basis == mpm::BasisKind::cpdi);
    std::string const corners = domain + material + column + "basis: cpdi\n";
    CHECK(contains(errors(corners + "width: stretch\n"), "width = stretch beside basis = cpdi"));
    for (std::string const basis : {"spline", "linear"})
        CHECK(contains(errors(domain + material + column + "basis: " + basis + "\nwidth: stretch\n"),
                       "width = stretch beside basis = linear or spline"));
    CHECK(read(domain + material + column + "basis: spline\n").basis == mpm::BasisKind::spline);
    CHECK(contains(errors(corners + "grains: {friction: 0.4}\n", 2, true), "basis = cpdi beside a partner's grains"));
    CHECK(contains(errors(corners + "plates: [{point: [0, 0], normal: [0, 1]}]\n"), "basis = cpdi beside plates"));
    std::string const narrow =
        "domain: {size: [0.05, 0.2]}\ncell: 0.01\nwalls: {left: periodic, right: periodic}\n" + material + column;
    CHECK(errors(narrow).empty());
    CHECK(contains(errors(narrow + "basis: cpdi\n"), "fewer than 6 cells"));
    CHECK(contains(
        errors("domain: {origin: [-0.1, 0], size: [0.4, 0.2]}\ncell: 0.01\nsymmetry: axial\n" + material + column),
        "beyond the axis"));
    CHECK(contains(errors(rings + "grains: {friction: 0.4}\n", 2, true), "no rings"));
    for (std::string const left : {"fixed", "open", "{friction: 0.3}"})
        CHECK(contains(errors(rings + "walls: {left: " + left + "}\n"), "on the axis of symmetry: axial"));
    CHECK(errors(rings + "walls: {left: roller, right: fixed}\n").empty());
    CHECK(errors("domain: {origin: [0.1, 0], size: [0.4, 0.2]}\ncell: 0.01\nsymmetry: axial\nwalls: {left: fixed}\n" +
                 material + column)
              .empty());
    auto const ball = [&](std::string const& centre) {
        return errors(rings + "bodies: [{ball: {centre: [" + centre + ", 0.15], radius: 0.04}}]\n");
    };
    CHECK(contains(ball("0"), "over the axis (must be at r >= 0.04 m"));
    CHECK(contains(ball("0.039"), "bodies[0].ball.centre"));
    CHECK(ball("0.04").empty());
    std::string const soil = "material: {law: mohr_coulomb, density: 1, youngs_modulus: 1, poissons_ratio: 0.2, ";
    CHECK(
        contains(errors(domain + column + soil + "friction_angle: 20, dilation_angle: 30}\n"), "dilation_angle = 30"));
    CHECK(contains(errors(domain + column + soil + "friction_angle: 20, tension: 1}\n"), "tip of the cone"));
    CHECK(contains(errors(domain + column + soil + "friction_angle: 0}\n"), "bears no shear"));
    CHECK(contains(errors(domain + column +
                          "geostatic: {}\nmaterial: {law: neo_hookean, density: 1, youngs_modulus: 1, "
                          "poissons_ratio: 0.2}\n"),
                   "neo_hookean"));
}

TEST_CASE("setup: a step above the limit, a body without points and one outside are refused")
{
    auto const refused = [](mpm::Config const& c) {
        try {
            mpm::make_solver<2>(c);
        } catch (sluice::Error const& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    mpm::Config c = read(domain + material + column);
    c.step = 1e-3;
    CHECK(contains(refused(c), "0.6 cells at the speed"));
    c = read(domain + material + column);
    c.bodies[0].high = {0.001, 0.001, 0};
    CHECK(contains(refused(c), "no points"));
    c = read(domain + material + column);
    c.bodies[0].high[0] = 0.5;
    CHECK(contains(refused(c), "behind a wall or gate at 0.4 m"));
    c.walls[1].kind = mpm::WallKind::open;
    CHECK(contains(refused(c), "outside the domain"));
    c = read(domain + material + column + "gates: [{at: 0.05, removed_at: 1}]\n");
    CHECK(contains(refused(c), "behind a wall or gate"));
}

TEST_CASE("config: beside a fluid the matter has its mass less that of what it displaces, geostatic stress too")
{
    std::string const wet = domain + material + column + "geostatic: {}\nfluid: {density: 1000, porosity: 0.4}\n";
    mpm::Config const c = read(wet, 2, false, true);
    REQUIRE(c.fluid);
    CHECK(c.density == close_to(1900 - 600));
    auto const state = mpm::make_state<2>(c);
    CHECK(state.points[0].mass == close_to(1300 * state.points[0].volume));
    double const depth = 0.08 - state.points[0].place[1];
    CHECK(state.points[0].matter.stress(1, 1) == close_to(-1300 * 9.81 * depth));
}

TEST_CASE("config: a fluid without a partner, a partner without a fluid, and matter lighter than what it displaces")
{
    std::string const fluid = "fluid: {density: 1000, porosity: 0.4}\n";
    CHECK(contains(errors(domain + material + column + fluid), "no partner computes one"));
    CHECK(contains(errors(domain + material + column, 2, false, true), "a partner computes the fluid in the pores"));
    CHECK(contains(errors(domain + material + column + "fluid: {density: 4000, porosity: 0.4}\n", 2, false, true),
                   "displaced has 2400 kg/m3"));
    CHECK(contains(errors(domain + material + column + "fluid: {density: 1000, porosity: 1}\n", 2, false, true),
                   "porosity"));
}

TEST_CASE("config: plates, and how they move")
{
    auto const c = read(domain + material + column +
                        "plates:\n"
                        "  - {point: [0.1, 0.2], normal: [0, 2], friction: 0.3, velocity: [0.5, 0], moves_from: 0.1, "
                        "moves_until: 0.3, removed_at: 2}\n"
                        "  - {point: [0, 0], normal: [1, 1], oscillation: {amplitude: [0.001, 0], frequency: 50}}\n"
                        "  - {point: [0, 0], normal: [0, 1], velocities: [{at: 0.1, velocity: [0, 0]}, {at: 0.2, "
                        "velocity: [1, 0]}]}\n");
    REQUIRE(c.plates.size() == 3);
    CHECK(c.plates[0].normal == mpm::Vec3(0, 1, 0));
    CHECK(c.plates[0].friction == 0.3);
    CHECK(c.plates[0].removed_at == 2);
    CHECK(c.plates[0].motion.shift(1.0)[0] == close_to(0.1));
    CHECK(c.plates[1].normal.norm() == close_to(1.0));
    CHECK(c.plates[1].friction == 0);
    CHECK(c.plates[1].motion.shift(0.005)[0] == close_to(0.001));
    CHECK(c.plates[2].motion.shift(0.3)[0] == close_to(0.05));
    CHECK(c.plates[2].motion.speed(0.15)[0] == close_to(0.5));
    auto const setup = mpm::make_setup<2>(c);
    REQUIRE(setup.plates.size() == 3);
    CHECK(setup.plates[2].motion.speed(0.15) == mpm::Vec<2>(c.plates[2].motion.speed(0.15).head<2>()));
    auto const wrong = errors(domain + material + column + "plates: [{point: [0, 0], normal: [0, 0], frction: 1}]\n");
    CHECK(contains(wrong, "plates[0].normal: has no length"));
    CHECK(contains(wrong, "frction"));
}

TEST_CASE("config: Drucker-Prager and mu(I)")
{
    std::string const elastic = "density: 1900, youngs_modulus: 2e6, poissons_ratio: 0.25, ";
    auto const soil = read(domain + column + "material: {law: drucker_prager, " + elastic +
                           "friction_angle: 30, cohesion: 100, cone: compression, tension: 50}\n");
    auto const& cone = std::get<mpm::DruckerPrager>(soil.law).surface;
    CHECK(cone.slope() == close_to(6 * 0.5 / (std::sqrt(3.0) * 2.5)));
    CHECK(cone.tip() == 50);
    CHECK(soil.shared_volume);
    auto const wrong = errors(domain + column + "material: {law: drucker_prager, " + elastic +
                              "friction_angle: 30, dilation_angle: 31, cohesion: 100, tension: 1e6}\n");
    CHECK(contains(wrong, "dilation_angle = 31 degrees (must be at most"));
    CHECK(contains(wrong, "tip of the cone"));
    std::string const rates = "material: {law: mu_of_i, " + elastic +
                              "static_friction: 0.38, inertial_number: 0.28, grain_diameter: 1e-3, "
                              "grain_density: 2600, limit_friction: ";
    auto const grains = read(domain + column + rates + "0.64}\n");
    CHECK(std::get<mpm::MuOfI>(grains.law).limit_friction == 0.64);
    CHECK(grains.shared_volume);
    CHECK(contains(errors(domain + column + rates + "0.3}\n"), "limit_friction = 0.3"));
}
