// Rows F15, F16, F21, F24, F26 of the fault matrix: disks, clocks, descriptors, ports, slow readers.

#include <arpa/inet.h>
#include <sys/socket.h>

#include "tests/support/launched.hpp"
#include "tests/support/repeats.hpp"

using namespace launched;
using sluice::test::repeats;

namespace {

shell::Result bash(Case const& c, std::string const& script)
{
    return shell::run({"/bin/bash", "-c", script}, c.log());
}

std::string joined(std::vector<std::string> const& words)
{
    std::string text;
    for (auto const& word : words) text += "'" + word + "' ";
    return text;
}

}  // namespace

TEST_CASE("F15: a disk that is full when a checkpoint is written: said, and the checkpoint before stays valid")
{
    Case c(scene(", nap: 0.005", "", "checkpoint: {windows: 20}\n"));
    if (shell::run({"/usr/bin/unshare", "-rm", "/bin/true"}, c.log()).exit != 0) {
        MESSAGE("F15: not run: this system lets nobody mount a small disk of their own (unshare -rm)");
        return;
    }
    for (int round = 0; round < repeats(1); ++round) {
        // Fills the disk from the 60th window on; what is then on it is copied away, to be resumed with room.
        auto const disk = c.scratch.path().string() + "/disk", saved = c.scratch.path().string() + "/saved";
        auto words = c.command();
        words[4] = disk + "/run";
        auto const result = bash(c, "mkdir -p " + disk + "; rm -rf " + saved +
                                        "; unshare -rm /bin/bash -c \"mount -t tmpfs -o size=2m none " + disk + "; " +
                                        joined(words) + " & while ! ls " + disk +
                                        "/run/checkpoints/60/manifest.json; do sleep 0.01; done 2>/dev/null; "
                                        "cat /dev/zero >" +
                                        disk + "/full; wait \\$!; code=\\$?; rm " + disk + "/full; cp -r " + disk +
                                        "/run " + saved + "; exit \\$code\" 2>&1");
        CHECK(result.exit == 7);
        CHECK(says(result, "No space left on device"));
        CHECK(says(result, "participant \""));
        auto const resumed = shell::run({sluice_command, "resume", saved, "--no-report", "--quiet"}, c.log());
        CHECK(resumed.exit == 0);
    }
}

TEST_CASE("F16: the directory for checkpoints is taken away, or cannot be written to")
{
    for (int round = 0; round < repeats(1); ++round) {
        Case c(scene(", nap: 0.002", "", "checkpoint: {windows: 20}\n"));
        shell::Background run(c.command(), c.log());
        REQUIRE(c.pid_in_window("left", 50) > 0);
        std::filesystem::rename(c.out() + "/checkpoints", c.out() + "/elsewhere");
        auto const result = run.wait(20);
        CHECK(result.exit == 7);
        CHECK(says(result, c.out() + "/checkpoints"));
        CHECK(says(result, "in window "));
        CHECK(c.leftovers() == 0);
        std::filesystem::rename(c.out() + "/elsewhere", c.out() + "/checkpoints");
        CHECK(c.resume().exit == 0);
    }
    Case file(scene());
    std::ofstream(file.out()) << "a file where the directory should be";
    auto const result = file.run();
    CHECK(result.exit == 7);
    CHECK(says(result, file.out()));
}

TEST_CASE("F21: a wall clock that jumps an hour forth and back changes nothing")
{
    Case still(scene()), jumping(scene());
    REQUIRE(still.run().exit == 0);
    for (int round = 0; round < repeats(1); ++round) {
        auto const result = bash(jumping, std::string("LD_PRELOAD=" JUMPING_CLOCK " ") + joined(jumping.command()));
        CHECK(result.exit == 0);
        CHECK(jumping.final_place("left") == still.final_place("left"));
        CHECK(summary(jumping).at("wall_seconds").get<double>() < 600);
    }
}

TEST_CASE("F24: no descriptors left, a port that is taken: the message names the limit and the port")
{
    Case few(scene());
    auto const result = bash(few, "ulimit -n 12; exec " + joined(few.by_hand("left")));
    CHECK(result.exit == 7);
    CHECK((result.output.find("ulimit -n") != std::string::npos ||
           result.output.find("Too many open files") != std::string::npos));
    int const base = 21'000 + ::getpid() % 10'000;
    int const taken = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(base + 1));  // of the pair (0, 1): base + 0 * 2 + 1
    REQUIRE(::bind(taken, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(taken, 1) == 0);
    Case port(scene("", "", "address: tcp://127.0.0.1:" + std::to_string(base) + "\n"));
    auto const refused = port.run();
    CHECK(refused.exit == 7);
    CHECK(says(refused, std::to_string(base + 1)));
    CHECK(port.leftovers() == 0);
    ::close(taken);
    CHECK(port.run().exit == 0);
}

TEST_CASE("F26: a reader that is 100 times slower: nothing is lost, the sender's memory stays bounded")
{
    std::string const text =
        "sluice: 1\ntime: {end: 0.2, window: 0.001}\ndata: {place: {columns: {place: {unit: m}}}}\nparticipants:\n"
        "  fast: {command: " STREAM_COMMAND
        ", config: {points: 100000}}\n"
        "  slow: {command: " STREAM_COMMAND
        ", config: {nap: 0.01}}\n"
        "couplings: [{from: fast, to: slow, data: place}]\n";
    for (int round = 0; round < repeats(1); ++round) {
        Case c(text);
        auto const result = c.run();
        CHECK(result.exit == 0);
        auto const said = summary(c).at("participants");
        CHECK(said[1].at("facts").at("sum") == 200 * 201 / 2);  // frames 1 to 200, each once
        double const memory = said[0].at("facts").at("memory [kB]");
        MESSAGE("F26: the sender used " << memory << " kB; 200 frames of 1600 kB would be 320000 kB");
        CHECK(memory < 150'000);
    }
}
