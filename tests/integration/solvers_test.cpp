// DEM and LBM as two executables: every scene of configs/, the same bits over every transport, the third law.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <map>

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
        bool const fills = shell::slurp(entry.path()).find("fill:") != std::string::npos;
        REQUIRE(run(entry.path(), out,
                    {"time.end=0.0006",
                     std::string("participants.grains.config.") + (fills ? "fill" : "column") + ".count=60",
                     "output.interval=0.0002"})
                    .exit == 0);
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
