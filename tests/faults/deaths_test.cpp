// Rows F1, F2, F4 to F6, F13, F14, F17, F18, F20 of the fault matrix: processes that die, hang, never come, come twice.

#include <sys/resource.h>

#include <random>

#include "tests/support/launched.hpp"
#include "tests/support/repeats.hpp"

using namespace launched;
using sluice::test::repeats;

namespace {

std::string const short_run = "time.end=0.3";  // 300 windows

//! A moment of a run of 1000 windows of 1 ms and more: from before its first window to about its end.
std::chrono::milliseconds random_moment()
{
    static std::mt19937 random(20240711);
    return std::chrono::milliseconds(std::uniform_int_distribution<int>(0, 1400)(random));
}

int pid_of(Case const& c, std::string const& name)
{
    auto const file = sluice::status_file(c.out(), name);
    std::error_code none;
    if (std::filesystem::file_size(file, none) != sizeof(sluice::StatusPage) || none) return 0;
    return sluice::MappedStatus(file, sluice::MappedStatus::Mode::open)->pid;
}

//! Nothing is left, and a run in the same directory works.
void check_clean(Case const& c)
{
    CHECK(c.leftovers() == 0);
    CHECK(shell::run(c.command({"--set", "time.end=0.01"}), c.log()).exit == 0);
}

bool names_all(shell::Result const& result, std::string const& participant)
{
    return says(result, "participant \"" + participant + "\"") &&
           (says(result, "in window ") ? says(result, " (t = ") : says(result, "before its first window"));
}

}  // namespace

TEST_CASE("F1: kill -9 of a participant at a random moment")
{
    int died = 0;
    for (int round = 0; round < repeats(5); ++round) {
        std::string const victim = round % 2 ? "left" : "right";
        Case c(scene(", nap: 0.001", ""));
        shell::Background run(c.command(), c.log());
        std::this_thread::sleep_for(random_moment());
        int const pid = pid_of(c, victim);
        if (pid > 0) ::kill(pid, SIGKILL);
        auto const result = run.wait(20);
        if (result.exit == 0) continue;  // it was done before
        ++died;
        CHECK(result.exit == 3);
        CHECK(result.seconds < 3.0);
        CHECK(says(result, "was ended by signal 9"));
        CHECK(result.output.find("participant \"" + victim + "\"") == 0);  // the first line is the root cause
        CHECK(names_all(result, victim));
        if (round % 5 == 0) check_clean(c);
        CHECK(c.leftovers() == 0);
    }
    MESSAGE("F1: " << died << " of " << repeats(5) << " were killed at work; each was named, nothing was left");
}

TEST_CASE("F2: a participant that aborts, exits, throws: the end of its log is shown")
{
    for (int round = 0; round < repeats(1); ++round)
        for (std::string const fault : {"crash", "exit", "throw"}) {
            Case c(scene("", ", fault: " + fault + ", fault_window: 200"));
            auto const result = c.run({"--set", short_run});
            CHECK(result.exit == (fault == "throw" ? 6 : 3));
            CHECK(names_all(result, "right"));
            if (fault != "throw") CHECK(says(result, "right.log, ends with:"));
            check_clean(c);
        }
}

TEST_CASE("F4: a solver that never ends its window: the run ends after timeouts.window and says who computes")
{
    for (int round = 0; round < repeats(1); ++round) {
        Case c(scene("", ", fault: hang, fault_window: 200", "timeouts: {window: 2}\n"));
        auto const result = c.run({"--set", short_run});
        CHECK(result.exit == 4);
        CHECK(says(result, "a window takes longer than timeouts.window = 2 s: computing: \"right\" in window 200"));
        CHECK(says(result, "waiting for that: \"left\""));
        CHECK(c.leftovers() == 0);
    }
}

TEST_CASE("F5: wired so that each waits for the other: refused before anything starts")
{
    auto text = scene();
    text.replace(text.find(", lag: 1, predict: linear"), 25, "");
    Case c(text);
    auto const result = c.run();
    CHECK(result.exit == 2);
    CHECK(result.seconds < 1.0 + 60);  // no time-out had to pass
    CHECK(says(result, "left -> right -> left"));
}

TEST_CASE("F6: a partner never comes: named within timeouts.connect, with progress lines and next to no work")
{
    Case c(scene("", "", "timeouts: {connect: 6}\n"));
    rusage before = {}, after = {};
    ::getrusage(RUSAGE_CHILDREN, &before);
    auto const result = shell::run(c.by_hand("left"), c.log());
    ::getrusage(RUSAGE_CHILDREN, &after);
    auto const used = [](rusage const& r) {
        return static_cast<double>(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
               1e-6 * static_cast<double>(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
    };
    double const a_minute = (used(after) - used(before)) * 60 / 6;
    MESSAGE("F6: " << a_minute << " s of work a minute, the start included");
    CHECK(a_minute < 2.0);
    CHECK(result.exit == 4);
    CHECK(says(result, "left: waiting for \"right\""));
    CHECK(says(result, "\"right\" did not come within 6 s. Start with:"));
    check_clean(c);
}

TEST_CASE("F13: a second participant of a name, a second run: refused with the owner's process, the first unharmed")
{
    for (int round = 0; round < repeats(1); ++round) {
        Case c(scene(", nap: 0.002", ""));
        shell::Background first(c.command(), c.log());
        int const pid = c.pid_in_window("left", 5);
        REQUIRE(pid > 0);
        auto const twin = shell::run(c.by_hand("left"), c.scratch.path() / "twin");
        CHECK(twin.exit == 5);
        CHECK(says(twin, "(process " + std::to_string(pid) + ")"));
        auto const second = shell::run(c.command(), c.scratch.path() / "second");
        CHECK(second.exit == 5);
        CHECK(says(second, "(process " + std::to_string(first.pid()) + ")"));
        CHECK(first.wait(60).exit == 0);
        CHECK(std::isfinite(c.final_place("left")));
    }
}

TEST_CASE("F14: partners with different scenes: both print the key that differs, and both values")
{
    for (int round = 0; round < repeats(1); ++round) {
        Case c(scene());
        auto other = c.by_hand("right");
        other.insert(other.end(), {"--set", "time.end=0.5"});
        shell::Background left(c.by_hand("left"), c.scratch.path() / "left");
        auto const right = shell::run(other, c.log());
        auto const first = left.wait(20);
        for (auto const& side : {right, first}) {
            CHECK((side.exit == 5 || side.exit == 3));
            CHECK(says(side, "time.end = 0.5"));
            CHECK(says(side, "time.end = 1"));
        }
        CHECK((right.exit == 5 || first.exit == 5));
        check_clean(c);
    }
}

TEST_CASE("F17: SIGTERM or SIGINT to the launcher or a participant at a random moment")
{
    int stopped = 0;
    for (int round = 0; round < repeats(4); ++round) {
        Case c(scene(", nap: 0.001", ""));
        shell::Background run(c.command(), c.log());
        std::this_thread::sleep_for(random_moment());
        int const participant = pid_of(c, round % 2 ? "left" : "right");
        if (round % 4 < 2)
            run.signal(round % 4 == 0 ? SIGTERM : SIGINT);
        else if (participant > 0)
            ::kill(participant, SIGTERM);
        auto const result = run.wait(20);
        bool const early = result.exit == 130 || result.exit == 3 || result.exit == 143;  // before there were windows
        CHECK((result.exit == 0 || result.exit == 75 || early));
        CHECK(c.leftovers() == 0);
        if (result.exit != 75) continue;
        ++stopped;
        CHECK(c.checkpoints().size() == 1);
        CHECK(c.resume().exit == 0);
    }
    MESSAGE("F17: " << stopped << " of " << repeats(4) << " stopped with a checkpoint, each went on");
}

TEST_CASE("F18: SIGKILL of the launcher: its children end within 1 s")
{
    for (int round = 0; round < repeats(2); ++round) {
        Case c(scene(", nap: 0.002", ""));
        shell::Background run(c.command(), c.log());
        REQUIRE(c.pid_in_window("left", 5) > 0);
        run.signal(SIGKILL);
        run.wait(10);
        auto const begin = std::chrono::steady_clock::now();
        while (c.leftovers() > 0 && std::chrono::steady_clock::now() - begin < std::chrono::seconds(10))
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
        check_clean(c);
    }
}

TEST_CASE("F20: out of memory is said, with the participant's name")
{
    for (int round = 0; round < repeats(1); ++round) {
        Case c(scene("", ", fault: memory, fault_window: 200"));
        auto const result = c.run({"--set", short_run});
        CHECK(result.exit == 7);
        CHECK(names_all(result, "right"));
        CHECK(says(result, "out of memory"));
        check_clean(c);
    }
}
