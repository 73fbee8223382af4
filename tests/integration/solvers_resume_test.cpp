// Our own solvers stopped and resumed: everything that such a run leaves is what a run that was never stopped leaves,
// bit for bit. Participants are started by hand, which needs no timing, or by the command.

#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "coupler/base/error.hpp"
#include "coupler/base/status_page.hpp"
#include "tests/support/archive_content.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/shell.hpp"

namespace {

std::string const never = "checkpoint.windows=1000";
constexpr double patience = 120;  // s for a run of half a second: the machine may be busy

struct Solver
{
    std::string name, command;
};

//! A scene of configs/ with checkpoints, in a directory of its own.
class Case
{
 public:
    Case(std::string const& config, std::vector<Solver> solvers, std::vector<std::string> settings,
         std::string const& more = "")
        : solvers_(std::move(solvers)), settings_(std::move(settings))
    {
        ::setenv("SLUICE_CACHE", PACKING_CACHE, 1);
        std::ofstream(scene_) << shell::slurp(std::string(CONFIGS) + "/" + config) << "checkpoint: {windows: 49}\n"
                              << more;
    }

    std::filesystem::path out(std::string const& run) const { return scratch_.path() / run; }

    using Running = std::vector<std::unique_ptr<shell::Background>>;
    Running start(std::string const& run, std::vector<std::string> const& more = {}, bool resume = false) const
    {
        Running running;
        for (auto const& [name, command] : solvers_) {
            std::vector<std::string> words{command, scene_, "--as", name, "--out", out(run)};
            for (auto const& list : {settings_, more})
                for (auto const& setting : list) words.insert(words.end(), {"--set", setting});
            if (resume) words.push_back("--resume");
            running.push_back(std::make_unique<shell::Background>(words, log(run, name)));
        }
        return running;
    }
    //! Waits for all; each must end with `exit`.
    void finish(Running& running, int exit) const
    {
        for (auto& process : running) {
            auto const result = process->wait(patience);
            if (result.exit != exit) MESSAGE(result.output);
            REQUIRE(result.exit == exit);
        }
    }
    void run(std::string const& name, std::vector<std::string> const& more = {}, bool resume = false) const
    {
        auto running = start(name, more, resume);
        finish(running, 0);
    }

    //! Waits until the first process of `run` fulfils `condition` about its status page.
    template <class Condition>
    void wait_until(std::string const& run, Condition condition) const
    {
        auto const file = sluice::status_file(out(run), solvers_[0].name);
        for (int tries = 0; tries < 60'000; ++tries) {
            std::error_code none;
            if (std::filesystem::file_size(file, none) == sizeof(sluice::StatusPage)) {
                sluice::MappedStatus const page(file,
                                                sluice::MappedStatus::Mode::open);  // none: it has just been removed
                if (page && page->phase == sluice::Phase::running && condition(page)) return;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        FAIL("run \"" << run << "\" did not get there: " << shell::slurp(log(run, "sluice")));
    }
    //! Waits for a complete checkpoint of that window or a later one.
    void wait_for_checkpoint(std::string const& run, std::int64_t window) const
    {
        wait_until(run, [&](auto const& page) { return page->checkpoint >= window; });
    }
    //! The window of its newest checkpoint, as its first process last said.
    std::int64_t checkpoint(std::string const& run) const
    {
        auto const file = sluice::status_file(out(run), solvers_[0].name);
        return sluice::MappedStatus(file, sluice::MappedStatus::Mode::open)->checkpoint;
    }
    void kill(std::string const& run, std::string const& member) const
    {
        auto const file = sluice::status_file(out(run), member);
        ::kill(sluice::MappedStatus(file, sluice::MappedStatus::Mode::open)->pid, SIGKILL);
    }
    void wait_for_window(std::string const& run, std::int64_t window) const
    {
        wait_until(run, [&](auto const& page) { return page->window >= window; });
    }

    //! The result files of a run, by name: tables, ParaView files, archives, and the state of every participant before
    //! window 49 where there is a checkpoint of it.
    std::vector<std::pair<std::string, std::string>> results(std::string const& run) const
    {
        std::vector<std::pair<std::string, std::string>> files;
        for (auto const& entry : std::filesystem::recursive_directory_iterator(out(run))) {
            auto const name = entry.path().lexically_relative(out(run)).string();
            auto const ending = entry.path().extension();
            bool const plain = ending == ".csv" || ending == ".pvd" || ending == ".vtp" || ending == ".vti";
            if (plain || (ending == ".part" && name.starts_with("checkpoints/49/")))
                files.emplace_back(name, shell::slurp(entry.path()));
            if (ending == ".h5" && name != "archive.h5" && archive::has_reader())
                files.emplace_back(name, archive::content(entry.path()));
        }
        std::ranges::sort(files);
        for (auto const& [name, bytes] : files) CHECK_MESSAGE(!bytes.empty(), name);
        return files;
    }
    void check_same(std::string const& run, std::string const& reference) const
    {
        auto const a = results(run), b = results(reference);
        REQUIRE(a.size() == b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            CAPTURE(a[i].first);
            CHECK(a[i].first == b[i].first);
            CHECK((a[i].second == b[i].second));
        }
    }
    //! The same scene by the command `sluice`.
    std::unique_ptr<shell::Background> launch(std::string const& run) const
    {
        std::vector<std::string> words{SLUICE_COMMAND, "run", scene_, "--out", out(run), "--no-report", "--quiet"};
        for (auto const& setting : settings_) words.insert(words.end(), {"--set", setting});
        return std::make_unique<shell::Background>(words, log(run, "sluice"));
    }
    std::unique_ptr<shell::Background> resume(std::string const& run) const
    {
        std::vector<std::string> const words{SLUICE_COMMAND, "resume", out(run), "--no-report", "--quiet"};
        return std::make_unique<shell::Background>(words, log(run, "sluice"));
    }
    void forget(std::string const& run) const { std::filesystem::remove_all(out(run)); }
    void forget_checkpoints(std::string const& run) const { std::filesystem::remove_all(out(run) / "checkpoints"); }

 private:
    std::filesystem::path log(std::string const& run, std::string const& name) const
    {
        return scratch_.path() / (run + "." + name + ".log");
    }

    in_threads::Scratch scratch_;
    std::filesystem::path scene_ = scratch_.path() / "scene.yaml";
    std::vector<Solver> solvers_;
    std::vector<std::string> settings_;
};

//! Sixty grains in a small tank: 50 windows of 4e-5 s; pictures at the ends of windows 13, 25, 38 and 50, rows of the
//! tables at every second or third.
Case immersed(std::string const& threads = "1", std::string const& more = "")
{
    return {"immersed_column.yaml",
            {{"grains", DEM_COMMAND}, {"water", LBM_COMMAND}},
            {"time.end=0.002", "participants.grains.config.column.count=60", "participants.water.config.cell=2.0e-4",
             "participants.water.config.domain.size=[0.04, 0.02]", "participants.water.config.threads=" + threads,
             "output.interval=0.0005", "output.series=0.0001"},
            more};
}

//! The same with two processes of each, started by the command; without sums over processes, whose rounding a
//! checkpoint changes.
Case shared(std::string const& more = "")
{
    return {"immersed_column.yaml",
            {{"grains:0", ""}, {"grains:1", ""}, {"water:0", ""}, {"water:1", ""}},
            {"time.end=0.004", "participants.grains.ranks=2", "participants.water.ranks=2",
             "participants.grains.config.column.count=60",
             "participants.grains.config.measures=[run_out, contacts, centre, impulse]",
             "participants.water.config.cell=2.0e-4", "participants.water.config.domain.size=[0.04, 0.02]",
             "output.interval=0.0005", "output.series=0.0001", "checkpoint.windows=1"},
            more};
}

//! A disc that falls on a continuum of two processes, of which the first paces the run.
Case falling()
{
    return {
        "boulder_drop.yaml",
        {{"bed:0", ""}, {"bed:1", ""}, {"boulder", ""}},
        {"time.end=0.01", "participants.bed.ranks=2", "participants.bed.config.bodies.0.box.high=[1, 0.15]",
         "participants.bed.config.geostatic.surface=0.15", "participants.boulder.config.grains.0.position=[0.5, 0.205]",
         "output.interval=0.003", "output.series=0.001", "checkpoint.windows=1"}};
}

//! The same grains without water.
Case dry()
{
    return {"dry_column.yaml",
            {{"grains", DEM_COMMAND}},
            {"time.end=0.03", "participants.grains.config.column.count=60", "output.interval=0.005",
             "output.series=0.001"}};
}

//! A continuum of few points.
Case continuum()
{
    return {"mpm_column.yaml",
            {{"soil", MPM_COMMAND}},
            {"time.end=0.06", "participants.soil.config.cell=0.01", "output.interval=0.005", "output.series=0.001"}};
}

//! Sixty spheres with all measures, some at intervals of their own that no other output has.
Case measured()
{
    return {
        "quarter_column.yaml",
        {{"grains", DEM_COMMAND}},
        {"time.end=0.03", "participants.grains.config.column.count=60", "output.interval=0.01", "output.series=0.001",
         "participants.grains.config.measures={standard: {}, drift: {}, front: {interval: 0.0007}, coordination: "
         "{}, profile: {}, voronoi: {interval: 0.003}, force_chains: {interval: 0.004}}"}};
}

//! A cell that is sheared at constant pressure: its images move, the summary's means go on.
Case sheared()
{
    return {"critical_state.yaml",
            {{"grains", DEM_COMMAND}},
            {"time.end=0.02", "participants.grains.config.fill.count=200",
             "participants.grains.config.periodic.x=[0, 0.025]", "participants.grains.config.periodic.y=[0, 0.03]",
             "participants.grains.config.shear.rate=50", "participants.grains.config.shear.steady_from=0.1",
             "output.interval=0.005", "output.series=0.0005"}};
}

//! Runs the column to a checkpoint before `window` and one window more, then from there to the end: outputs, and the
//! state before window 49, are those of the run "whole".
void check_cut(Case const& c, int window)
{
    CAPTURE(window);
    c.run("cut", {"checkpoint.windows=" + std::to_string(window), "time.end=" + std::to_string((window + 1) * 4e-5)});
    REQUIRE(std::filesystem::exists(c.out("cut") / "checkpoints" / std::to_string(window) / "manifest.json"));
    c.run("cut", {"checkpoint.windows=" + std::to_string(49 - window)}, true);
    c.check_same("cut", "whole");
    c.forget("cut");
}

//! kill -9 of every process, three times in one run, each time soon after a checkpoint.
void check_killed(Case const& c, std::vector<std::int64_t> const& windows)
{
    bool resume = false;
    for (auto const window : windows) {
        auto running = c.start("killed", {"checkpoint.windows=1"}, resume);
        c.wait_for_checkpoint("killed", window);
        for (auto& process : running) process->signal(SIGKILL);
        c.finish(running, 128 + SIGKILL);
        resume = true;
    }
    c.run("killed", {never}, true);
    c.check_same("killed", "whole");
}

//! SIGTERM to one process stops all of them with a checkpoint; `victims`: which one, and after which window.
void check_stopped(Case const& c, std::vector<std::pair<std::size_t, std::int64_t>> const& victims)
{
    bool resume = false;
    for (auto const& [victim, window] : victims) {
        auto running = c.start("stopped", {"checkpoint.windows=1"}, resume);
        c.wait_for_checkpoint("stopped", window);
        running[victim]->signal(SIGTERM);
        c.finish(running, static_cast<int>(sluice::Exit::stopped));
        resume = true;
    }
    c.run("stopped", {never}, true);
    c.check_same("stopped", "whole");
}

//! Stops a run by the command with SIGTERM, kills one process after the other of what goes on, then lets it end.
void check_commanded(Case const& c, std::vector<std::string> const& victims)
{
    REQUIRE(c.launch("whole")->wait(patience).exit == 0);
    c.forget_checkpoints("whole");  // they are of other windows
    auto stopped = c.launch("cut");
    c.wait_for_checkpoint("cut", 5);
    stopped->signal(SIGTERM);
    REQUIRE(stopped->wait(patience).exit == static_cast<int>(sluice::Exit::stopped));
    for (std::string const& victim : victims) {
        CAPTURE(victim);
        auto const before = c.checkpoint("cut");
        auto running = c.resume("cut");
        c.wait_for_checkpoint("cut", before + 5);
        c.kill("cut", victim);
        auto const result = running->wait(patience);
        CHECK_MESSAGE(result.exit == static_cast<int>(sluice::Exit::peer_died), result.output);
    }
    REQUIRE(c.resume("cut")->wait(patience).exit == 0);
    c.forget_checkpoints("cut");
    c.check_same("cut", "whole");
}

}  // namespace

TEST_CASE("immersed column: cut at any window and resumed, with one thread and with two, it leaves the same bits")
{
    Case const c = immersed(), two = immersed("2");
    c.run("whole");
    CHECK(c.results("whole").size() >= 4 + 5 + 5 + 2);             // tables and collections, pictures, checkpoint parts
    for (int const window : {1, 6, 13, 48}) check_cut(c, window);  // 13: a picture at this very time
    two.run("whole");
    CHECK((two.results("whole") == c.results("whole")));
    check_cut(two, 25);
}

TEST_CASE("immersed column: checkpoints change no bit")
{
    Case const c = immersed();
    c.run("whole", {never});
    c.run("many", {"checkpoint.windows=2"});
    c.check_same("many", "whole");
}

TEST_CASE("immersed column: killed three times and resumed, it leaves the same bits")
{
    Case const c = immersed();
    c.run("whole", {never});
    check_killed(c, {3, 14, 30});
}

TEST_CASE("immersed column: stopped by a signal to either solver and resumed, it leaves the same bits")
{
    Case const c = immersed();
    c.run("whole", {never});
    check_stopped(c, {{0, 4}, {1, 20}});
}

TEST_CASE("immersed column, implicit: windows that are computed again are recorded once, and a cut changes no bit")
{
    Case const c = immersed("1", "implicit:\n  - {participants: [grains, water], tolerance: {load: 1.0e-4}}\n");
    c.run("whole");
    auto const summary = shell::slurp(c.out("whole") / ".sluice/grains.json");
    auto const at = summary.find("\"iterations\": ");
    REQUIRE(at != std::string::npos);
    CHECK(std::stoi(summary.substr(at + 14)) > 2 * 50);  // more than one more each: they were repeated
    auto const table = shell::slurp(c.out("whole") / "grains.csv");
    CHECK(std::ranges::count(table, '\n') == 1 + 1 + 20);  // header, the start, every 1e-4 s of 0.002 s
    for (int const window : {7, 25}) check_cut(c, window);
}

TEST_CASE("dry column, one participant alone: killed or stopped and resumed, it leaves the same bits")
{
    Case const c = dry();
    c.run("whole", {never});
    check_killed(c, {2, 80, 200});
    check_stopped(c, {{0, 5}, {0, 150}});
}

TEST_CASE("column of a continuum: killed or stopped and resumed, it leaves the same bits")
{
    Case const c = continuum();
    c.run("whole", {never});
    check_killed(c, {2, 8});
    check_stopped(c, {{0, 5}});
}

TEST_CASE("boulder on a continuum: cut at any window and resumed, it leaves the same bits")
{
    Case const c(
        "boulder_drop.yaml", {{"boulder", DEM_COMMAND}, {"bed", MPM_COMMAND}},
        {"time.end=0.002", "time.window=4e-5", "output.interval=0.001", "output.series=0.0001",
         "participants.bed.config.cell=0.025",
         "participants.boulder.config.grains=[{radius: 0.05, position: [0.5, 0.3505], velocity: [0.5, -1.5]}]"});
    c.run("whole");
    CHECK(shell::slurp(c.out("whole") / ".sluice/bed.json").find("contacts with grains") != std::string::npos);
    for (int const window : {1, 30}) check_cut(c, window);
}

TEST_CASE("continuum in a fluid that is not resolved: cut at any window and resumed, it leaves the same bits")
{
    Case const c("submerged_column.yaml", {{"soil", MPM_COMMAND}, {"liquid", LBM_COMMAND}},
                 {"time.end=0.002", "time.window=4e-5", "output.interval=0.001", "output.series=0.0001",
                  "participants.soil.config.cell=0.01", "participants.liquid.config.cell=5e-3",
                  "participants.liquid.config.step=2e-5"});
    c.run("whole");
    for (int const window : {1, 30}) check_cut(c, window);
}

TEST_CASE("measures: killed or stopped and resumed, no row, picture or step is missing or there twice")
{
    Case const c = measured();
    c.run("whole", {never});
    auto const rows = [&](char const* table) {
        auto const text = shell::slurp(c.out("whole") / table);
        return std::ranges::count(text, '\n') - 1;  // without the header
    };
    CHECK(rows("grains.csv") == 31);        // the start, and every 1e-3 s of 0.03 s
    CHECK(rows("grains.front.csv") == 44);  // 42 multiples of 7e-4 s, the start and the end
    CHECK(rows("grains.voronoi.csv") == 11);
    CHECK(std::ranges::any_of(c.results("whole"), [](auto const& file) { return file.first == "grains.forces.pvd"; }));
    check_killed(c, {2, 60, 120});
    check_stopped(c, {{0, 5}, {0, 90}});
}

TEST_CASE("sheared cell: killed and stopped runs continue bit for bit")
{
    Case const c = sheared();
    c.run("whole", {never});
    check_killed(c, {2, 80});
    check_stopped(c, {{0, 5}});
}

TEST_CASE("immersed column: a resumed run pours nothing, and says where it went on")
{
    Case const c = immersed();
    c.run("cut", {"checkpoint.windows=24", "time.end=0.001"});
    ::setenv("SLUICE_CACHE", c.out("cache").c_str(), 1);
    c.run("cut", {}, true);
    CHECK(!std::filesystem::exists(c.out("cache")));
    for (std::string const name : {"grains", "water"}) {
        auto const summary = shell::slurp(c.out("cut") / ".sluice" / (name + ".json"));
        CHECK(summary.find("\"resumed_at\": 0.00096") != std::string::npos);
        for (auto const& warning : nlohmann::json::parse(summary)["warnings"]) {
            CAPTURE(warning);
            CHECK(warning.get<std::string>().ends_with("the slow partner."));  // rightly so on a busy machine
        }
        if (name == "grains") CHECK(summary.find("\"H0 [m]\": 0.0") != std::string::npos);
    }
}

TEST_CASE("immersed column: run by the command, stopped by SIGTERM and resumed by the command, it leaves the same bits")
{
    Case const c = immersed();
    auto whole = c.launch("whole");
    REQUIRE(whole->wait(patience).exit == 0);
    auto stopped = c.launch("stopped");
    c.wait_for_window("stopped", 10);
    stopped->signal(SIGTERM);
    REQUIRE(stopped->wait(patience).exit == static_cast<int>(sluice::Exit::stopped));
    auto const resumed = c.resume("stopped")->wait(patience);
    if (resumed.exit != 0) MESSAGE(resumed.output);
    REQUIRE(resumed.exit == 0);
    c.forget_checkpoints("stopped");  // they are of other windows
    c.forget_checkpoints("whole");
    c.check_same("stopped", "whole");  // series.csv and the joint collection among them
    CHECK(std::filesystem::exists(c.out("stopped") / "series.csv"));
}

TEST_CASE(
    "immersed column, grains and water of two processes each: stopped or killed and resumed by the command, the same "
    "bits")
{
    for (std::string const more : {"", "implicit:\n  - {participants: [grains, water], tolerance: {load: 1.0e-4}}\n"}) {
        CAPTURE(more);
        check_commanded(shared(more), {"grains:1", "water:1", "water:0", "grains:0"});
    }
}

TEST_CASE("a continuum of two processes under a grain: stopped or killed and resumed by the command, the same bits")
{
    check_commanded(falling(), {"bed:1", "bed:0", "boulder"});
}
