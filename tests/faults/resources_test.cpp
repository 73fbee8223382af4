// Rows F21, F24 to F26 of the fault matrix: clocks, descriptors, ports, strangers, slow readers.

#include <random>

#include "tests/faults/matrix.hpp"
#include "tests/faults/strangers.hpp"
#include "tests/support/ports.hpp"

using namespace matrix;

TEST_CASE("F21: a wall clock that jumps an hour forth and back changes nothing")
{
    Case still(scene()), jumping(scene());
    REQUIRE(still.run().exit == 0);
    Row row("F21", "wall clock jumps an hour forth and back", {.brief = 1, .stated = 10});
    while (row.next()) {
        auto const result = bash(jumping, std::string("LD_PRELOAD=" JUMPING_CLOCK " ") + joined(jumping.command()));
        CHECK(result.exit == 0);
        CHECK(end_of(jumping) == end_of(still));
        CHECK(summary(jumping).at("wall_seconds").get<double>() < 600);
    }
}

TEST_CASE("F24: few descriptors: a run works with 32, and says so where it does not")
{
    int few = 0, enough = 0;
    {
        Row row("F24", "ulimit -n 8 to 32", {.brief = 3, .stated = 10});
        while (row.next()) {
            int const limit = row.repeats() > 3 ? 8 + 24 * row.round() / 9 : 8 + 12 * row.round();
            CAPTURE(limit);
            Case c(scene("", "", row.round() % 2 == 0 ? "" : "transport: zmq\n"));
            auto const result = bash(
                c, "ulimit -n " + std::to_string(limit) + "; exec " + joined(c.command({"--set", "time.end=0.05"})));
            CHECK((result.exit == 0 || result.exit == 7));
            if (result.exit == 7) CHECK(has(result.output, "ulimit -n"));
            (result.exit == 0 ? enough : few) += 1;
            CHECK(c.leftovers() == 0);
            check_starts_again(c);
        }
    }
    CHECK(few > 0);  // else this tries nothing
    MESSAGE("F24: too few in " << few << " runs, enough in " << enough);
}

TEST_CASE("F24: a port that is taken: the message names it and its owner")
{
    Row row("F24", "port taken", {.brief = 2, .stated = 10});
    while (row.next()) {
        int const base = ports::take();
        int const taken = tcp::listen("127.0.0.1", base + 1);  // of the pair (0, 1): base + 0 * 2 + 1
        Case port(scene("", "", "address: tcp://127.0.0.1:" + std::to_string(base) + "\n"));
        auto const refused = port.run({"--set", "time.end=0.05"});
        CHECK(refused.exit == 7);
        CHECK(says(refused, "port " + std::to_string(base + 1) + " is taken by process " + std::to_string(::getpid())));
        CHECK(port.leftovers() == 0);
        ::close(taken);
        CHECK(port.run({"--set", "time.end=0.05"}).exit == 0);
    }
}

namespace {

//! Of /proc/PID/status [B].
long memory_of(int pid, std::string const& key)
{
    std::istringstream in(shell::slurp("/proc/" + std::to_string(pid) + "/status"));
    long kilobytes = 0;
    for (std::string word; in >> word;)
        if (word == key + ":") in >> kilobytes;
    return kilobytes * 1024;
}

//! What strangers throw: noise of up to 100 kB, HTTP, greetings with what no participant says, lengths of 4 GiB.
std::string garbage(std::mt19937& random, int number)
{
    using namespace strangers;
    switch (number % 5) {
        case 0:
            return noise(random, random() % 100'000);
        case 1:
            return "GET /" + std::to_string(number) + " HTTP/1.1\r\nHost: x\r\n\r\n";
        case 2:
            return greeting("NULL") + std::string("\4\x19\5READY", 8) + std::string(17, '\0') + noise(random, 200);
        case 3:
            return greeting("PLAIN") + std::string("\4\x10\5HELLO\4left\4aaaa", 18) +
                   std::string("\0\x44SLUC\2\0\2\0", 10) + noise(random, 58);
        default:
            return greeting(number % 2 ? "PLAIN" : "NULL") + std::string("\x02\0\0\0\1\0\0\0\0", 9);
    }
}

}  // namespace

TEST_CASE("F25: 10 000 connections with garbage on the open port, before the other side comes and during the run")
{
    auto const whole = undisturbed("0.5");
    int const many = std::getenv("SLUICE_REPEATS") ? 10'000 : 1500;
    std::mt19937 random(25);
    Row row("F25", std::to_string(many) + " connections with garbage", {.brief = 1, .stated = 1});
    while (row.next()) {
        int const base = ports::take();
        Case c(
            scene(", nap: 0.01", "",
                  "transport: zmq\ntimeouts: {connect: 300}\naddress: tcp://127.0.0.1:" + std::to_string(base) + "\n"));
        auto words = c.by_hand("left");
        words.insert(words.end(), {"--set", "time.end=0.5"});
        shell::Background left(words, c.scratch.path() / "left");
        bool listens = false;
        for (int tries = 0; tries < 400 && !listens; ++tries) {
            listens = strangers::throw_at(base + 1, "");
            if (!listens) std::this_thread::sleep_for(milliseconds(50));
        }
        REQUIRE(listens);
        auto const before = memory_of(left.pid(), "VmRSS");
        int taken = 0, later = 0;
        for (int n = 0; n < many / 2; ++n) taken += strangers::throw_at(base + 1, garbage(random, n));
        CHECK(taken > many / 4);
        auto other = c.by_hand("right");
        other.insert(other.end(), {"--set", "time.end=0.5"});
        shell::Background right(other, c.log());
        for (int n = many / 2; n < many; n += 250) {  // they meet, and compute: then the door is shut
            std::vector<std::string> some;
            for (int k = 0; k < 250; ++k) some.push_back(garbage(random, n + k));
            later += strangers::throw_many(base + 1, some);
        }
        auto const after = memory_of(left.pid(), "VmHWM");
        MESSAGE("F25: of " << many << " connections " << taken << " were taken before the run and " << later
                           << " during it; the participant grew by " << (after - before) / 1'000'000 << " MB");
        CHECK(after > before);  // it still runs
        CHECK(after - before < 64'000'000);
        CHECK(left.wait(120).exit == 0);
        CHECK(right.wait(120).exit == 0);
        CHECK(end_of(c) == whole);
        CHECK(c.leftovers() == 0);
    }
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
    Row row("F26", "a reader 100 times slower", {.brief = 1, .stated = 5});
    while (row.next()) {
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
