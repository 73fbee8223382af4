// A participant on another host, started by the scene's `remote` words. The other host is a script here: it joins its
// arguments for a shell as ssh does, and what it starts is in a session of its own, so that no signal of ours reaches
// it.

#include "tests/support/launched.hpp"

using namespace launched;

namespace {

//! One participant, on an address of the block for documentation (RFC 5737), started through `far_ssh`.
struct Far : Case
{
    explicit Far(std::string const& config)
        : Case(
              "sluice: 1\ntime: {end: 1, window: 0.001}\nport: 6000\nsecurity: insecure\nparticipants:\n"
              "  far: {command: " STREAM_COMMAND ", host: 203.0.113.7, config: {" +
              config + "}}\n")
    {
        auto const script = scratch.path() / "far_ssh";
        std::ofstream(script) << "#!/bin/bash\necho \"$1 $2\" >>" << scratch.path().string()
                              << "/asked\nshift 2\nsetsid sh -c \"$*\" &\nwait $!\n";
        std::filesystem::permissions(script, std::filesystem::perms::owner_all);
        std::ofstream(file(), std::ios::app) << "remote: [" << script.string() << ", -q]\n";
    }
    std::string asked() const { return shell::slurp(scratch.path() / "asked"); }
};

}  // namespace

TEST_CASE("hosts: a participant on another host is started by the words of remote, and its end is the run's")
{
    Far c("points: 3");
    auto const result = c.run({"--set", "title=it's far"});
    CHECK(result.exit == 0);
    CHECK(c.asked() == "-q 203.0.113.7\n-q 203.0.113.7\n");  // what is there is looked at first
    CHECK(summary(c).at("windows") == 1000);
    CHECK(summary(c).at("title") == "it's far");
    Far dies("fault: exit, fault_window: 300");
    auto const died = dies.run();
    CHECK(died.exit == 3);
    CHECK(says(died, "participant \"far\" on 203.0.113.7 ended with exit code 9 in window 300 of 1000"));
}

TEST_CASE("hosts: what runs on another host ends when the launcher does")
{
    Far c("nap: 0.01");
    shell::Background run(c.command(), c.log());
    REQUIRE(c.pid_in_window("far", 5) > 0);
    run.signal(SIGKILL);
    run.wait(10);
    for (int tries = 0; tries < 500 && c.leftovers() > 0; ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    CHECK(c.leftovers() == 0);
}
