// on-death: restart. A participant that dies is started again from the last checkpoint, the others go back in place,
// and the run ends with the bits of one in which nobody died.

#include "tests/support/launched.hpp"

using namespace launched;

namespace {

std::string const restart = "on-death: restart\ncheckpoint: {windows: 40}\n";

double whole(std::string const& name)
{
    static Case const c(scene());
    static int const exit = c.run().exit;
    REQUIRE(exit == 0);
    return c.final_place(name);
}

void check_whole(Case const& c, int restarts)
{
    CHECK(summary(c).value("restarts", 0) == restarts);
    for (auto const name : {"left", "right"}) CHECK(c.final_place(name) == whole(name));
    CHECK(c.leftovers() == 0);
}

}  // namespace

TEST_CASE("restart: kill -9 of either participant, and the run goes on to the same bits")
{
    for (auto const transport : {"zmq", "auto"})
        for (auto const victim : {"left", "right"}) {
            CAPTURE(transport);
            CAPTURE(victim);
            Case c(scene(", nap: 0.002", "", restart));
            shell::Background run(c.command({"--set", std::string("transport=") + transport}), c.log());
            int const pid = c.pid_in_window(victim, 100);
            int const other = c.pid_in_window(std::string(victim) == "left" ? "right" : "left", 100);
            REQUIRE(pid > 0);
            ::kill(pid, SIGKILL);
            auto const result = run.wait(60);
            CHECK(result.exit == 0);
            CHECK(says(result, std::string("participant \"") + victim + "\" was ended by signal 9"));
            CHECK(says(result, "started again, all go on from window"));
            check_whole(c, 1);
            auto const said = summary(c).at("participants")[std::string(victim) == "left" ? 1 : 0];
            CHECK(said.value("rollbacks", 0) == 1);  // in place: it is the same process
            CHECK(other > 0);
        }
}

TEST_CASE("restart: an implicit group goes back, between two iterations too, to the same bits")
{
    std::string const implicit = "implicit:\n  - {participants: [left, right], tolerance: 1e-10}\n";
    Case undisturbed(scene("", "", implicit));
    REQUIRE(undisturbed.run({"--set", "couplings.1.predict=none"}).exit == 0);
    for (auto const victim : {"left", "right"}) {
        CAPTURE(victim);
        Case c(scene(", nap: 0.002", "", restart + implicit));
        shell::Background run(c.command({"--set", "couplings.1.predict=none"}), c.log());
        int const pid = c.pid_in_window(victim, 100);
        REQUIRE(pid > 0);
        ::kill(pid, SIGKILL);
        CHECK(run.wait(60).exit == 0);
        CHECK(summary(c).value("restarts", 0) == 1);
        for (auto const name : {"left", "right"}) CHECK(c.final_place(name) == undisturbed.final_place(name));
        CHECK(c.leftovers() == 0);
    }
}

TEST_CASE("restart: what a participant does to itself")
{
    for (std::string const fault : {"crash", "exit", "throw", "vanish", "memory"}) {
        CAPTURE(fault);
        Case c(scene("", ", fault: " + fault + ", fault_window: 300", restart));
        auto const result = c.run();
        CHECK(result.exit == 0);
        check_whole(c, 1);
    }
}

TEST_CASE("restart: both at once, and one after the other")
{
    Case c(scene(", nap: 0.002", "", restart));
    shell::Background run(c.command(), c.log());
    int const left = c.pid_in_window("left", 100), right = c.pid_in_window("right", 100);
    REQUIRE(left > 0);
    REQUIRE(right > 0);
    ::kill(left, SIGKILL);
    ::kill(right, SIGKILL);
    int const again = c.pid_in_window("right", 300);
    REQUIRE(again > 0);
    CHECK(again != right);
    ::kill(again, SIGKILL);
    auto const result = run.wait(60);
    CHECK(result.exit == 0);
    check_whole(c, 3);
}

TEST_CASE("restart: a participant that dies again and again ends the run after three tries, with one message")
{
    Case c(scene("", ", fault: crash, fault_window: 300, fault_again: true", restart));
    auto const result = c.run();
    CHECK(result.exit == 3);
    CHECK(says(result, "participant \"right\" was ended by signal 6"));
    CHECK(says(result,
               "not started again: that was tried 3 times without coming to a new checkpoint (the last is "
               "that of window 281)"));
    CHECK(c.leftovers() == 0);
}

TEST_CASE("restart: without a solver's state, and before the first window, a death ends the run")
{
    Case c(scene("", ", keep: false, fault: crash, fault_window: 300", restart));
    auto const result = c.run();
    CHECK(result.exit == 3);
    CHECK(says(result, "not started again: there is no complete checkpoint yet"));
    Case early(scene("", ", fault: crash, fault_window: 0", restart));
    CHECK(early.run().exit == 3);
    CHECK(early.leftovers() == 0);
}

TEST_CASE("restart: started by hand, a survivor waits until its partner is there again")
{
    Case c(scene(", nap: 0.002", "", restart));
    shell::Background left(c.by_hand("left"), c.log());
    {
        shell::Background right(c.by_hand("right"), c.scratch.path() / "right");
        REQUIRE(c.pid_in_window("right", 100) == right.pid());
        right.signal(SIGKILL);
        right.wait(10);
    }
    auto again = c.by_hand("right");
    again.push_back("--resume");
    CHECK(shell::run(again, c.scratch.path() / "again").exit == 0);
    CHECK(left.wait(60).exit == 0);
    CHECK(c.final_place("left") == whole("left"));
    CHECK(c.final_place("right") == whole("right"));
}

TEST_CASE("restart: of several processes one dies")
{
    auto text = scene(", nap: 0.002", "", restart);
    text.replace(text.find("{columns"), 1, "{meshless: true, ");
    text.replace(text.find("right: {"), 8, "right: {ranks: 2, ");
    Case c(text);
    shell::Background run(c.command(), c.log());
    int const pid = c.pid_in_window("right:1", 100);
    REQUIRE(pid > 0);
    ::kill(pid, SIGKILL);
    auto const result = run.wait(60);
    CHECK(result.exit == 0);
    CHECK(says(result, "started again"));
    CHECK(c.final_place("left") == whole("left"));
    CHECK(c.final_place("right:0") == whole("right"));
    CHECK(c.final_place("right:1") == whole("right"));
    CHECK(c.leftovers() == 0);
}

TEST_CASE("restart: with transport mpi it is a mistake of the scene")
{
    Case c(scene("", "", restart));
    auto const result = c.run({"--set", "transport=mpi"});
    CHECK(result.exit == 2);
    CHECK(says(result, "on-death: restart contradicts transport: mpi"));
}
