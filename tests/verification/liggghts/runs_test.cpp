#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/verification.hpp"

//! Same physics, two codes, coupled: scenes of configs/ with our DEM and with LIGGGHTS in our fluid.
namespace {

using Table = std::map<std::string, std::vector<double>>;

Table read_table(std::filesystem::path const& file)
{
    std::istringstream lines(shell::slurp(file));
    std::string line, cell;
    std::getline(lines, line);
    std::vector<std::string> names;
    std::istringstream header(line);
    while (std::getline(header, cell, ',')) names.push_back(cell);
    Table table;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        for (auto const& name : names) {
            std::getline(cells, cell, ',');
            table[name].push_back(std::stod(cell));
        }
    }
    return table;
}

//! The table of the grains of a scene, moved by `solver`.
Table run(std::string const& scene, std::string const& grains, std::string const& solver,
          std::vector<std::string> const& settings)
{
    ::setenv("SLUICE_CACHE", PACKING_CACHE, 1);
    in_threads::Scratch scratch;
    auto const out = scratch.path() / "run";
    std::vector<std::string> words{SLUICE_COMMAND, "run",   std::string(CONFIGS) + "/" + scene,
                                   "--out",        out,     "--no-report",
                                   "--quiet",      "--set", "participants." + grains + ".solver=" + solver};
    for (auto const& setting : settings) words.insert(words.end(), {"--set", setting});
    auto const result = shell::run(words, scratch.path() / "output", 550);
    if (result.exit != 0) MESSAGE(result.output);
    REQUIRE(result.exit == 0);
    return read_table(out / (grains + ".csv"));
}

double largest(std::vector<double> const& values)
{
    return *std::max_element(values.begin(), values.end());
}

}  // namespace

//! Ten Cate et al. (2002), E4: fastest 0.1222 m/s in the experiment. Six cells a diameter, for which the benchmark's
//! mark of 5 % is meant; what counts here is that both codes go the same way.
TEST_CASE("C02: a sphere that settles in our fluid, by LIGGGHTS and by our DEM")
{
    verification::Stopwatch watch;
    auto const ours = run("settling_sphere.yaml", "sphere", "dem", {});
    auto const theirs = run("settling_sphere.yaml", "sphere", "liggghts", {});
    double const radius = 0.0075, mass = 1120.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
    auto const peak = [&](Table const& t) { return std::sqrt(2.0 * largest(t.at("kinetic [J]")) / mass); };
    CHECK(verification::report({"C02", "fastest, ours, against experiment [m/s]", peak(ours), 0.1222,
                                std::abs(peak(ours) / 0.1222 - 1.0), 0.05, watch.seconds()}));
    CHECK(verification::report({"C02", "fastest, LIGGGHTS, against experiment [m/s]", peak(theirs), 0.1222,
                                std::abs(peak(theirs) / 0.1222 - 1.0), 0.05, watch.seconds()}));
    double falling = 0.0, later = 0.0;
    auto const &a = ours.at("centre_z [m]"), &b = theirs.at("centre_z [m]");
    REQUIRE(a.size() == b.size());
    auto const last = std::ranges::adjacent_find(a, std::less{}) - a.begin();  // before it rises
    REQUIRE(last + 1 < std::ssize(a));                                         // it has rebounded
    for (std::ptrdiff_t k = 0; k < std::ssize(a); ++k) {
        auto const at = static_cast<std::size_t>(k);
        double& worst = k <= last ? falling : later;
        worst = std::max(worst, std::abs(a[at] - b[at]) / (2.0 * radius));
    }
    // free of contacts both take the same steps under the same loads: rounding
    CHECK(verification::report(
        {"C02", "largest difference of places / d, falling", falling, 0.0, falling, 1e-12, watch.seconds()}));
    // in the rebound LIGGGHTS is of first order in the dashpot (D01): part of a rebound of 1e-2 d
    CHECK(verification::report(
        {"C02", "largest difference of places / d, after the rebound", later, 0.0, later, 1e-3, watch.seconds()}));
}

//! 300 discs of immersed_column.yaml in a coarser lattice, for 5.4 sqrt(H0/g). Where grains go late in a collapse hangs
//! on rounding, so that means are compared, of runs with six steps. Marks: three times the standard error of the
//! difference of two such means, by the scatter of single runs (steps of t_c/40 to t_c/70; 7 of ours, 12 of LIGGGHTS):
//! of the run-out, which jumps where the front comes loose, 0.08 and 0.11 L0, of the way of the centre 0.0038 and
//! 0.0062 L0; (5 and 5) of the largest kinetic energy 0.002 and 0.005, of the potential one at the end 0.005 and 0.007,
//! of what contacts took as that.
TEST_CASE("LG2: an immersed collapse, by LIGGGHTS and by our DEM" * doctest::skip())
{
    verification::Stopwatch watch;
    double const contact_time = 1.01345e-4;  // s
    struct Means
    {
        double run_out = 0.0, centre = 0.0, kinetic = 0.0, potential = 0.0, taken = 0.0;
    };
    auto const means = [&](std::string const& solver) {
        Means m;
        for (double const share : {40.0, 45.0, 50.0, 55.0, 60.0, 70.0}) {
            auto const t =
                run("immersed_column.yaml", "grains", solver,
                    {"participants.grains.config.column.count=300", "participants.water.config.cell=2.0e-4",
                     "participants.water.config.domain.size=[0.1, 0.03]", "time.end=0.2", "output.series=0.002",
                     "output.interval=0.1",
                     "participants.grains.config.step=" + std::to_string(1e6 * contact_time / share) + "e-6"});
            auto const& front = t.at("run_out [m]");
            auto const& potential = t.at("potential [J/m]");
            // LIGGGHTS does not say what contacts took: what is missing of all that it holds
            auto const held = [&](std::size_t k) {
                return t.at("kinetic [J/m]")[k] + t.at("rotational [J/m]")[k] + potential[k] + t.at("elastic [J/m]")[k];
            };
            auto const& centre = t.at("centre_x [m]");
            m.run_out += (front.back() - front.front()) / front.front() / 6.0;
            m.centre += (centre.back() - centre.front()) / front.front() / 6.0;
            m.kinetic += largest(t.at("kinetic [J/m]")) / potential.front() / 6.0;
            m.potential += potential.back() / potential.front() / 6.0;
            m.taken += (held(0) + t.at("fluid_work [J/m]").back() - held(front.size() - 1)) / potential.front() / 6.0;
        }
        return m;
    };
    Means const ours = means("dem"), theirs = means("liggghts");
    auto const compare = [&](char const* what, double value, double reference, double most) {
        CHECK(
            verification::report({"LG2", what, value, reference, std::abs(value - reference), most, watch.seconds()}));
    };
    auto const mark = [](double a, double b) { return 3.0 * std::sqrt((a * a + b * b) / 6.0); };
    compare("(L - L0)/L0", theirs.run_out, ours.run_out, mark(0.08, 0.11));
    compare("way of the centre / L0", theirs.centre, ours.centre, mark(0.0038, 0.0062));
    compare("largest kinetic energy / first potential", theirs.kinetic, ours.kinetic, mark(0.002, 0.005));
    compare("potential energy at the end / first", theirs.potential, ours.potential, mark(0.005, 0.007));
    compare("taken by contacts / first potential", theirs.taken, ours.taken, mark(0.005, 0.007));
}
