#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "participants/dem/setup.hpp"
#include "participants/dem/steady_shear.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/run_out.hpp"

//! D07 (e): the discs of the column studies sheared to the critical state, as configs/critical_state.yaml but fewer.
//! Marks: the pressure is the one asked for (the servo has no offset); the friction of discs with a contact friction of
//! 0.5 and no resistance to rolling, sheared slowly, in the literature: shear over normal stress 0.25 to 0.30 (da Cruz
//! et al., Phys. Rev. E 72 (2005) 021309, for 0.4; contact dynamics of the CEGEO group, EPL 98 (2012) 44008, for 0.5);
//! 1000 grains and more there, 300 here: 0.03 more on either side.
namespace {

dem::Config cell()
{
    std::string const text =
        "density: 2650\ndiameter: {min: 1.0e-3, max: 1.8e-3}\n"
        "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction_angle: 26}\n"
        "periodic: {x: [0, 0.0273], y: [0, 0.0364]}\nfill: {count: 300, seed: 2}\n"
        "shear: {along: x, across: y, rate: 0.62, pressure: 2000, steady_from: 1.0}\n";
    return dem::read_config(sluice::read_yaml(text, "cell.yaml"), 2, {});
}

//! The facts of a shear up to a strain.
std::map<std::string, double> sheared(dem::Config const& config, double step, double strain)
{
    dem::Solver<2> solver = dem::make_solver<2>(config);
    dem::SteadyShear steady;
    while (solver.state().cell.strain < strain) {
        for (int n = 0; n < 100; ++n) solver.step(step);
        steady.sample(solver);
    }
    std::map<std::string, double> facts;
    for (auto const& [name, value] : steady.facts()) {
        std::printf("D07   %s: %.5g\n", name.c_str(), value);
        facts[name] = value;
    }
    return facts;
}

}  // namespace

TEST_CASE("D07: discs sheared at constant pressure reach the critical state")
{
    verification::Stopwatch watch;
    dem::Config const config = cell();
    auto const facts = sheared(config, config.contact_time / 30.0, 2.5);
    double const pressure = facts.at("normal stress [Pa]"), friction = facts.at("shear / normal stress");
    CHECK(facts.at("inertial number") == close_to(1e-3).epsilon(0.05));
    CHECK(verification::report({"D07", "critical state: normal stress [Pa]", pressure, 2000.0,
                                std::abs(pressure / 2000.0 - 1.0), 0.01, watch.seconds()}));
    CHECK(verification::report({"D07", "critical state: shear / normal stress (0.25 to 0.30)", friction, 0.275,
                                std::abs(friction - 0.275), 0.055, watch.seconds()}));
}

//! Minutes: only `./dev verify` runs it. With the resistance to rolling of the run-outs (configs/run_out.yaml).
TEST_CASE("D07: the discs of critical_state.yaml have the friction angle of the studies" * doctest::skip())
{
    verification::Stopwatch watch;
    auto const config = verification::config_of("critical_state.yaml", {});
    double const angle = sheared(config, config.step, 4.0).at("friction angle [deg]");
    CHECK(verification::report(
        {"D07", "critical state: friction angle [deg]", angle, 23.0, std::abs(angle - 23.0), 2.0, watch.seconds()}));
}
