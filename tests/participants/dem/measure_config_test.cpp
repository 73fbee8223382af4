#include "participants/dem/measure_config.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/dem/gauges.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

constexpr char const* quarter =
    "density: 2650\n"
    "diameter: {min: 8.0e-3, max: 8.0e-3}\n"
    "contact: {normal_stiffness: 1e5, damping_ratio: 0.2, friction: 0.3}\n"
    "walls:\n"
    "  - {name: floor, point: [0, 0, 0], normal: [0, 0, 1]}\n"
    "  - {name: x, point: [0, 0, 0], normal: [1, 0, 0]}\n"
    "  - {name: y, point: [0, 0, 0], normal: [0, 1, 0]}\n"
    "column: {container: quarter, count: 261, aspect_ratio: 0.926}\n";

dem::Config read(std::string const& more, int dimension = 2)
{
    auto const text = (dimension == 2 ? scene : quarter) + more;
    dem::Vec3 const gravity = dimension == 2 ? dem::Vec3{0, -9.81, 0} : dem::Vec3{0, 0, -9.81};
    return dem::read_config(sluice::read_yaml(text, "grains.yaml"), dimension, gravity);
}

std::string refusal(std::string const& more, int dimension = 2)
{
    try {
        read(more, dimension);
    } catch (sluice::Error const& error) {
        return error.what();
    }
    return "";
}

template <int D>
std::vector<std::string> columns(dem::MeasuresConfig const& measures)
{
    std::vector<std::string> all;
    dem::Config config;
    config.measures = measures;
    for (auto const& gauge : dem::gauges_of<D>(config, 1e-3))
        for (auto const& column : gauge.columns) all.push_back(column);
    return all;
}

}  // namespace

TEST_CASE("measures key: without it the series has the columns that it always had")
{
    std::vector<std::string> const plane{"run_out [m]",
                                         "foremost [m]",
                                         "height [m]",
                                         "kinetic [J/m]",
                                         "rotational [J/m]",
                                         "potential [J/m]",
                                         "elastic [J/m]",
                                         "dissipated_normal [J/m]",
                                         "dissipated_tangential [J/m]",
                                         "dissipated_sliding [J/m]",
                                         "dissipated_rolling [J/m]",
                                         "vanished [J/m]",
                                         "fluid_work [J/m]",
                                         "wall_work [J/m]",
                                         "balance [J/m]",
                                         "coordination",
                                         "contacts",
                                         "largest_overlap",
                                         "centre_x [m]",
                                         "centre_y [m]",
                                         "window_impulse_x [N s/m]",
                                         "window_impulse_y [N s/m]"};
    auto const none = read("").measures, all = read("measures: [standard]\n").measures;
    CHECK(columns<2>(none) == plane);
    CHECK(columns<2>(all) == plane);
    CHECK_FALSE(none.stated);
    CHECK(all.stated);
    CHECK(columns<3>(read("", 3).measures).size() == plane.size() + 2);
}

TEST_CASE("measures key: what is not named is not measured, and only the energies need the ledger")
{
    auto const front = read("measures: [front, coordination]\n", 3).measures;
    CHECK(columns<3>(front).front() == "front [m]");
    CHECK(columns<3>(front).size() == 1 + 3 + 13);
    CHECK_FALSE(front.need_ledger(0.001));
    CHECK(front.sectors.angle == close_to(0.5 * std::numbers::pi));
    CHECK(front.radial);
    CHECK(read("measures: [drift]\n").measures.need_ledger(0.001));
    CHECK_FALSE(read("").measures.need_ledger(0.0));
    CHECK(read("").measures.need_ledger(0.001));
    CHECK(read("measures: {energies: {interval: 0.1}}\n").measures.need_ledger(0.0));
}

TEST_CASE("measures key: options, intervals and the word standard in a mapping")
{
    auto const m = read(
                       "measures:\n"
                       "  standard: {}\n"
                       "  energies: {interval: 0.5}\n"
                       "  front: {sectors: 50, percentile: 95, over: circle}\n"
                       "  coordination: {most: 3, walls: false}\n"
                       "  voronoi: {interval: 0.01, slice: 0.02, along: x}\n"
                       "  force_chains: {interval: 0.1}\n",
                       3)
                       .measures;
    using dem::Measure;
    CHECK(m[Measure::run_out].wanted);
    CHECK(m[Measure::energies].interval == 0.5);
    CHECK(m.sectors.count == 50);
    CHECK(m.sectors.percentile == 95.0);
    CHECK(m.sectors.angle == close_to(2.0 * std::numbers::pi));
    CHECK(m.most_contacts == 3);
    CHECK_FALSE(m.wall_contacts);
    CHECK(m[Measure::voronoi].interval == 0.01);
    CHECK(m.slice == 0.02);
    CHECK_FALSE(m.radial);
    CHECK(m[Measure::force_chains].interval == 0.1);
    CHECK_FALSE(m[Measure::drift].wanted);
    dem::Config config;
    config.measures = m;
    auto const gauges = dem::gauges_of<3>(config, 8e-3);
    CHECK(std::ranges::none_of(gauges, [](auto const& gauge) { return gauge.name == "force_chains"; }));
    CHECK(gauges[1].name == "energies");
    CHECK(gauges[1].interval == 0.5);
}

TEST_CASE("measures key: mistakes are said with what would do")
{
    auto const holds = [](std::string const& text, char const* part) {
        CHECK_MESSAGE(text.find(part) != std::string::npos, text);
        CHECK_MESSAGE(text.find("grains.yaml:") != std::string::npos, text);
    };
    holds(refusal("measures: [energys]\n"), "Did you mean energies?");
    holds(refusal("measures: [energies, energies]\n"), "stands here twice");
    holds(refusal("measures: []\n"), "at least 1 measure");
    holds(refusal("measures: 3\n"), "measures");
    holds(refusal("measures: [front]\n"), "run_out has the front");
    holds(refusal("measures: {front: {sector: 3}}\n", 3), "Did you mean sectors?");
    holds(refusal("measures: {front: {sectors: 0}}\n", 3), "must be >= 1");
    holds(refusal("measures: {voronoi: {along: radius}}\n"), "along is not a key");
    holds(refusal("measures: {energies: {interval: -1}}\n"), "interval");
    dem::Config listed;
    std::string const one =
        "density: 2650\ncontact: {normal_stiffness: 1e5, damping_ratio: 0.2, friction: 0.3}\n"
        "grains: [{position: [0, 0, 1], radius: 0.004}]\nmeasures: [front]\n";
    CHECK_THROWS_WITH_AS(dem::read_config(sluice::read_yaml(one, "grains.yaml"), 3, {0, 0, -9.81}),
                         doctest::Contains("{over: quarter}"), sluice::Error);
}
