#include "participants/lbm/config.hpp"

#include <doctest/doctest.h>

#include <string>

#include "coupler/base/error.hpp"
#include "coupler/scene/reader.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

std::string const whole = R"(
domain: {origin: [0, 0.5], size: [0.2, 0.1]}
cell: 1e-3
viscosity: 1e-5
max_velocity: 0.5
)";

lbm::Config read(std::string const& text, std::array<double, 2> gravity = {0, -9.81}, bool phase = false)
{
    sluice::Reader reader = sluice::read_yaml(text, "scene.yaml");
    return lbm::read_config(reader, 2, {gravity[0], gravity[1], 0}, std::nullopt, phase);
}

std::string errors(std::string const& text, bool phase = false)
{
    try {
        read(text, {0, -9.81}, phase);
    } catch (sluice::Error const& e) {
        return e.what();
    }
    return "";
}

bool warns(lbm::Config const& c, char const* key)
{
    for (auto const& issue : lbm::find_issues(c))
        if (!issue.refused && issue.key == key) return true;
    return false;
}

}  // namespace

TEST_CASE("config: interpolated surfaces are refused beside what knows covered cells only")
{
    std::string const phase = whole + "phase: {drag: ergun, diameter: 1e-4, solid_density: 2650}\n";
    CHECK(errors(phase, true).empty());
    CHECK(contains(errors(phase + "grains: interpolated\n", true), "grains"));
    CHECK(contains(errors(whole + "walls: {top: free_slip}\ngrains: interpolated\n"), "a side without friction"));
    sluice::Reader reader = sluice::read_yaml(whole + "grains: interpolated\n", "scene.yaml");
    CHECK_THROWS_WITH_AS(lbm::read_config(reader, 2, {}, sluice::Rotation{}), doctest::Contains("a frame that turns"),
                         sluice::Error);
    // light grains are known for them alone
    CHECK(errors(whole + "grains: interpolated\nlightest_grain: 100\n").empty());
    CHECK(contains(errors(whole + "lightest_grain: 100\n"), "Try grains: interpolated"));
    CHECK(!warns(read(whole + "grains: interpolated\nlightest_grain: 100\n"), "lightest_grain"));
    CHECK(warns(read(whole + "grains: interpolated\nlightest_grain: 99\n"), "lightest_grain"));
    // forced ones know all of the former
    std::string const forced = phase + "walls: {top: free_slip}\ngrains: forced\n";
    CHECK(errors(forced, true).empty());
    sluice::Reader turning = sluice::read_yaml(forced, "scene.yaml");
    lbm::Config const c = lbm::read_config(turning, 2, {}, sluice::Rotation{}, true);
    CHECK(c.surface == lbm::Surface::forced);
    CHECK(contains(lbm::describe(c)[8], "direct forcing"));
}

TEST_CASE("config: defaults, and the step from the lattice velocity")
{
    lbm::Config const c = read(whole);
    CHECK(c.step == close_to(0.05 * 1e-3 / 0.5));
    CHECK(c.relaxation_time() == close_to(0.5 + 3 * 1e-5 * 1e-4 / 1e-6));
    CHECK(c.cells() == std::array<std::ptrdiff_t, 3>{200, 100, 1});
    CHECK(c.origin[1] == 0.5);
    CHECK(c.collision == lbm::Operator::mrt);
    CHECK(c.smagorinsky == 0);
    CHECK(c.hydrodynamic_radius == 0.85);
    CHECK(c.acceleration == std::array<double, 3>{0, 0, 0});
    CHECK(c.precision == lbm::Precision::float64);
    CHECK(c.surface == lbm::Surface::covered);
    CHECK(c.threads >= 1);
    CHECK(lbm::describe(c).size() == 11);
}

TEST_CASE("config: every key")
{
    lbm::Config const c = read(whole + R"(
operator: mrt
rates: {energy: 1.1, square: 1.3, flux: 1.5}
les: 0.1
walls: {left: periodic, right: periodic, top: {velocity: 0.3}}
gravity: true
acceleration: [1, 0]
oscillation: {amplitude: [0.5, 0.25], frequency: 2}
hydrodynamic_radius: 0.7
precision: single
grains: interpolated
lightest_grain: 90
threads: 3
)");
    CHECK(c.energy_rate == 1.1);
    CHECK(c.square_rate == 1.3);
    CHECK(*c.flux_rate == 1.5);
    CHECK(c.smagorinsky == 0.1);
    CHECK(c.periodic(0));
    CHECK(!c.periodic(1));
    CHECK(c.walls[lbm::top<2>].velocity[0] == 0.3);
    CHECK(c.acceleration == std::array<double, 3>{1, -9.81, 0});
    CHECK(c.oscillation->amplitude == std::array<double, 3>{0.5, 0.25, 0});
    CHECK(c.oscillation->frequency == 2);
    CHECK(c.hydrodynamic_radius == 0.7);
    CHECK(c.precision == lbm::Precision::float32);
    CHECK(c.surface == lbm::Surface::interpolated);
    CHECK(c.lightest_grain == 90);
    CHECK(c.threads == 3);
}

TEST_CASE("config: sides that are open or without friction")
{
    lbm::Config const c = read(whole + R"(
walls: {left: {inflow: 0.2, profile: parabola, ramp: 0.5}, right: {pressure: 12}, top: free_slip, bottom: {inflow: [0.1, 0.2]}}
)");
    CHECK(c.walls[lbm::left].kind == lbm::Border::inflow);
    CHECK(c.walls[lbm::left].velocity == std::array<double, 3>{0.2, 0, 0});
    CHECK(c.walls[lbm::left].parabola);
    CHECK(c.walls[lbm::left].ramp == 0.5);
    CHECK(c.walls[lbm::right].kind == lbm::Border::pressure);
    CHECK(c.walls[lbm::right].pressure == 12);
    CHECK(c.walls[lbm::top<2>].kind == lbm::Border::slip);
    CHECK(c.walls[lbm::bottom<2>].velocity == std::array<double, 3>{0.1, 0.2, 0});
    CHECK(read(whole + "walls: {right: {inflow: 0.2}, left: {pressure: 0}}\n").walls[lbm::right].velocity[0] == -0.2);

    CHECK(contains(errors(whole + "walls: {left: {inflow: 0.2}}\n"), "nowhere to go"));
    CHECK(contains(errors(whole + "walls: {left: {inflow: 0.2, profile: round}, right: {pressure: 0}}\n"), "profile"));
    CHECK(contains(errors(whole + "walls: {left: {pressure: 0, ramp: 1}}\n"), "ramp"));
    CHECK(contains(errors(whole + "walls: {left: {inflow: 90}, right: {pressure: 0}}\n"), "Mach number"));
}

TEST_CASE("config: solids at rest")
{
    lbm::Config const c = read(whole + R"(
solids: [{name: pile, disc: {centre: [0.05, 0.52], radius: 0.01}}, {box: {low: [0, 0.5], high: [0.02, 0.5625]}}]
)");
    REQUIRE(c.solids.size() == 2);
    CHECK(c.solids[0].name == "pile");
    CHECK(c.solids[0].radius == 0.01);
    CHECK(c.solids[1].name == "solid_1");
    CHECK(c.solids[1].centre == std::array<double, 3>{0.01, 0.53125, 0});
    CHECK(c.solids[1].size == std::array<double, 3>{0.02, 0.0625, 0});

    CHECK(contains(errors(whole + "solids: [{box: {low: [0.1, 0], high: [0, 0.1]}}]\n"),
                   "is 0 m along x, not above low, 0.1 m."));
    for (char const* const where : {"[9, 0.01]", "[0.05, -9]"})
        CHECK(contains(errors(whole + "solids: [{name: far, disc: {centre: " + where + ", radius: 0.01}}]\n"),
                       "far lies outside the domain, which goes from"));
    CHECK(contains(errors(whole + "solids: [{disc: {centre: [0, 0]}}]\n"), "radius"));
    CHECK(contains(
        errors(
            whole +
            "solids: [{name: a, disc: {centre: [0, 0], radius: 1}}, {name: a, disc: {centre: [0, 0], radius: 1}}]\n"),
        "there twice"));
}

TEST_CASE("config: what cannot run is refused, with the key")
{
    CHECK(contains(errors(whole + "step: 1e-3\n"), "Mach number"));
    CHECK(contains(errors("domain: {size: [0.2005, 0.1]}\ncell: 1e-3\nmax_velocity: 0.5\n"), "whole number"));
    CHECK(contains(errors(whole + "walls: {left: periodic}\n"), "left and right differ"));
    CHECK(contains(errors(whole + "threads: many\n"), "must be auto"));
    CHECK(contains(errors(whole + "walls: {top: slip}\n"), "walls.top"));
    CHECK(contains(errors(whole + "operater: bgk\n"), "operator"));
    CHECK(contains(errors(whole + "operator: bgk\nrates: {flux: 1}\n"), "rates"));
    CHECK(contains(errors("cell: 1e-3\n"), "domain"));
}

TEST_CASE("config: near its limits it warns")
{
    lbm::Config c = read(whole);
    c.viscosity = 2e-5;
    CHECK(lbm::find_issues(c).size() == 1);  // grid Reynolds number 25
    CHECK(warns(c, "cell"));
    c.viscosity = 1e-6;
    CHECK(warns(c, "viscosity"));
    c.smagorinsky = 0.1;
    CHECK(lbm::find_issues(c).empty());
    c.step *= 2.5;
    CHECK(warns(c, "step"));
    c.viscosity = -1;
    CHECK(lbm::find_issues(c).front().refused);
}

TEST_CASE("config: solids finer than a cell need a law of drag, and somebody who sends them")
{
    std::string const fine = "phase: {drag: di_felice, diameter: 5e-4, solid_density: 2650, spread: 2}\n";
    lbm::Config const c = read(whole + fine, {0, -9.81}, true);
    REQUIRE(c.phase);
    CHECK(c.phase->law == lbm::Drag::di_felice);
    CHECK(c.phase->diameter == 5e-4);
    CHECK(c.phase->solid_density == 2650);
    CHECK(c.phase->spread == 2);
    CHECK(contains(lbm::describe(c).back(), "bulk modulus"));
    CHECK(contains(errors(whole + fine), "nobody sends one"));
    CHECK(contains(errors(whole, true), "a partner sends solids finer than a cell"));
    CHECK(
        contains(errors(whole + "phase: {drag: ergun, diameter: 5e-4, solid_density: 900}\n", true), "solid_density"));
    CHECK(contains(errors(whole + "phase: {drag: darcy, diameter: 5e-4, solid_density: 2650}\n", true), "drag"));
}

TEST_CASE("config: grains wider than a cell are warned of where they are not resolved")
{
    std::string const coarse = "phase: {drag: ergun, diameter: 2e-3, solid_density: 2650}\n";
    CHECK(warns(read(whole + coarse, {0, -9.81}, true), "phase.diameter"));
}

TEST_CASE("config: what a run leaves behind")
{
    auto const c = read(whole + R"(
fields: [pressure, q_criterion]
energy: true
probes: [{name: base, at: [0.1, 0.51]}, {at: [0, 0.5]}]
lines: [{name: floor, from: [0, 0.51], to: [0.2, 0.55], points: 5}]
)");
    CHECK(c.output.fields ==
          lbm::FieldChoice{.velocity = false, .vorticity = false, .solid_fraction = false, .q_criterion = true});
    CHECK(c.output.energy);
    REQUIRE(c.output.probes.size() == 2);
    CHECK(c.output.probes[1].name == "probe_1");
    REQUIRE(c.output.lines.size() == 1);
    CHECK(c.output.lines[0].place(4)[1] == close_to(0.55));
    CHECK(c.output.lines[0].place(1)[0] == close_to(0.05));
    CHECK(read(whole).output.fields == lbm::FieldChoice{});
    CHECK(contains(errors(whole + "fields: [speed]\n"), "speed is none (known: velocity"));
    CHECK(contains(errors(whole + "probes: [{at: [0.1, 0.4]}]\n"), "has y = 0.4 m, outside the domain"));
    CHECK(contains(errors(whole + "probes: [{name: a, at: [0.1, 0.5]}, {name: a, at: [0.1, 0.5]}]\n"), "there twice"));
    CHECK(contains(errors(whole + "lines: [{from: [0, 0.5], to: [0.1, 0.5], points: 1}]\n"), "points"));
}
