// DEM and LBM as two executables: every scene of configs/, the same bits over every transport, the third law.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tests/integration/solver_runs.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/verification.hpp"

using namespace solver_runs;

TEST_CASE("configs: every scene passes the check and runs shortened with ParaView files and archive that agree")
{
    // dry_column, buoyant_column, immersed_column and whatever else lies there
    int scenes = 0;
    for (auto const& entry : std::filesystem::directory_iterator(configs)) {
        if (entry.path().extension() != ".yaml") continue;
        ++scenes;
        CAPTURE(entry.path().string());
        in_threads::Scratch scratch;
        auto const log = scratch.path() / "log";
        CHECK(shell::run({sluice_command, "check", entry.path()}, log).exit == 0);
        auto const out = scratch.path() / "run";
        auto const text = shell::slurp(entry.path());
        std::vector<std::string> settings{"time.end=0.0006", "output.interval=0.0002"};
        if (text.find("window: 0.") != std::string::npos) settings.push_back("time.window=0.0002");
        for (std::string const many : {"fill", "column"})
            if (text.find("  grains:\n    solver: dem") != std::string::npos &&
                text.find(many + ": {") != std::string::npos)
                settings.push_back("participants.grains.config." + many + ".count=150");
        REQUIRE(run(entry.path(), out, settings).exit == 0);
        CHECK(std::filesystem::exists(out / "summary.json"));
        CHECK(std::filesystem::exists(out / (entry.path().stem().string() + ".pvd")));
        CHECK(read_table(out / "series.csv").at("time [s]").size() >= 2);
        auto const check = shell::run({"/usr/bin/python3", readback, out}, log);
        if (check.exit != 0) MESSAGE(check.output);
        CHECK((check.exit == 0 || check.exit == 77));  // 77: no VTK here; the independent reader has passed
    }
    CHECK(scenes >= 3);
}

TEST_CASE("immersed column: zmq, mpi and one or two threads give the same bits")
{
    in_threads::Scratch scratch;
    auto const scene = configs / "immersed_column.yaml";
    auto const reference = scratch.path() / "zmq";
    REQUIRE(run(scene, reference, small({"transport=zmq"})).exit == 0);
    for (std::string const setting :
         {"transport=mpi", "participants.water.config.threads=1", "participants.water.config.threads=3"}) {
        CAPTURE(setting);
        auto const out = scratch.path() / "other";
        std::filesystem::remove_all(out);
        REQUIRE(run(scene, out, small({setting})).exit == 0);
        CHECK(same_bytes(out / "series.csv", reference / "series.csv"));
        for (auto const name : {"grains.csv", "water.csv"}) CHECK(same_bytes(out / name, reference / name));
        for (auto const& entry : std::filesystem::recursive_directory_iterator(reference / "grains"))
            CHECK(same_bytes(entry.path(), out / "grains" / entry.path().filename()));
        for (auto const& entry : std::filesystem::recursive_directory_iterator(reference / "water"))
            CHECK(same_bytes(entry.path(), out / "water" / entry.path().filename()));
    }
}

TEST_CASE("dry and buoyant columns start no LBM process and share the immersed column's packing")
{
    in_threads::Scratch scratch;
    std::vector<double> heights;
    for (auto const name : {"dry_column", "buoyant_column", "immersed_column"}) {
        auto const out = scratch.path() / name;
        bool const immersed = std::string(name) == "immersed_column";
        REQUIRE(run(configs / (std::string(name) + ".yaml"), out,
                    immersed ? small()
                             : std::vector<std::string>{"time.end=0.004", "participants.grains.config.column.count=60"})
                    .exit == 0);
        CHECK(std::filesystem::exists(out / "water.csv") == immersed);
        heights.push_back(read_table(out / "grains.csv").at("height [m]").at(0));
    }
    CHECK(heights[0] == heights[1]);
    CHECK(heights[0] == heights[2]);
}

TEST_CASE("a fluid that does not resolve: scenes without one of the two edges, or one of their blocks, are refused")
{
    in_threads::Scratch scratch;
    auto const whole = shell::slurp(configs / "consolidation.yaml");
    auto const refused = [&](std::vector<std::string> const& without, std::string const& reason) {
        std::stringstream lines(whole);
        std::ofstream scene(scratch.path() / "scene.yaml");
        for (std::string line; std::getline(lines, line);)
            if (std::ranges::none_of(without, [&](auto const& w) { return line.find(w) != std::string::npos; }))
                scene << line << '\n';
        scene.close();
        auto const result =
            shell::run({sluice_command, "check", scratch.path() / "scene.yaml"}, scratch.path() / "output", 60);
        CHECK(result.exit == 2);
        CHECK_MESSAGE(result.output.find(reason) != std::string::npos, result.output);
    };
    refused({"data: phase", "phase: {"}, "body_force to soil, but nobody sends a phase");
    refused({"data: phase", "data: body_force", "fluid: {"}, "nobody sends one");
    refused({"phase: {"}, "a partner sends solids finer than a cell");
    refused({"fluid: {"}, "a partner computes the fluid in the pores");
    refused({"data: phase", "data: body_force", "phase: {"}, "no partner computes one");
    auto const late = shell::run({sluice_command, "check", configs / "consolidation.yaml", "--set",
                                  "couplings=[{from: soil, to: water, data: phase}, {from: water, to: soil, data: "
                                  "body_force, lag: 1}]"},
                                 scratch.path() / "output", 60);
    CHECK(late.exit == 2);
    CHECK_MESSAGE(late.output.find("couplings[1].data = body_force with lag: 1") != std::string::npos, late.output);
}

TEST_CASE("C08: third law across executables: in every window the grains take the impulse that the fluid gave")
{
    // C08_conservation.csv (6): the impulse logged by the DEM equals that logged by the LBM, <= 1e-14, every window.
    verification::Stopwatch watch;
    in_threads::Scratch scratch;
    auto const out = scratch.path() / "run";
    REQUIRE(run(configs / "immersed_column.yaml", out, small({"output.series=1e-9"})).exit == 0);
    auto const taken = read_table(out / "grains.csv"), given = read_table(out / "water.csv");
    for (std::string const axis : {"x", "y"}) {
        auto const& t = taken.at("window_impulse_" + axis + " [N s/m]");
        auto const& g = given.at("window_impulse_" + axis + " [N s/m]");
        REQUIRE(t.size() == g.size());
        REQUIRE(t.size() > 50);
        double worst = 0, largest = 0;
        for (std::size_t n = 0; n + 1 < t.size(); ++n) {  // lag 1: what was given in window n is taken in n + 1
            worst = std::max(worst, std::abs(t[n + 1] - g[n]));
            largest = std::max(largest, std::abs(g[n]));
        }
        CHECK(largest > 1e-9);
        CHECK(verification::report({"C08", fmt::format("third law, {}: largest defect / impulse", axis), worst, 0.0,
                                    worst / largest, 1e-14, watch.seconds()}));
    }
}

TEST_CASE(
    "configs: spheres in LIGGGHTS' order run with a time series, without the ledger that this order does not keep")
{
    in_threads::Scratch scratch;
    auto const scene = configs / "quarter_column.yaml";
    std::vector<std::string> const settings{"participants.grains.config.scheme=liggghts", "time.end=0.01",
                                            "participants.grains.config.column.count=60", "output.series=0.005",
                                            "participants.grains.config.contact.rolling=constant"};
    REQUIRE(run(scene, scratch.path() / "run", settings).exit == 0);
    auto const table = read_table(scratch.path() / "run" / "grains.csv");
    REQUIRE(table.at("time [s]").size() == 3);
    CHECK(table.at("kinetic [J]").back() > 0.0);
    CHECK(table.at("dissipated_sliding [J]").back() == 0.0);
    CHECK(shell::slurp(scratch.path() / "run" / "summary.json").find("scheme: liggghts keeps none") !=
          std::string::npos);
}

TEST_CASE("a centrifuge: a dropped disc lags, its work is booked, and so is that on a continuum while it spins up")
{
    in_threads::Scratch scratch;
    auto const scene = scratch.path() / "drop.yaml";
    std::ofstream(scene) << R"(sluice: 1
time: {end: 0.05}
output: {interval: 0.05, series: 0.01}
frame: {rotating: {axis: [0, 2.022365218], rate: 4.924812633}}
participants:
  grains:
    solver: dem
    config:
      density: 2650
      contact: {normal_stiffness: 1.0e6, damping_ratio: 0.2, friction: 0}
      walls: [{name: floor, point: [0, 0], normal: [0, 1]}]
      grains: [{position: [0, 0.06], radius: 0.01}]
)";
    REQUIRE(run(scene, scratch.path() / "run", {}).exit == 0);
    auto const table = read_table(scratch.path() / "run" / "grains.csv");
    // R02's closed form before it lands at w t = 0.2266: counter-clockwise the floor moves to +x, and what falls lags
    double const time = table.at("time [s]").at(4), a = 4.924812633 * time, r0 = 2.022365218 - 0.06;
    REQUIRE(time == close_to(0.04).epsilon(0.05));
    CHECK(table.at("centre_x [m]").at(4) == close_to(-r0 * (std::sin(a) - a * std::cos(a))).epsilon(1e-4));
    CHECK_FALSE(table.contains("field_work [J/m]"));  // the rate is steady: all is in the potential
    auto const& balance = table.at("balance [J/m]");
    CHECK(std::abs(balance.back() - balance.front()) < 1e-6 * std::abs(balance.front()));
    REQUIRE(run(configs / "mpm_column.yaml", scratch.path() / "soil",
                {"frame={rotating: {axis: [0, 2], rate: 5, ramp: 0.02, euler: false}}",
                 "participants.soil.config.cell=0.01", "time.end=0.04", "output.interval=0.04", "output.series=0.01"})
                .exit == 0);
    auto const soil = read_table(scratch.path() / "soil" / "soil.csv");
    auto const work = soil.at("field_work [J/m]"), soil_balance = soil.at("balance [J/m]");
    CHECK(work.front() == 0);
    CHECK(work.back() == work.at(3));  // the rate is steady since 0.02 s
    CHECK(std::abs(work.back()) > 1);
    CHECK(std::abs(soil_balance.back() - soil_balance.front()) < 1e-3 * std::abs(work.back()));
}

TEST_CASE("a continuum's steps follow a grain that grows faster within a window, at the largest Courant number")
{
    in_threads::Scratch scratch;
    auto const scene = scratch.path() / "falling.yaml";
    std::ofstream(scene) << R"(sluice: 1
dimension: 2
gravity: [0, -9.81]
time: {end: 0.05, window: 0.01}
participants:
  boulder:
    solver: dem
    config:
      density: 2650
      contact: {normal_stiffness: 1.0e+6, damping_ratio: 0.2, friction: 0}
      grains: [{radius: 0.05, position: [0.5, 0.9], velocity: [0, -5]}]
  bed:
    solver: mpm
    config:
      domain: {size: [1, 1]}
      cell: 0.0125
      courant: 0.6
      material: {law: linear_elastic, density: 1000, youngs_modulus: 4.0e+3, poissons_ratio: 0.25}
      bodies: [{box: {low: [0, 0], high: [1, 0.2]}}]
      grains: {friction: 0.4}
couplings:
  - {from: boulder, to: bed, data: kinematics}
  - {from: bed, to: boulder, data: load, lag: 1, sample: hold}
output: {interval: 0.05}
)";
    CHECK(run(scene, scratch.path() / "run", {}).exit == 0);  // waves go at 2.2 m/s: the grain sets the step
}

TEST_CASE("measures: of a settled column the files agree, and the contacts carry the weights")
{
    in_threads::Scratch scratch;
    auto const out = scratch.path() / "run";
    std::vector<std::string> const settings{
        "time.end=0.06",
        "output.interval=0.02",
        "output.series=0.01",
        "participants.grains.config.column.count=60",
        "participants.grains.config.column.gate_removed_at=10",
        "participants.grains.config.measures={standard: {}, drift: {}, coordination: {most: 8}, profile: {}, "
        "voronoi: {interval: 0.02}, force_chains: {}}"};
    REQUIRE(run(configs / "dry_column.yaml", out, settings).exit == 0);
    auto const check =
        shell::run({"/usr/bin/python3", readback, out, "--settled", "2650", "9.81"}, scratch.path() / "log");
    if (check.exit != 0) MESSAGE(check.output);
    CHECK(check.exit == 0);
    CHECK(check.output.find("grains.forces.pvd: 4 frames") != std::string::npos);

    auto const series = read_table(out / "grains.csv"), cells = read_table(out / "grains.voronoi.csv");
    REQUIRE(series.at("time [s]").size() == 7);
    REQUIRE(cells.at("time [s]").size() == 4);
    CHECK(series.find("packing_fraction") == series.end());
    for (std::size_t n = 0; n < 7; ++n) {
        double grains = 0.0;
        for (int k = 0; k <= 8; ++k) grains += series.at(fmt::format("with_{}", k))[n];
        CHECK(grains == 60.0);
        CHECK(series.at("contacts_bearing")[n] == series.at("coordination")[n]);
        CHECK(series.at("drift [J/m]")[n] == series.at("balance [J/m]")[n] - series.at("balance [J/m]")[0]);
        CHECK(std::abs(series.at("drift [J/m]")[n]) < 1e-9 * series.at("potential [J/m]")[0]);  // nothing moves
    }
    for (double const fraction : cells.at("packing_fraction")) {
        CHECK(fraction > 0.7);  // D07: 0.81 to 0.84 in the bulk, less at the walls of so small a box
        CHECK(fraction < 0.9069);
    }
}

TEST_CASE("measures: a scene that asks for the front alone gets no more, and no ledger is kept")
{
    in_threads::Scratch scratch;
    auto const out = scratch.path() / "run";
    REQUIRE(run(configs / "quarter_column.yaml", out,
                {"time.end=0.01", "participants.grains.config.column.count=60", "output.series=0.005",
                 "participants.grains.config.measures=[front]"})
                .exit == 0);
    auto const table = read_table(out / "grains.csv");
    CHECK(table.size() == 2);
    REQUIRE(table.at("front [m]").size() == 3);
    CHECK(table.at("front [m]")[0] > 0.0);
    CHECK(shell::slurp(out / "summary.json").find("no measure needs it") != std::string::npos);
    CHECK(std::filesystem::exists(out / "grains.measures.h5"));
    CHECK_FALSE(std::filesystem::exists(out / "grains.forces.pvd"));
}

namespace {

//! 144 discs that fall, in a CSV whose lines are in an order that `stride` decides (prime to 144).
void write_grains(std::filesystem::path const& file, int stride, double shift = 0.0)
{
    std::ofstream out(file);
    out.precision(17);
    out << "id,x,y,radius\n";
    for (int n = 0; n < 144; ++n) {
        int const k = n * stride % 144;
        out << 1000 + 3 * k << ',' << (k % 12 + 0.5 + 0.02 * (k % 5)) * 1.9e-3 + shift << ',' << (k / 12 + 0.5) * 1.9e-3
            << ',' << 0.6e-3 + 1e-5 * (k % 7) << '\n';
    }
}

}  // namespace

TEST_CASE("grains from a file: the order of its lines changes no bit, and a run goes on with the same grains only")
{
    in_threads::Scratch scratch;
    auto const scene = scratch.path() / "scene.yaml", file = scratch.path() / "packing.csv";
    std::ofstream(scene) << "sluice: 1\ntitle: grains from a file\ndimension: 2\ngravity: [0, -9.81]\n"
                            "time: {end: 0.02, window: auto}\nparticipants:\n  grains:\n    solver: dem\n"
                            "    config:\n      density: 2650\n"
                            "      contact: {normal_stiffness: 1.0e+6, damping_ratio: 0.2, friction: 0.5}\n"
                            "      packing: {file: packing.csv}\n      walls:\n"
                            "        - {name: floor, point: [0, 0], normal: [0, 1]}\n"
                            "        - {name: back, point: [0, 0], normal: [1, 0]}\n"
                            "output: {interval: 0.005, series: 0.001}\ncheckpoint: {windows: 50}\n";
    auto const out = [&](char const* name) { return scratch.path() / name; };
    write_grains(file, 1);
    REQUIRE(run(scene, out("sorted"), {}).exit == 0);
    write_grains(file, 59);
    REQUIRE(run(scene, out("scrambled"), {}).exit == 0);
    CHECK(same_bytes(out("sorted") / "grains.csv", out("scrambled") / "grains.csv"));
    for (auto const& entry : std::filesystem::directory_iterator(out("sorted") / "grains"))
        CHECK(same_bytes(entry.path(), out("scrambled") / "grains" / entry.path().filename()));

    auto const resume = [&] {
        std::vector<std::string> const words{sluice_command, "resume", out("sorted"), "--no-report", "--quiet"};
        return shell::run(words, out("resumed.log"), 250);
    };
    CHECK(resume().exit == 0);  // now in the other order
    write_grains(file, 59, 1e-5);
    auto const refused = resume();
    CHECK(refused.exit == 7);
    CHECK(refused.output.find("packing.csv holds other grains than when the run began") != std::string::npos);
    CHECK(same_bytes(out("sorted") / "grains.csv", out("scrambled") / "grains.csv"));
}

TEST_CASE("centrifuge_column: against the rotation the Coriolis part lifts the flow, and it comes further than with it")
{
    // S3 of the centrifuge study: w- > w+. Sixteen grains wide and high here, looked at after 5 sqrt(h0/(N g))
    in_threads::Scratch scratch;
    std::map<std::string, double> far;
    for (std::string const rate : {"8.530026", "-8.530026"}) {
        auto const out = scratch.path() / rate;
        REQUIRE(run(configs / "centrifuge_column.yaml", out,
                    {"frame.rotating.rate=" + rate, "participants.grains.config.column.count=300", "time.end=0.06",
                     "output.interval=0.06", "output.series=0.06"})
                    .exit == 0);
        auto const table = read_table(out / "grains.csv");
        far[rate] = table.at("centre_x [m]").back() / table.at("centre_x [m]").front();
    }
    CHECK(far.at("8.530026") > 1.02 * far.at("-8.530026"));
    CHECK(far.at("-8.530026") > 1.3);
}

TEST_CASE("loads on solids at rest are the same in the table whether it has a row each step or one now and then")
{
    in_threads::Scratch scratch;
    std::map<std::string, std::map<std::string, std::vector<double>>> tables;
    double const step = 0.05 * 0.01 / 0.3;  // s: lattice velocity, cell, velocity
    for (auto const& [name, every] : {std::pair("each", 1), std::pair("some", 7), std::pair("last", 1000)}) {
        auto const out = scratch.path() / name;
        REQUIRE(run(configs / "channel_cylinder.yaml", out,
                    {"participants.fluid.config.cell=0.01", fmt::format("output.series={:.17g}", every * step),
                     fmt::format("time.end={:.17g}", 24 * step), "output.interval=0"})
                    .exit == 0);
        tables[name] = read_table(out / "fluid.csv");
    }
    auto& each = tables["each"];
    REQUIRE(each["time [s]"].size() == 25);
    for (auto const& [name, rows] : {std::pair("some", std::vector<std::size_t>{0, 7, 14, 21, 24}),
                                     std::pair("last", std::vector<std::size_t>{0, 24})}) {
        REQUIRE(tables[name]["time [s]"].size() == rows.size());
        for (auto const& [column, values] : tables[name])
            for (std::size_t k = 0; k < rows.size(); ++k) CHECK(values[k] == each[column][rows[k]]);
    }
    CHECK(each["cylinder_force_x [N/m]"][24] > 0);
}

TEST_CASE("sweep D5: with 2 to 500 steps of the grains in one of the fluid a disc sinks and lands alike")
{
    in_threads::Scratch scratch;
    auto const scene = scratch.path() / "disc.yaml";
    std::ofstream(scene) << R"(sluice: 1
dimension: 2
gravity: [0, -9.81]
time: {end: 0.25, window: auto}
participants:
  grains:
    solver: dem
    config:
      density: 1250
      contact: {normal_stiffness: 5.0e+4, damping_ratio: 0.2, friction: 0.3}
      grains: [{position: [0.006, 0.008], radius: 0.001}]
      walls: [{name: floor, point: [0, 0], normal: [0, 1]}]
      buoyancy: {density: 1000}
  water:
    solver: lbm
    config:
      domain: {origin: [0, 0], size: [0.012, 0.014]}
      cell: 2.0e-4
      density: 1000
      viscosity: 1.0e-5
      max_velocity: 0.1
      lattice_velocity: 0.1
couplings:
  - {from: grains, to: water, data: kinematics}
  - {from: water, to: grains, data: load, lag: 1}
output: {interval: 0.25, series: 0.001}
)";
    std::map<int, std::vector<double>> height;
    for (int const steps : {500, 100, 44, 15, 5, 2}) {
        auto const out = scratch.path() / std::to_string(steps);
        REQUIRE(run(scene, out, {"participants.grains.config.step=" + fmt::format("{}", 2e-4 / steps)}).exit == 0);
        height[steps] = read_table(out / "grains.csv").at("centre_y [m]");
        REQUIRE(height[steps].size() == height[500].size());
        double most = 0;
        for (std::size_t k = 0; k < height[500].size(); ++k)
            most = std::max(most, std::abs(height[steps][k] - height[500][k]));
        CHECK(most < 0.01 * (0.008 - 0.001));  // the catalogue: 1 %
    }
    CHECK(height[500].back() == close_to(0.001).epsilon(0.01));  // it has landed
    // one step of the grains to a window of the fluid is longer than t_c/5 here
    CHECK(run(scene, scratch.path() / "one", {"participants.grains.config.step=2e-4"}).exit == 2);
}
