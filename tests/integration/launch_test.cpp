// The launcher and participants as processes: results, failures, signals. Times are bounds of the design (a dead
// participant ends the run within 2 s), not benchmarks.

#include <doctest/doctest.h>

#include "tests/support/launched.hpp"
#include "tests/support/ports.hpp"

using namespace launched;

TEST_CASE("launch: zmq and mpi give the same bits, and so does starting by hand in either order")
{
    Case zmq(scene()), mpi(scene());
    REQUIRE(zmq.run().exit == 0);
    REQUIRE(mpi.run({"--set", "transport=mpi"}).exit == 0);
    CHECK(summary(zmq).at("windows") == 1000);
    CHECK(summary(zmq).at("exit") == 0);
    for (auto const name : {"left", "right"}) CHECK(zmq.final_place(name) == mpi.final_place(name));
    for (bool left_first : {true, false}) {
        Case hand(scene());
        shell::Background first(hand.by_hand(left_first ? "left" : "right"), hand.scratch.path() / "first");
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        CHECK(shell::run(hand.by_hand(left_first ? "right" : "left"), hand.log()).exit == 0);
        CHECK(first.wait(10).exit == 0);
        CHECK(hand.final_place("left") == zmq.final_place("left"));
    }
}

TEST_CASE("launch: over tcp on loopback")
{
    Case c(scene("", "", "address: tcp://127.0.0.1:" + std::to_string(ports::take()) + "\n"));
    CHECK(c.run().exit == 0);
}

TEST_CASE("launch: a participant that dies ends the run within 2 s, named with its window and its exit")
{
    struct Death
    {
        std::string fault, says;
        int exit;
    };
    Death const deaths[] = {{"crash", "participant \"right\" was ended by signal 6", 3},
                            {"exit", "participant \"right\" ended with exit code 9", 3},
                            {"throw", "participant \"right\" stopped in window 300 of 1000 (t = 0.3 s), process ", 6},
                            {"vanish", "participant \"right\" ended", 3},
                            {"leave", "participant \"right\" left its loop over the windows before their end", 70},
                            {"nan", "place.place of id 1 is not finite in frame 301", 6}};
    for (auto const transport : {"zmq", "mpi"})
        for (Death const& death : deaths) {
            CAPTURE(transport);
            CAPTURE(death.fault);
            Case c(scene("", ", fault: " + death.fault + ", fault_window: 300"));
            auto const result = c.run({"--set", std::string("transport=") + transport});
            CHECK(result.exit == death.exit);
            CHECK(says(result, death.says));
            CHECK(says(result, "window 300 of 1000"));
            CHECK(summary(c).at("exit") == death.exit);
            CHECK(c.leftovers() == 0);
        }
}

TEST_CASE("launch: kill -9 of a participant at work ends everybody within 2 s")
{
    for (auto const transport : {"zmq", "mpi"})
        for (auto const victim : {"left", "right"}) {
            CAPTURE(transport);
            CAPTURE(victim);
            Case c(scene(", nap: 0.01", ", nap: 0.01"));
            shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
            int const pid = c.pid_in_window(victim, 5);
            REQUIRE(pid > 0);
            ::kill(pid, SIGKILL);
            auto const result = run.wait(10);
            CHECK(result.exit == 3);
            CHECK(result.seconds < 2.0);
            CHECK(says(result, std::string("participant \"") + victim + "\" was ended by signal 9"));
            CHECK(c.leftovers() == 0);
        }
}

TEST_CASE("launch: without a launcher a survivor ends within 2 s and names the dead one")
{
    for (auto const victim : {"left", "right"}) {
        auto const survivor = std::string(victim) == "left" ? "right" : "left";
        Case c(scene(", nap: 0.01", ", nap: 0.01"));
        shell::Background dying(c.by_hand(victim), c.scratch.path() / "dying");
        shell::Background surviving(c.by_hand(survivor), c.log());
        REQUIRE(c.pid_in_window(victim, 5) == dying.pid());
        dying.signal(SIGKILL);
        auto const result = surviving.wait(10);
        CHECK(result.exit == 3);
        CHECK(result.seconds < 2.0);
        CHECK(says(result, std::string("participant \"") + victim + "\" is lost: "));
    }
}

TEST_CASE("launch: a stopped process counts as dead after the time of silence")
{
    Case c(scene(", nap: 0.01", ", nap: 0.01", "timeouts: {silence: 1}\n"));
    shell::Background stopped(c.by_hand("left"), c.scratch.path() / "stopped");
    shell::Background surviving(c.by_hand("right"), c.log());
    REQUIRE(c.pid_in_window("left", 5) == stopped.pid());
    stopped.signal(SIGSTOP);
    auto const result = surviving.wait(10);
    CHECK(result.exit == 3);
    CHECK(result.seconds < 3.0);
    stopped.signal(SIGCONT);
}

TEST_CASE("launch: a partner that never comes is named, with the command that starts it")
{
    Case c(scene("", "", "timeouts: {connect: 1}\n"));
    auto const result = shell::run(c.by_hand("left"), c.log());
    CHECK(result.exit == 4);
    CHECK(says(result, "\"right\" did not come within 1 s. Start with:"));
    CHECK(says(result, "--as right --out " + c.out()));
}

TEST_CASE("launch: partners with different scenes are told what differs")
{
    Case c(scene());
    auto other = c.by_hand("right");
    other.insert(other.end(), {"--set", "time.end=0.5"});
    shell::Background left(c.by_hand("left"), c.scratch.path() / "left");
    auto const result = shell::run(other, c.log());
    auto const first = left.wait(10);
    CHECK((result.exit == 5 || first.exit == 5));  // who sees it first says so; the other one is told
    for (auto const& side : {result, first}) {
        CHECK((side.exit == 5 || side.exit == 3));
        CHECK(says(side, "time.end = 0.5"));
        CHECK(says(side, "time.end = 1"));
    }
}

TEST_CASE("launch: no participant outlives a launcher that is killed")
{
    for (auto const transport : {"zmq", "mpi"}) {
        CAPTURE(transport);
        Case c(scene(", nap: 0.01", ", nap: 0.01"));
        shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
        REQUIRE(c.pid_in_window("left", 5) > 0);
        run.signal(SIGKILL);
        run.wait(10);
        for (int tries = 0; tries < 200 && c.leftovers() > 0; ++tries)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        CHECK(c.leftovers() == 0);
    }
}

TEST_CASE("launch: a second participant of a name is refused and the first one is unharmed")
{
    Case c(scene(", nap: 0.001", ""));
    shell::Background first(c.command(), c.log());
    REQUIRE(c.pid_in_window("left", 5) > 0);
    auto const second = shell::run(c.by_hand("left"), c.scratch.path() / "second");
    CHECK(second.exit == 5);
    CHECK(says(second, "participant \"left\" already runs in " + c.out()));
    auto check = c.by_hand("left");
    check.push_back("--check");
    CHECK(shell::run(check, c.scratch.path() / "check").exit == 0);
    CHECK(first.wait(60).exit == 0);
}

TEST_CASE("launch: a process that is no participant is not taken for one that did its work")
{
    Case c("sluice: 1\ntime: {end: 1, window: 0.1}\nparticipants: {a: {command: /bin/true}}\n");
    auto const result = c.run();
    CHECK(result.exit == 3);
    CHECK(says(result, "participant \"a\" ended with exit code 0 before its first window"));
}

TEST_CASE("check: a name that is a path starts nothing and writes nothing")
{
    in_threads::Scratch victim;
    auto const precious = victim.path() / "precious";
    std::ofstream(precious) << "kept";
    Case c("sluice: 1\ntime: {end: 1, window: 0.1}\nparticipants:\n  " + precious.string() + ": {command: " + toy +
           "}\n");
    auto const result = shell::run({sluice_command, "check", c.file()}, c.log());
    CHECK(result.exit == 2);
    CHECK(says(result, ":4:3: participants." + precious.string() + ": not a name"));
    CHECK(shell::slurp(precious) == "kept");
    CHECK(shell::run({toy, c.file(), "--as", precious, "--out", c.out()}, c.log()).exit == 2);
    CHECK(std::distance(std::filesystem::directory_iterator(victim.path()), {}) == 1);
}

TEST_CASE("check: a line of 400 kB and text that is not UTF-8 are mistakes like others")
{
    Case c("sluice: 1\ntime: {end: " + std::string(400'000, 'x') + "}\nparticipants: {a: {command: " + toy + "}}\n");
    CHECK(shell::run({sluice_command, "check", c.file()}, c.log()).exit == 2);
    Case latin(scene("", "", "title: \"\xe9\"\n"));
    auto const result = latin.run();
    CHECK(result.exit == 2);
    CHECK(says(result, latin.file() + ":4:1: not UTF-8"));
}

TEST_CASE("launch: a second run in the same directory is refused, the first one is unharmed")
{
    Case c(scene(", nap: 0.001", ""));
    shell::Background first(c.command(), c.log());
    REQUIRE(c.pid_in_window("left", 5) > 0);
    auto const second = shell::run(c.command(), c.scratch.path() / "second");
    CHECK(second.exit == 5);
    CHECK(says(second, "another run is going on there"));
    CHECK(first.wait(60).exit == 0);
}

TEST_CASE("check: mistakes of the scene and of both solvers at once, by line")
{
    auto text = scene(", mas: 3", ", steps: 0");
    text.replace(text.find("lag: 1"), 6, "lag: 3");
    Case c(text);
    auto const result = shell::run({sluice_command, "check", c.file()}, c.log());
    CHECK(result.exit == 2);
    auto const left = result.output.find(c.file() + ":5:"), right = result.output.find(c.file() + ":6:"),
               edge = result.output.find(c.file() + ":9:");
    CHECK(left < right);
    CHECK(right < edge);
    CHECK(edge != std::string::npos);
    CHECK(says(result, "participants.left.config.mas is not a key"));
    CHECK(says(result, "Did you mean mass?"));
    CHECK(says(result, "participants.right.config.steps = 0 (must be >= 1)"));
    CHECK(c.run().exit == 2);  // run checks first
}

TEST_CASE("check: a solver that is not there, with the nearest name")
{
    Case c("sluice: 1\ntime: {end: 1}\nparticipants: {a: {solver: demm}}\n");
    auto const result = shell::run({sluice_command, "check", c.file()}, c.log());
    CHECK(result.exit == 2);
    CHECK(says(result, c.file() + ":3:20: participants.a.solver = demm: no such executable"));
    CHECK(says(result, "Did you mean dem?"));
}

TEST_CASE("check: a solver that was left out of the build names the package, whatever else has its name")
{
    Case c("sluice: 1\ntime: {end: 1}\nparticipants: {a: {solver: sh}}\n");
    auto const home = c.scratch.path() / "home";  // of a sluice that was built without a solver `sh`
    std::filesystem::create_directories(home / "bin");
    std::filesystem::create_directories(home / "share/sluice");
    std::filesystem::copy(sluice_command, home / "bin/sluice");
    std::ofstream(home / "share/sluice/left_out") << "sh libsh-dev\n";
    auto const result = shell::run({home / "bin/sluice", "check", c.file()}, c.log());
    CHECK(result.exit == 2);
    CHECK(says(result, c.file() + ":3:20: participants.a.solver = sh: was left out when this sluice was built"));
    CHECK(says(result, "the package libsh-dev. Install it, then build again."));
    std::filesystem::create_symlink("/bin/true", home / "bin/sh");  // it is there after all
    CHECK(!says(shell::run({home / "bin/sluice", "check", c.file()}, c.log()), "left out"));
}

TEST_CASE("check: data that a solver cannot send is a mistake of the scene")
{
    auto text = scene();
    text.replace(text.find("place: {columns: {place: {unit: m}}}"), 36,
                 "place: {columns: {place: {unit: m}}}, x: {columns: {x: {unit: m}}}");
    text += "  - {from: left, to: right, data: x}\n";
    Case c(text);
    auto const result = shell::run({sluice_command, "check", c.file()}, c.log());
    CHECK(result.exit == 2);
    CHECK(says(result, "couplings[2].data = x: \"left\" cannot send it (sends: place)"));
}

TEST_CASE("graph: DOT to standard output, a picture to a file")
{
    Case c(scene());
    auto const dot = shell::run({sluice_command, "graph", c.file()}, c.log());
    CHECK(dot.exit == 0);
    CHECK(says(dot, "\"left\" -> \"right\""));
    auto const picture = c.scratch.path() / "graph.svg";
    CHECK(shell::run({sluice_command, "graph", c.file(), "-o", picture}, c.log()).exit == 0);
    CHECK(shell::slurp(picture).find("<svg") != std::string::npos);
}

TEST_CASE("command line: a misspelt command gets the nearest one and exit code 2")
{
    in_threads::Scratch scratch;
    auto const result = shell::run({sluice_command, "chekc", "x"}, scratch.path() / "log");
    CHECK(result.exit == 2);
    CHECK(says(result, "Did you mean check?"));
    CHECK(shell::run({sluice_command, "run", "/none.yaml"}, scratch.path() / "log").exit == 2);
}

TEST_CASE("record and replay: one participant alone against what the others said gives the same bits")
{
    auto const final_place = [](std::string const& out, std::string const& name) {
        return nlohmann::json::parse(shell::slurp(out + "/.sluice/" + name + ".json"))
            .at("facts")
            .at("final place [m]")
            .get<double>();
    };
    Case c(scene());
    std::vector<std::string> const record{sluice_command, "record",      c.file(), "--out",
                                          c.out(),        "--no-report", "--quiet"};
    REQUIRE(shell::run(record, c.log()).exit == 0);
    for (std::string const name : {"left", "right"}) {
        auto const out = (c.scratch.path() / ("replay-" + name)).string();
        auto const result =
            shell::run({sluice_command, "replay", c.out(), "--only", name, "--out", out, "--no-report"}, c.log());
        CAPTURE(result.output);
        CHECK(result.exit == 0);
        CHECK(final_place(out, name) == final_place(c.out(), name));
    }
    auto const longer = shell::run({sluice_command, "replay", c.out(), "--only", "left", "--set", "time.end=2", "--out",
                                    c.out() + "-longer", "--no-report"},
                                   c.log());
    CHECK(longer.exit == 7);
    CHECK(says(longer, "ends before frame 1001 of place"));
    auto const unknown = shell::run({sluice_command, "replay", c.out(), "--only", "lefft"}, c.log());
    CHECK(unknown.exit == 2);
    CHECK(says(unknown, "Did you mean left?"));
}
