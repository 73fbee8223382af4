// Runs that are stopped as asked and go on from a checkpoint: the same bits as one that was not stopped. Times are
// bounds of the design (SIGTERM to the end: 20 s at most, since Slurm kills after 30 s), not benchmarks.

#include "tests/support/launched.hpp"

using namespace launched;

namespace {

//! The same scene, not stopped.
double whole(std::string const& name)
{
    static Case const c(scene());
    static int const exit = c.run().exit;
    REQUIRE(exit == 0);
    return c.final_place(name);
}

}  // namespace

TEST_CASE("resume: SIGINT and SIGTERM end a run with a checkpoint, and it goes on to the same bits")
{
    // 300 windows: over MPI one takes 0.1 s on a starved machine, and 1000 went beyond the 120 s that a command gets
    auto const short_scene = [](std::string text) { return text.replace(text.find("end: 1,"), 7, "end: 0.3,"); };
    Case const calm(short_scene(scene()));
    REQUIRE(calm.run().exit == 0);
    for (int number : {SIGINT, SIGTERM})
        for (auto const transport : {"zmq", "mpi"}) {
            CAPTURE(transport);
            CAPTURE(number);
            Case c(short_scene(scene(", nap: 0.01", "")));
            shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
            REQUIRE(c.pid_in_window("left", 50) > 0);
            run.signal(number);
            auto const result = run.wait(20);
            CHECK(result.exit == 75);
            CHECK(says(result, "with a checkpoint. Go on with: sluice resume " + c.out()));
            CHECK(summary(c).at("exit") == 75);
            CHECK(c.checkpoints().size() == 1);
            CHECK(c.leftovers() == 0);
            double const before = summary(c).at("participants")[0].at("compute_seconds");
            CHECK(c.resume().exit == 0);
            for (auto const name : {"left", "right"}) CHECK(c.final_place(name) == calm.final_place(name));
            auto const both = summary(c);
            CHECK(both.at("windows") == 300);
            CHECK(both.at("parts").size() == 2);
            CHECK(both.at("transport") == transport);
            CHECK(both.at("participants")[0].at("compute_seconds").get<double>() > before);
            CHECK(both.at("participants")[0].at("resumed_at").get<double>() > 0.04);
        }
}

TEST_CASE("resume: SIGTERM to one participant stops all of them with a checkpoint")
{
    for (auto const asked : {"left", "right"}) {
        CAPTURE(asked);
        Case c(scene(", nap: 0.002", ""));
        shell::Background run(c.command(), c.log());
        int const pid = c.pid_in_window(asked, 50);
        REQUIRE(pid > 0);
        ::kill(pid, SIGTERM);
        CHECK(run.wait(20).exit == 75);
        CHECK(c.resume().exit == 0);
        CHECK(c.final_place("right") == whole("right"));
    }
}

TEST_CASE("resume: SIGUSR1 to the launcher: a checkpoint, and the run goes on")
{
    Case c(scene(", nap: 0.002", ""));
    shell::Background run(c.command(), c.log());
    REQUIRE(c.pid_in_window("left", 50) > 0);
    run.signal(SIGUSR1);
    CHECK(run.wait(60).exit == 0);
    REQUIRE(c.checkpoints().size() == 1);
    CHECK(c.checkpoints()[0] >= 50);
    CHECK(c.checkpoints()[0] < 1000);
}

TEST_CASE("resume: without a solver's state a run that is stopped ends at the next window, with exit 130")
{
    for (int number : {SIGINT, SIGTERM})
        for (auto const transport : {"zmq", "mpi"}) {
            CAPTURE(transport);
            CAPTURE(number);
            Case c(scene(", nap: 0.01", ", nap: 0.01, keep: false"));
            shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
            REQUIRE(c.pid_in_window("left", 5) > 0);
            run.signal(number);
            auto const result = run.wait(20);
            CHECK(result.exit == 130);
            CHECK(says(result, "cannot be resumed"));
            CHECK(says(result, "before window"));
            CHECK(c.leftovers() == 0);
            auto const resumed = c.resume();
            CHECK(resumed.exit == 7);
            CHECK(says(resumed, "no complete checkpoint"));
        }
}

TEST_CASE("resume: a signal after the last window changes nothing, the run is complete")
{
    Case c(scene(", nap: 0.001", ", fault: linger, fault_window: 5"));
    shell::Background run(c.command(), c.log());
    REQUIRE(c.pid_in_window("right", 10) > 0);
    auto const is_done = [&](char const* name) {
        return sluice::MappedStatus(sluice::status_file(c.out(), name), sluice::MappedStatus::Mode::open)->phase ==
               sluice::Phase::done;
    };
    while (!is_done("left") || !is_done("right")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    run.signal(SIGTERM);  // "right" takes another second to end
    CHECK(run.wait(20).exit == 0);
    CHECK(c.final_place("right") == whole("right"));
}

TEST_CASE("resume: a second signal ends a run whose window takes too long, and names who is where")
{
    for (auto const transport : {"zmq", "mpi"}) {
        CAPTURE(transport);
        Case c(scene("", ", fault: hang, fault_window: 5"));
        shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
        REQUIRE(c.pid_in_window("right", 5) > 0);
        run.signal(SIGTERM);
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        run.signal(SIGTERM);
        auto const result = run.wait(10);
        CHECK(result.exit == 130);
        CHECK(says(result, "\"right\" in window 5 of 1000"));
        CHECK(c.leftovers() == 0);
    }
}

TEST_CASE("resume: a later end, a scene that is no longer there, other directories")
{
    Case c(scene(", nap: 0.002", ""));
    shell::Background run(c.command({"--set", "time.end=0.5"}), c.log());
    REQUIRE(c.pid_in_window("left", 50) > 0);
    run.signal(SIGTERM);
    REQUIRE(run.wait(20).exit == 75);
    std::filesystem::remove(c.file());
    CHECK(c.resume({"--set", "time.end=1"}).exit == 0);
    CHECK(c.final_place("left") == whole("left"));
    CHECK(summary(c).at("windows") == 1000);
}

TEST_CASE("resume: a scene with other physics is refused")
{
    Case c(scene(", nap: 0.002", ""));
    shell::Background run(c.command(), c.log());
    REQUIRE(c.pid_in_window("left", 50) > 0);
    run.signal(SIGTERM);
    REQUIRE(run.wait(20).exit == 75);
    auto const result = c.resume({"--set", "time.window=0.002"});
    CHECK(result.exit == 5);
    CHECK(says(result, "its checkpoint is of another scene"));
    CHECK(c.resume().exit == 0);  // unharmed
    CHECK(c.final_place("left") == whole("left"));
}

TEST_CASE("resume: windows that were asked for are all stored, also when each of them is")
{
    for (int every : {1, 7}) {
        Case c(scene());
        auto const count = "checkpoint.windows=" + std::to_string(every);
        REQUIRE(c.run({"--set", "time.end=0.05", "--set", count, "--set", "checkpoint.keep=100"}).exit == 0);
        std::vector<std::int64_t> expected;
        for (std::int64_t window = every; window < 50; window += every) expected.push_back(window);
        CHECK(c.checkpoints() == expected);
    }
}

TEST_CASE("resume: a solver's config that has changed is told")
{
    Case c(scene());
    REQUIRE(c.run({"--set", "time.end=0.05", "--set", "checkpoint.windows=20"}).exit == 0);
    REQUIRE(c.resume({"--set", "time.end=0.1", "--set", "participants.left.config.steps=2"}).exit == 0);
    auto const text = summary(c).dump();
    CHECK(text.find("its config is not that of its checkpoint: \\\"participants.left.config.steps = 2") != text.npos);
    CHECK(text.find("right.config") == text.npos);
}

TEST_CASE("resume: no run, a run that goes on, and one that began anew")
{
    in_threads::Scratch scratch;
    auto const log = scratch.path() / "log";
    CHECK(shell::run({sluice_command, "resume", scratch.path() / "none"}, log).exit == 7);
    CHECK(says(shell::run({sluice_command, "resume", scratch.path()}, log), "no .sluice/run.json"));
    Case c(scene(", nap: 0.002", "", "checkpoint: {windows: 20}\n"));
    shell::Background run(c.command(), c.log());
    REQUIRE(c.pid_in_window("left", 50) > 0);
    auto const second = shell::run(c.resuming(), log);
    CHECK(second.exit == 5);
    CHECK(says(second, "another run is going on there"));
    run.signal(SIGKILL);
    run.wait(10);
    for (int tries = 0; tries < 200 && c.leftovers() > 0; ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    REQUIRE(!c.checkpoints().empty());
    // in the same directory: no checkpoint of the old run counts
    std::filesystem::remove(sluice::status_file(c.out(), "left"));
    shell::Background anew(c.command({"--set", "checkpoint.windows=900"}), c.log());
    REQUIRE(c.pid_in_window("left", 5) > 0);
    CHECK(c.checkpoints().empty());
}

namespace {

//! `right` consists of two processes that do the same; what is exchanged has no place, so each gets all of it.
std::string two_ranks(std::string const& more = "")
{
    auto text = scene(more, more);
    text.replace(text.find("{columns"), 1, "{meshless: true, ");
    text.replace(text.find("right: {"), 8, "right: {ranks: 2, ");
    return text;
}

}  // namespace

TEST_CASE("launch: several processes of a participant, each with its page, in one entry of the summary")
{
    for (auto const transport : {"zmq", "mpi"}) {
        CAPTURE(transport);
        Case c(two_ranks());
        auto const result = c.run({"--set", std::string("transport=") + transport});
        CHECK(result.exit == 0);
        auto const said = summary(c);
        REQUIRE(said.at("participants").size() == 2);
        auto const& right = said.at("participants")[1];
        CHECK(right.at("name") == "right");
        REQUIRE(right.at("ranks").size() == 2);
        CHECK(right.at("ranks")[1].at("name") == "right:1");
        CHECK(right.at("bytes_sent").get<int>() ==
              right.at("ranks")[0].at("bytes_sent").get<int>() + right.at("ranks")[1].at("bytes_sent").get<int>());
        CHECK(c.final_place("left") == whole("left"));
        CHECK(c.final_place("right:1") == whole("right"));
    }
}

TEST_CASE("launch: of several processes one that dies is named with its rank")
{
    for (auto const transport : {"zmq", "mpi"}) {
        CAPTURE(transport);
        Case c(two_ranks(", nap: 0.01"));
        shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
        int const pid = c.pid_in_window("right:1", 5);
        REQUIRE(pid > 0);
        ::kill(pid, SIGKILL);
        auto const result = run.wait(10);
        CHECK(result.exit == 3);
        CHECK(says(result, "participant \"right:1\" was ended by signal 9"));
        CHECK(c.leftovers() == 0);
    }
}
