// DEM and LBM as two executables: every scene of configs/, the same bits over every transport, the third law.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tests/support/close_to.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/verification.hpp"

namespace {

std::string const sluice_command = SLUICE_COMMAND;
std::filesystem::path const configs = CONFIGS, readback = READBACK;

shell::Result run(std::filesystem::path const& scene, std::filesystem::path const& out,
                  std::vector<std::string> const& settings)
{
    ::setenv("SLUICE_CACHE", PACKING_CACHE, 1);
    std::vector<std::string> words{sluice_command, "run", scene, "--out", out, "--no-report", "--quiet"};
    for (auto const& setting : settings) words.insert(words.end(), {"--set", setting});
    auto result = shell::run(words, out.string() + ".output", 250);
    if (result.exit != 0) MESSAGE(result.output);
    return result;
}

//! Sixty grains in a small tank: a second of computing.
std::vector<std::string> small(std::vector<std::string> more = {})
{
    for (auto const setting :
         {"time.end=0.004", "participants.grains.config.column.count=60", "participants.water.config.cell=2.0e-4",
          "participants.water.config.domain.size=[0.04, 0.02]", "output.interval=0.001"})
        more.emplace_back(setting);
    return more;
}

//! The columns of a CSV by their names; empty cells are NaN.
std::map<std::string, std::vector<double>> read_table(std::filesystem::path const& file)
{
    std::ifstream in(file);
    std::string line, cell;
    std::vector<std::string> names;
    std::map<std::string, std::vector<double>> table;
    for (std::getline(in, line); !line.empty();) {
        auto const comma = line.find(',');
        names.push_back(line.substr(0, comma));
        line = comma == std::string::npos ? "" : line.substr(comma + 1);
    }
    while (std::getline(in, line)) {
        std::stringstream cells(line);
        for (auto const& name : names) {
            cell.clear();
            std::getline(cells, cell, ',');
            table[name].push_back(cell.empty() ? std::nan("") : std::stod(cell));
        }
    }
    return table;
}

bool same_bytes(std::filesystem::path const& a, std::filesystem::path const& b)
{
    auto const x = shell::slurp(a), y = shell::slurp(b);
    return !x.empty() && x == y;
}

std::string ranks(std::string const& who, int count)
{
    return "participants." + who + ".ranks=" + std::to_string(count);
}

//! Runs a scene as its settings say, and with each of `others` besides: `who` leaves the same tables and pictures.
void compare(std::string const& name, std::vector<std::string> const& settings,
             std::vector<std::vector<std::string>> const& others, std::string const& who)
{
    in_threads::Scratch scratch;
    auto const started = [&](std::string const& out, std::vector<std::string> const& more) {
        auto all = settings;
        all.insert(all.end(), more.begin(), more.end());
        REQUIRE(run(configs / name, scratch.path() / out, all).exit == 0);
        return scratch.path() / out;
    };
    auto const one = started("one", {});
    for (auto const& how : others) {
        CAPTURE(how[0]);
        auto const many = started("many", how);
        auto const table = one / (who + ".csv");
        CHECK(read_table(table).at("time [s]").size() > 2);
        CHECK(same_bytes(table, many / table.filename()));
        for (auto const& entry : std::filesystem::recursive_directory_iterator(one / who))
            CHECK(same_bytes(entry.path(), many / who / entry.path().filename()));
        for (auto const& entry : std::filesystem::directory_iterator(one))  // lines
            if (entry.path().filename().string().starts_with(who + ".") && entry.path().extension() == ".csv")
                CHECK(same_bytes(entry.path(), many / entry.path().filename()));
        std::filesystem::remove_all(many);
    }
}

}  // namespace

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

TEST_CASE("dry column: two processes that share the grains leave the bytes of one, sums of the ledger to rounding")
{
    in_threads::Scratch scratch;
    auto const scene = configs / "dry_column.yaml";
    auto const started = [&](std::string const& name, std::vector<std::string> more) {
        for (auto const setting : {"time.end=0.02", "participants.grains.config.column.count=150",
                                   "output.interval=0.005", "output.series=0.001"})
            more.emplace_back(setting);
        REQUIRE(run(scene, scratch.path() / name, more).exit == 0);
        return scratch.path() / name;
    };
    std::string const measures = "participants.grains.config.measures=[run_out, contacts, centre, profile]";
    auto const one = started("one", {measures}), two = started("two", {measures, "participants.grains.ranks=2"});
    CHECK(read_table(one / "series.csv").at("time [s]").size() > 15);
    for (auto const name : {"series.csv", "grains.csv"}) CHECK(same_bytes(one / name, two / name));
    for (auto const& entry : std::filesystem::recursive_directory_iterator(one / "grains"))
        CHECK(same_bytes(entry.path(), two / "grains" / entry.path().filename()));
    auto const booked = read_table(started("booked", {}) / "grains.csv");
    auto const shared = read_table(started("shared", {"participants.grains.ranks=3"}) / "grains.csv");
    REQUIRE(booked.size() == shared.size());
    double const scale = booked.at("balance [J/m]").at(0);
    for (auto const& [name, column] : booked)
        for (std::size_t k = 0; k < column.size(); ++k)
            CHECK(std::abs(shared.at(name).at(k) - column[k]) <= 1e-12 * scale);
}

TEST_CASE("immersed column: two and three processes that share the grains leave the bits of one")
{
    in_threads::Scratch scratch;
    auto const scene = configs / "immersed_column.yaml";
    auto const started = [&](std::string const& name, std::vector<std::string> more) {
        REQUIRE(run(scene, scratch.path() / name, small(std::move(more))).exit == 0);
        return scratch.path() / name;
    };
    std::string const films = "participants.grains.config.lubrication={viscosity: 1.0e-3, cutoff: 1.3e-4}";
    std::string const loads = "couplings.1.predict=linear";  // so that they change within a window
    for (auto const& how : {std::vector<std::string>{}, {loads}, {films, "participants.grains.config.step=1e-6"}}) {
        CAPTURE(how.size());
        auto const one = started("one", how);
        for (std::string const processes : {"2", "3"}) {
            auto more = how;
            more.push_back("participants.grains.ranks=" + processes);
            auto const many = started("many", more);
            CHECK(same_bytes(one / "water.csv", many / "water.csv"));
            for (auto const& who : {"grains", "water"})
                for (auto const& entry : std::filesystem::recursive_directory_iterator(one / who))
                    CHECK(same_bytes(entry.path(), many / who / entry.path().filename()));
            auto const booked = read_table(one / "grains.csv"), shared = read_table(many / "grains.csv");
            for (std::string const name :
                 {"window_impulse_x [N s/m]", "centre_x [m]", "kinetic [J/m]", "elastic [J/m]"})
                CHECK(shared.at(name) == booked.at(name));
            // terms of the ledger's sums are added up in another order, relative to the energy there is
            double const scale = booked.at("potential [J/m]").at(0);
            for (auto const& [name, column] : booked)
                for (std::size_t k = 0; k < column.size(); ++k)
                    CHECK(std::abs(shared.at(name).at(k) - column[k]) <= 1e-12 * scale);
            std::filesystem::remove_all(many);
        }
        std::filesystem::remove_all(one);
    }
}

TEST_CASE("water of several processes leaves the bytes of one, whatever the grains' processes and the transport")
{
    std::string const two = ranks("water", 2), three = ranks("water", 3), grains = ranks("grains", 2);
    compare("immersed_column.yaml", small(), {{two}, {three}, {two, grains}, {two, grains, "transport=mpi"}}, "water");
    compare("immersed_column.yaml", small({"participants.water.config.precision=single", "output.coarsen=3"}),
            {{three}}, "water");
    auto crowd = small();
    for (auto const setting :
         {"time.end=0.001", "output.series=0.0002", "participants.water.config.grains=interpolated"})
        crowd.emplace_back(setting);
    compare("immersed_column.yaml", crowd, {{three, grains}}, "water");
    std::vector<std::string> const brief{"time.end=0.02", "output.interval=0.01", "output.series=0.002"};
    compare("settling_sphere.yaml", brief, {{ranks("oil", 2)}, {ranks("oil", 3)}}, "oil");
    compare("rising_sphere.yaml",
            {"time.end=0.01", "output.interval=0.005", "output.series=0.001",
             "participants.oil.config.domain.size=[0.024, 0.024, 0.03]",
             "participants.sphere.config.grains=[{position: [0.012, 0.012, 0.015], radius: 0.004}]"},
            {{ranks("oil", 2)}, {ranks("oil", 3)}}, "oil");
    compare("channel_cylinder.yaml", brief, {{ranks("fluid", 2)}, {ranks("fluid", 3)}}, "fluid");
    compare("submerged_column.yaml", {"time.end=0.002", "output.interval=0.001", "output.series=0.001"},
            {{ranks("liquid", 3)}}, "liquid");
    compare("fluidised_bed.yaml", brief, {{ranks("water", 2)}}, "water");
}

TEST_CASE("a continuum of several processes leaves the bytes of one, alone, with grains and with a fluid of several")
{
    std::vector<std::string> const brief{"time.end=0.02", "output.interval=0.01", "output.series=0.002"};
    compare("mpm_slope.yaml", brief, {{ranks("soil", 2), "participants.soil.config.threads=2"}, {ranks("soil", 3)}},
            "soil");
    compare("boulder_drop.yaml", brief, {{ranks("bed", 2)}, {ranks("bed", 3), ranks("boulder", 2)}}, "bed");
    compare("boulder_in_water.yaml", {"time.end=0.002", "output.interval=0.001", "output.series=0.0005"},
            {{ranks("bed", 2), ranks("liquid", 2)}, {ranks("bed", 3), "transport=mpi"}}, "bed");
}

TEST_CASE("a continuum of several processes: a point that leaves the domain ends all, in one line")
{
    in_threads::Scratch scratch;
    auto const result = shell::run(
        {sluice_command, "run", configs / "mpm_column.yaml", "--out", scratch.path() / "out", "--no-report", "--set",
         ranks("soil", 2), "--set", "participants.soil.config.domain.size=[0.105, 0.1]", "--set", "time.end=0.2"},
        scratch.path() / "output", 60);
    CHECK(result.exit == static_cast<int>(sluice::Exit::numerical));
    auto const said = result.output.find("has left the domain (must stay inside)");
    REQUIRE_MESSAGE(said != std::string::npos, result.output);
    CHECK_MESSAGE(result.output.find("has left the domain", said + 1) == std::string::npos, result.output);
    CHECK_MESSAGE(result.output.find("\"soil:") != std::string::npos, result.output);
    CHECK_MESSAGE(result.output.find("bug") == std::string::npos, result.output);
}

TEST_CASE("water of several processes that blows up in one of them: all stop, with cell and time, and a summary")
{
    in_threads::Scratch scratch;
    auto const scene = scratch.path() / "cavity.yaml";
    std::ofstream(scene) << R"(sluice: 1
dimension: 2
time: {end: 1.0}
gravity: [0, 0]
participants:
  water:
    solver: lbm
    ranks: 2
    config:
      domain: {origin: [0, 0], size: [0.1, 0.1]}
      cell: 1.0e-3
      viscosity: 1.0e-6
      step: 5.0e-5
      walls: {left: no_slip, right: no_slip, bottom: no_slip, top: {velocity: 2.4}}
)";
    auto const result =
        shell::run({sluice_command, "run", scene, "--out", scratch.path() / "out"}, scratch.path() / "output", 60);
    CHECK(result.exit == static_cast<int>(sluice::Exit::numerical));
    for (auto const* said : {"\"water:1\" stopped in window", "speed must stay below 8 m/s", "compute s"})
        CHECK_MESSAGE(result.output.find(said) != std::string::npos, result.output);
    CHECK_MESSAGE(result.output.find("bug") == std::string::npos, result.output);
}

TEST_CASE("several processes: what cannot be shared is refused, with the reason, when the scene is checked")
{
    in_threads::Scratch scratch;
    auto const refused_in = [&](std::string const& scene, std::vector<std::string> const& settings,
                                std::string const& reason) {
        std::vector<std::string> words{sluice_command, "check", configs / scene};
        for (auto const& setting : settings) words.insert(words.end(), {"--set", setting});
        auto const result = shell::run(words, scratch.path() / "output", 60);
        CHECK(result.exit == 2);
        CHECK_MESSAGE(result.output.find(reason) != std::string::npos, result.output);
    };
    auto const refused = [&](std::vector<std::string> settings, std::string const& reason) {
        settings.insert(settings.begin(), ranks("grains", 2));
        refused_in("immersed_column.yaml", settings, reason);
    };
    refused_in("mpm_column.yaml", {ranks("soil", 3)}, "3 processes for 1280 points");
    refused_in("hanging_gel.yaml", {ranks("gel", 2)}, "2 processes with what goes one point at a time");
    refused_in("boulder_drop.yaml", {ranks("bed", 2), "on-death=restart", "checkpoint={windows: 10}"},
               "bed: on-death: restart with 2 processes that are coupled");
    refused({"participants.grains.config.sleep={speed: 1.0e-5, time: 0.005}"},
            "dem: grains that may sleep cannot be shared");
    refused({"on-death=restart", "checkpoint={windows: 10}"},
            "grains: on-death: restart with 2 processes that are coupled");
    refused(
        {"participants.grains.ranks=1", "participants.water.ranks=2", "on-death=restart", "checkpoint={windows: 10}"},
        "water: on-death: restart with 2 processes that are coupled");
    refused({"participants.water.ranks=101", "participants.water.config.domain.size=[0.35, 0.01]"},
            "101 processes for a lattice of 100 layers of cells along y");
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
