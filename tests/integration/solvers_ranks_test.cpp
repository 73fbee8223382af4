// Solvers whose work several processes share: the bytes of one, and what ends all of them.

#include <doctest/doctest.h>

#include "tests/integration/solver_runs.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/run_in_threads.hpp"

using namespace solver_runs;

namespace {

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
