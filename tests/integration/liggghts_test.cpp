// A real LIGGGHTS in the place of our DEM: the scenes of configs/ with one word changed, a script of a user's, resumed
// runs.

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"

namespace {

std::string const sluice_command = SLUICE_COMMAND;
std::filesystem::path const configs = CONFIGS;

struct Case
{
    Case() { ::setenv("SLUICE_CACHE", PACKING_CACHE, 1); }

    std::filesystem::path out(std::string const& run) const { return scratch.path() / run; }
    shell::Result command(std::string const& word, std::string const& scene, std::string const& run,
                          std::vector<std::string> const& settings) const
    {
        std::vector<std::string> words{sluice_command, word, scene};
        if (word == "run") words.insert(words.end(), {"--out", out(run)});
        if (word != "check") words.insert(words.end(), {"--no-report", "--quiet"});
        for (auto const& setting : settings) words.insert(words.end(), {"--set", setting});
        return shell::run(words, scratch.path() / "output", 250);
    }
    void run(std::string const& scene, std::string const& name, std::vector<std::string> const& settings) const
    {
        auto const result = command("run", scene, name, settings);
        if (result.exit != 0) MESSAGE(result.output);
        REQUIRE(result.exit == 0);
    }
    nlohmann::json summary(std::string const& run) const
    {
        return nlohmann::json::parse(shell::slurp(out(run) / "summary.json"));
    }

    in_threads::Scratch scratch;
};

bool says(std::string const& output, std::string const& text)
{
    bool const found = output.find(text) != std::string::npos;
    if (!found) MESSAGE("not in the output: " << output);
    return found;
}

//! The last row of a table, by the names of its columns.
std::map<std::string, double> last_row(std::filesystem::path const& file)
{
    std::istringstream lines(shell::slurp(file));
    std::string header, line, row;
    std::getline(lines, header);
    while (std::getline(lines, line)) row = line;
    std::map<std::string, double> found;
    std::istringstream names(header), cells(row);
    for (std::string name, cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');)
        found[name] = std::stod(cell);
    return found;
}

bool same_bytes(std::filesystem::path const& a, std::filesystem::path const& b)
{
    auto const x = shell::slurp(a), y = shell::slurp(b);
    return !x.empty() && x == y;
}

std::vector<std::string> joined(std::vector<std::string> a, std::vector<std::string> const& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

//! A small tank with sixty discs, as in solvers_test.
std::vector<std::string> const tank{
    "participants.grains.solver=liggghts", "time.end=0.004", "participants.grains.config.column.count=60",
    "participants.water.config.cell=2.0e-4", "participants.water.config.domain.size=[0.04, 0.02]"};

}  // namespace

TEST_CASE("liggghts: scenes run with either solver, by one word, and agree as long as nothing has grown")
{
    struct
    {
        std::string scene, grains;
        double end;
        std::vector<std::string> settings;
    } const scenes[] = {
        {"immersed_column", "grains", 0.004, joined(tank, {"output.series=0.001"})},
        {"dry_column", "grains", 0.02, {"participants.grains.config.column.count=60"}},
        {"run_out", "grains", 0.02, {"participants.grains.config.column.count=100"}},
        {"quarter_column", "grains", 0.02, {"participants.grains.config.column.count=100"}},
        {"run_out_quarter", "grains", 0.02, {"participants.grains.config.column.count=100"}},
        {"settling_sphere", "sphere", 0.05, {}},
    };
    for (auto const& [scene, grains, end, more] : scenes) {
        CAPTURE(scene);
        Case c;
        for (std::string const solver : {"dem", "liggghts"})
            c.run(configs / (scene + ".yaml"), solver,
                  joined(more, {"participants." + grains + ".solver=" + solver, "time.end=" + std::to_string(end)}));
        auto const ours = last_row(c.out("dem") / (grains + ".csv"));
        auto const theirs = last_row(c.out("liggghts") / (grains + ".csv"));
        REQUIRE(ours.size() == theirs.size());
        CHECK(ours.at("time [s]") == theirs.at("time [s]"));
        for (std::string const column : {"run_out [m]", "height [m]", "centre_x [m]", "centre_z [m]"})
            if (ours.contains(column))  // the first steps of a collapse: springs of the packing are not in LIGGGHTS
                CHECK(std::abs(ours.at(column) - theirs.at(column)) < 0.02 * std::abs(ours.at(column)));
        auto const said = c.summary("liggghts");
        CHECK(said.at("participants").size() == c.summary("dem").at("participants").size());
        CHECK(!shell::slurp(c.out("liggghts") / (grains + ".liggghts.log")).empty());
    }
}

TEST_CASE("liggghts: what it cannot do is refused before anything is started")
{
    Case c;
    auto const check = [&](std::string const& scene, std::vector<std::string> const& more) {
        auto const result =
            c.command("check", configs / (scene + ".yaml"), "", joined({"participants.grains.solver=liggghts"}, more));
        CHECK(result.exit == 2);
        return result.output;
    };
    auto const sheared = check("critical_state", {});
    CHECK(says(sheared, "critical_state.yaml:"));
    CHECK(says(sheared, "participants.grains.config.periodic: is not handed to LIGGGHTS"));
    CHECK(says(check("centrifuge_column", {}), "knows no frame but the inertial one"));
    CHECK(says(check("immersed_column", {"on-death=restart"}), "LIGGGHTS cannot go back in a run"));
    CHECK(says(check("immersed_column", {"implicit=[{participants: [grains, water]}]"}), "cannot repeat a window"));
}

TEST_CASE("liggghts: a resumed run leaves the bytes of one that was not stopped, a gate on the way")
{
    Case c;
    auto const settings = joined(tank, {"participants.grains.config.column.gate_removed_at=0.003",
                                        "participants.grains.config.measures=[standard, coordination]",
                                        "output.series=0.0001", "output.interval=0.001", "checkpoint.windows=30"});
    c.run(configs / "immersed_column.yaml", "whole", settings);
    std::filesystem::copy(c.out("whole"), c.out("resumed"), std::filesystem::copy_options::recursive);
    std::filesystem::remove_all(c.out("resumed") / "checkpoints" / "90");
    REQUIRE(std::filesystem::exists(c.out("resumed") / "checkpoints" / "60"));  // of 100 windows
    auto const result = c.command("resume", c.out("resumed"), "", {});
    if (result.exit != 0) MESSAGE(result.output);
    REQUIRE(result.exit == 0);
    CHECK(std::filesystem::exists(c.out("resumed") / "grains.liggghts.resumed.log"));
    for (auto const file : {"grains.csv", "water.csv", "series.csv"})
        CHECK(same_bytes(c.out("whole") / file, c.out("resumed") / file));
    for (auto const& entry : std::filesystem::recursive_directory_iterator(c.out("whole") / "grains"))
        CHECK(same_bytes(entry.path(), c.out("resumed") / "grains" / entry.path().filename()));
}

TEST_CASE("liggghts: processes that share the grains move them as one does, and go on from a checkpoint")
{
    Case c;
    auto const settings = joined(
        tank, {"participants.grains.config.column.count=200", "participants.water.config.domain.size=[0.06, 0.03]",
               "output.series=0.0005", "checkpoint.windows=30"});
    c.run(configs / "immersed_column.yaml", "one", settings);
    auto const one = last_row(c.out("one") / "grains.csv");
    c.run(configs / "immersed_column.yaml", "mpi",
          joined(settings, {"transport=mpi"}));  // one MPI for fluid and LIGGGHTS
    CHECK(same_bytes(c.out("mpi") / "grains.csv", c.out("one") / "grains.csv"));
    for (std::string const ranks : {"2", "3"}) {
        c.run(configs / "immersed_column.yaml", ranks, joined(settings, {"participants.grains.ranks=" + ranks}));
        auto const shared = last_row(c.out(ranks) / "grains.csv");
        REQUIRE(shared.size() == one.size());
        for (std::string const column :
             {"run_out [m]", "kinetic [J/m]", "potential [J/m]", "fluid_work [J/m]", "centre_x [m]"})
            // forces of a grain add up in another order: rounding, grown over 2000 steps of touching grains
            CHECK(std::abs(shared.at(column) - one.at(column)) < 1e-9 * std::abs(one.at(column)));
        CHECK(c.summary(ranks).at("participants").size() == 2);
    }
    std::filesystem::copy(c.out("2"), c.out("resumed"), std::filesystem::copy_options::recursive);
    std::filesystem::remove_all(c.out("resumed") / "checkpoints" / "90");
    REQUIRE(std::filesystem::exists(c.out("resumed") / "checkpoints" / "60"));
    REQUIRE(c.command("resume", c.out("resumed"), "", {}).exit == 0);
    for (auto const file : {"grains.csv", "water.csv"}) CHECK(same_bytes(c.out("2") / file, c.out("resumed") / file));
}

TEST_CASE("liggghts: grains change hands between processes on their way")
{
    Case c;
    std::vector<std::string> const settings{"participants.grains.solver=liggghts", "time.end=0.1",
                                            "participants.grains.config.column.count=60", "output.series=0.01"};
    c.run(configs / "dry_column.yaml", "one", settings);
    c.run(configs / "dry_column.yaml", "two", joined(settings, {"participants.grains.ranks=2"}));
    auto const one = last_row(c.out("one") / "grains.csv"), two = last_row(c.out("two") / "grains.csv");
    CHECK(one.at("run_out [m]") > 1.5 * 0.01);  // from a column of 9 mm: many have crossed the middle of the box
    // rounding of 1e-16 grows by a factor of e in each of the some 30 collisions of a grain: 1e-3 seen
    CHECK(std::abs(one.at("centre_x [m]") - two.at("centre_x [m]")) < 0.02 * one.at("centre_x [m]"));
    CHECK(shell::processes_with(c.scratch.path()) == 0);
}

namespace {

//! The sphere of settling_sphere.yaml, by hand.
std::string const script =
    "units si\natom_style granular\natom_modify map array sort 0 0\nboundary m m m\nnewton off\n"
    "communicate single vel yes\n"
    "if \"${resumed} == 1\" then \"read_restart ${restart}\" else \"read_data ${folder}/sphere.data\"\n"
    "neighbor 0.003 bin\nneigh_modify delay 0 every 1 check yes contact_distance_factor 1.05\n"
    "fix kn all property/global kn peratomtypepair 1 1000\nfix kt all property/global kt peratomtypepair 1 285.7\n"
    "fix cn all property/global gamman_abs peratomtypepair 1 0.07\n"
    "fix ct all property/global gammat_abs peratomtypepair 1 0\n"
    "fix mu all property/global coefficientFriction peratomtypepair 1 0\n"
    "pair_style gran model hooke/stiffness tangential history &\n  absolute_damping on limitForce on\n"
    "pair_coeff * *\n"
    "fix gravity all gravity 1.4014285714285719 vector 0 0 -1   # less the buoyancy\n"
    "fix integration all nve/sphere\ntimestep 1e-4\n";
std::string const data =
    "a sphere\n\n1 atoms\n1 atom types\n\n0 0.1 xlo xhi\n0 0.1 ylo yhi\n0 0.16 zlo zhi\n\nAtoms\n\n"
    "7 1 0.015 1120 0.05 0.05 0.1275\n";

//! A second one, in the lower half of the box.
std::string const two = [] {
    auto text = data;
    text.replace(text.find("1 atoms"), 1, "2");
    return text + "12 1 0.015 1120 0.03 0.05 0.04\n";
}();

//! The scene, with that script.
std::string scripted(Case const& c, std::string const& text, std::string const& spheres = data)
{
    auto scene = shell::slurp(configs / "settling_sphere.yaml");
    auto const begin = scene.find("    solver: dem"), end = scene.find("  oil:");
    REQUIRE(end != std::string::npos);
    scene.replace(begin, end - begin,
                  "    solver: liggghts\n    config: {script: in.sphere, step: 6.2504326743976503e-05, measures: "
                  "[centre, impulse]}\n");
    std::ofstream(c.out("scene.yaml")) << scene << "checkpoint: {windows: 20}\n";
    std::ofstream(c.out("in.sphere")) << text;
    std::ofstream(c.out("sphere.data")) << spheres;
    return c.out("scene.yaml");
}

//! Two hundred of several densities, not in the order of their ids.
std::string const many = [] {
    std::string text = data.substr(0, data.find("7 1 0.015"));
    text.replace(text.find("1 atoms"), 1, "200");
    for (int k = 0; k < 200; ++k) {
        int const id = (k * 73) % 200 + 1;  // 73 and 200 have no common divisor
        auto const at = [](int i) { return std::to_string(0.02 + 0.012 * i + 1e-4 * (i % 3)); };
        text += std::to_string(id) + " 1 0.006 " + std::to_string(1500 + 7 * id) + ' ' + at(k % 5) + ' ' +
                at(k / 5 % 5) + ' ' + at(k / 25) + '\n';
    }
    return text;
}();

}  // namespace

TEST_CASE("liggghts: a script that lets LIGGGHTS sort its rows leaves the same centres, and resumed the same bytes")
{
    Case c;
    std::vector<std::string> const settings{"time.end=0.04", "output.series=1e-4"};
    std::string sorted = script;
    sorted.replace(sorted.find("sort 0 0"), 8, "sort 100000 0.002");  // at checkpoints alone
    c.run(scripted(c, script, many), "as they are", settings);
    c.run(scripted(c, sorted, many), "sorted", settings);
    auto const a = last_row(c.out("as they are") / "sphere.csv"), b = last_row(c.out("sorted") / "sphere.csv");
    for (char const* const axis : {"centre_x [m]", "centre_y [m]", "centre_z [m]"}) CHECK(a.at(axis) == b.at(axis));
    std::filesystem::copy(c.out("sorted"), c.out("resumed"), std::filesystem::copy_options::recursive);
    REQUIRE(c.command("resume", c.out("resumed"), "", {}).exit == 0);
    CHECK(same_bytes(c.out("sorted") / "sphere.csv", c.out("resumed") / "sphere.csv"));
}

TEST_CASE("liggghts: a script of the user's in the place of the block, with ids of its own, resumed too")
{
    Case c;
    std::string const end = "time.end=0.05";
    auto const scene = scripted(c, script);
    c.run(scene, "script", {end});
    c.run(configs / "settling_sphere.yaml", "block", {end, "participants.sphere.solver=liggghts"});
    auto const by_script = last_row(c.out("script") / "sphere.csv"), by_block = last_row(c.out("block") / "sphere.csv");
    CHECK(by_script.at("centre_z [m]") == by_block.at("centre_z [m]"));
    CHECK(by_script.at("centre_z [m]") < 0.127);  // it has moved
    std::filesystem::copy(c.out("script"), c.out("resumed"), std::filesystem::copy_options::recursive);
    REQUIRE(c.command("resume", c.out("resumed"), "", {}).exit == 0);
    CHECK(std::filesystem::exists(c.out("resumed") / "sphere.liggghts.resumed.log"));
    CHECK(same_bytes(c.out("script") / "sphere.csv", c.out("resumed") / "sphere.csv"));
}

TEST_CASE("liggghts: processes share the grains of a script, also where one has none, and go on")
{
    for (auto const* const spheres : {&data, &two}) {
        Case c;
        std::string const end = "time.end=0.05";
        auto const scene = scripted(c, script, *spheres);
        c.run(scene, "one", {end});
        c.run(scene, "shared", {end, "participants.sphere.ranks=2"});
        auto const one = last_row(c.out("one") / "sphere.csv"), shared = last_row(c.out("shared") / "sphere.csv");
        CHECK(one.at("centre_z [m]") < (spheres == &data ? 0.127 : 0.0837));  // they have moved
        for (std::string const column : {"centre_x [m]", "centre_y [m]", "centre_z [m]"})
            CHECK(std::abs(shared.at(column) - one.at(column)) < 1e-12 * one.at(column));  // rounding
        std::filesystem::copy(c.out("shared"), c.out("resumed"), std::filesystem::copy_options::recursive);
        REQUIRE(c.command("resume", c.out("resumed"), "", {}).exit == 0);
        CHECK(same_bytes(c.out("shared") / "sphere.csv", c.out("resumed") / "sphere.csv"));
    }
}

TEST_CASE("liggghts: a mistake in a script, and one while it computes, end the run with one message")
{
    Case c;
    auto wrong = script;
    wrong.replace(wrong.find("pair_coeff"), 10, "pair_koeff");
    auto const result = c.command("run", scripted(c, wrong), "wrong", {});
    CHECK(result.exit == 2);
    CHECK(says(result.output, "in.sphere:17: LIGGGHTS stops: Unknown command: pair_koeff"));
    auto incomplete = script;  // found out when it first computes
    incomplete.replace(incomplete.find("fix mu all"), 0, "#");
    auto const later = c.command("run", scripted(c, incomplete), "incomplete", {});
    CHECK(later.exit != 0);
    CHECK(says(later.output, "LIGGGHTS stops: "));
    CHECK(says(later.output, "coefficientFriction"));
    CHECK(shell::processes_with(c.scratch.path()) == 0);
}
