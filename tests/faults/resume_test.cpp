// Row F23 of the fault matrix and the restart goals: cut anywhere, killed at any moment, gone on to the same bits.

#include "tests/faults/matrix.hpp"
#include "tests/support/repeats.hpp"

using namespace matrix;
using sluice::test::repeats;

namespace {

std::string text(std::string const& checkpoint, std::string const& more = "")
{
    return scene(", nap: 0.001", "", "checkpoint: {" + checkpoint + "}\n" + more);
}

void kill_at_random(Case const& c, shell::Background const& run, int longest_ms)
{
    auto& random = random_numbers();
    std::this_thread::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution<int>(0, longest_ms)(random)));
    int const who = std::uniform_int_distribution<int>(0, 2)(random);
    if (who == 2) return run.signal(SIGKILL);
    auto const file = sluice::status_file(c.out(), who ? "left" : "right");
    std::error_code none;
    if (std::filesystem::file_size(file, none) != sizeof(sluice::StatusPage) || none) return;
    int const pid = sluice::MappedStatus(file, sluice::MappedStatus::Mode::open)->pid;
    if (pid > 0) ::kill(pid, SIGKILL);
}

void wait_for_nobody(Case const& c)
{
    for (int tries = 0; tries < 500 && c.leftovers() > 0; ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    CHECK(c.leftovers() == 0);
}

}  // namespace

TEST_CASE("restart goals: cut at every window from 1 to 49 of 50, and gone on to the same bits")
{
    auto const whole = undisturbed("0.05");
    std::vector<std::string> transports{"auto"};
    if (repeats(1) > 1) transports = {"auto", "zmq", "mpi"};
    for (auto const& transport : transports) {
        int same = 0;
        for (int window = 1; window < 50; ++window) {
            CAPTURE(window);
            Case c(text("windows: " + std::to_string(window)));
            auto const end = std::to_string(0.001 * (window + 1));
            REQUIRE(c.run({"--set", "time.end=" + end, "--set", "transport=" + transport}).exit == 0);
            REQUIRE(c.checkpoints().front() == window);
            REQUIRE(c.resume({"--set", "time.end=0.05"}).exit == 0);
            CHECK(end_of(c) == whole);
            same += end_of(c) == whole;
        }
        MESSAGE("cut at every window over " << transport << ": " << same << " of 49 with the same bits");
    }
}

TEST_CASE("F23: kill -9 at a random moment of a run that writes a checkpoint at every window, and resume")
{
    auto const whole = undisturbed("0.2");
    int resumed = 0, cut = 0;
    Row row("F23", "kill -9 while checkpoints are written, resume", {.brief = 5, .stated = 500});
    while (row.next()) {
        Case c(text("windows: 1"));
        shell::Background run(c.command({"--set", "time.end=0.2"}), c.log());
        kill_at_random(c, run, 1500);
        int exit = run.wait(30).exit;
        wait_for_nobody(c);
        if (exit == 0) continue;  // it had ended before
        ++cut;
        if (c.checkpoints().empty()) {
            CHECK(c.resume().exit == 7);  // killed before the first one: said, and nothing is touched
            continue;
        }
        auto const result = c.resume();
        CHECK(result.exit == 0);
        CHECK(end_of(c) == whole);
        resumed += result.exit == 0 && end_of(c) == whole;
    }
    MESSAGE("F23: " << cut << " of " << row.repeats() << " were killed at work, " << resumed
                    << " of those that had a checkpoint went on to the same bits");
}

TEST_CASE("restart goals: kill -9 of a participant at random moments, restarted in place to the same bits")
{
    auto const whole = undisturbed("0.5");
    int restarts = 0, same = 0, refused = 0;
    for (int round = 0; round < repeats(3); ++round) {
        Case c(text("windows: 20", "on-death: restart\n"));
        shell::Background run(c.command({"--set", "time.end=0.5"}), c.log());
        for (int kills = 0; kills < 2; ++kills) {
            std::this_thread::sleep_for(
                std::chrono::milliseconds(std::uniform_int_distribution<int>(0, 700)(random_numbers())));
            auto const file = sluice::status_file(c.out(), (round + kills) % 2 ? "left" : "right");
            std::error_code none;
            if (std::filesystem::file_size(file, none) != sizeof(sluice::StatusPage) || none) continue;
            int const pid = sluice::MappedStatus(file, sluice::MappedStatus::Mode::open)->pid;
            if (pid > 0) ::kill(pid, SIGKILL);
        }
        auto const result = run.wait(90);
        CHECK(c.leftovers() == 0);
        if (result.exit == 3) {  // before the first checkpoint, or when somebody was already done
            CHECK(says(result, "not started again: "));
            ++refused;
            continue;
        }
        CHECK(result.exit == 0);
        CHECK(end_of(c) == whole);
        restarts += summary(c).value("restarts", 0);
        same += end_of(c) == whole;
    }
    MESSAGE("restarted in place: " << restarts << " restarts, " << same << " runs of " << repeats(3)
                                   << " with the same bits, " << refused
                                   << " ended: killed before the first checkpoint or after the end");
}
