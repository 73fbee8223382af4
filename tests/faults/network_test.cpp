// Rows F7 to F12 of the fault matrix, with whole runs: two executables started by hand, as on two hosts, whose one
// connection leads through a proxy that holds back, delays, cuts or damages it. With iptables: two_hosts_test.sh.

#include "tests/faults/matrix.hpp"
#include "tests/support/ports.hpp"
#include "tests/support/tcp_proxy.hpp"

using namespace matrix;

namespace {

//! Two participants and the network between them.
struct Apart
{
    explicit Apart(std::string const& text_without_transport, std::vector<std::string> names = {"left", "right"},
                   std::string const& program = toy)
        : port(ports::take()),
          proxy("127.0.0.2", "127.0.0.1", port + 1),
          c(with_address(text_without_transport, port)),
          names_(std::move(names)),
          program_(program)
    {
        for (std::size_t side : {0u, 1u}) runs.push_back(std::make_unique<shell::Background>(words(side), log(side)));
    }

    //! Both are at work in a window of at least this number.
    bool at_work(std::int64_t window) const
    {
        return c.pid_in_window(names_[0], window) > 0 && c.pid_in_window(names_[1], window) > 0;
    }
    std::vector<shell::Result> wait(double seconds = 60) { return {runs[0]->wait(seconds), runs[1]->wait(seconds)}; }

    //! The command line of one side.
    std::vector<std::string> words(std::size_t side) const
    {
        std::vector<std::string> all{"/usr/bin/env",
                                     "LD_PRELOAD=" REDIRECTED,
                                     "SLUICE_REDIRECT=" + std::to_string(port + 1),
                                     program_,
                                     c.file(),
                                     "--as",
                                     names_[side],
                                     "--out",
                                     c.out()};
        return all;
    }

    int port;
    tcp::Proxy proxy;
    Case c;
    std::vector<std::unique_ptr<shell::Background>> runs;

 private:
    static std::string with_address(std::string text, int port)
    {
        auto const line = "transport: zmq\naddress: tcp://127.0.0.1:" + std::to_string(port) + "\nparticipants:\n";
        return text.replace(text.find("participants:\n"), 14, line);
    }
    std::filesystem::path log(std::size_t side) const { return c.scratch.path() / ("output_" + names_[side]); }

    std::vector<std::string> names_;
    std::string program_;
};

std::string const naps = ", nap: 0.002";

//! Both end, each names the other; nothing is left, a checkpoint is there, the next start works.
void check_both_lost(Apart& a, std::string const& cause, double limit, Row& row)
{
    auto const begin = std::chrono::steady_clock::now();
    auto const results = a.wait();
    row.took(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), limit);
    for (std::size_t side : {0u, 1u}) {
        check_fatal(a.c, results[side], 3, side == 0 ? "right" : "left", "is lost: ");
        if (!cause.empty()) CHECK(has(first_line(results[side]), cause));
    }
    REQUIRE(!a.c.checkpoints().empty());
    a.proxy.hold = a.proxy.hold_back = false;
    check_resume_by_hand(a.c, a.words(0), a.words(1));
}

void check_same_bits(Apart& a, std::pair<double, double> const& whole)
{
    for (auto const& result : a.wait(120)) CHECK_MESSAGE(result.exit == 0, result.output);
    CHECK(end_of(a.c) == whole);
    CHECK(a.c.leftovers() == 0);
}

std::string short_run(std::string const& end)
{
    auto text = scene(naps, "", silence + "checkpoint: {windows: 20}\n");
    return text.replace(text.find("end: 1,"), 7, "end: " + end + ",");
}

}  // namespace

TEST_CASE("F7: nothing passes for 1 s, less than the silence allowed: the same bits")
{
    auto const whole = undisturbed("0.3");
    Row row("F7", "partition of 1 s between two processes", {.brief = 2, .stated = 50});
    while (row.next()) {
        Apart a(short_run("0.3"));
        REQUIRE(a.at_work(10));
        std::this_thread::sleep_for(random_time(100));
        a.proxy.hold = true;
        std::this_thread::sleep_for(std::chrono::seconds(1));
        a.proxy.hold = false;
        check_same_bits(a, whole);
        CHECK(a.proxy.connections == 1);
    }
}

TEST_CASE("F8: nothing passes for longer than the silence allowed: both sides end, neither goes on alone")
{
    Row row("F8", "partition, both sides", {.brief = 2, .stated = 50});
    while (row.next()) {
        Apart a(short_run("0.4"));
        REQUIRE(a.at_work(30));
        std::this_thread::sleep_for(random_time(100));
        a.proxy.hold = true;
        check_both_lost(a, "no heartbeat for 2 s", 2.0 + 1.0, row);
    }
}

TEST_CASE("F9: half open, nothing comes back on a connection that stays: both sides end")
{
    Row row("F9", "half-open connection", {.brief = 2, .stated = 50});
    while (row.next()) {
        Apart a(short_run("0.4"));
        REQUIRE(a.at_work(30));
        std::this_thread::sleep_for(random_time(100));
        a.proxy.hold_back = true;
        check_both_lost(a, "", 2.0 + 1.0, row);
    }
}

TEST_CASE("F10: a slow and uneven network changes no bit and raises no alarm")
{
    auto const whole = undisturbed("0.05");
    {
        Row row("F10", "delay of 50 +- 20 ms", {.brief = 1, .stated = 20});
        while (row.next()) {
            Apart a(short_run("0.05"));
            a.proxy.delay = 50;
            a.proxy.jitter = 20;
            check_same_bits(a, whole);
            CHECK(a.proxy.connections == 1);
        }
    }
    Row row("F10", "1 Mbit/s, frames of 16 kB", {.brief = 1, .stated = 20});
    while (row.next()) {
        Apart a(stream_scene("points: 2000", "", silence, "0.02"), {"from", "to"}, STREAM_COMMAND);
        a.proxy.chunk = 625;  // every 5 ms
        for (auto const& result : a.wait(120)) CHECK_MESSAGE(result.exit == 0, result.output);
        auto const said = nlohmann::json::parse(shell::slurp(a.c.out() + "/.sluice/to.json"));
        CHECK(said.at("facts").at("sum") == 20 * 21 / 2);              // frames 1 to 20, each once
        CHECK(said.at("wall_seconds") > 0.5 * 20 * 2000 * 8 / 125e3);  // else it was no slow network
        CHECK(a.c.leftovers() == 0);
    }
}

TEST_CASE("F11: a connection is reset in the middle of a frame: both sides end")
{
    Row row("F11", "RST mid-frame", {.brief = 2, .stated = 50});
    while (row.next()) {
        Apart a(stream_scene("points: 200000, nap: 0.01", "", silence + "checkpoint: {windows: 5}\n", "0.1"),
                {"from", "to"}, STREAM_COMMAND);
        REQUIRE(a.at_work(12));
        std::this_thread::sleep_for(random_time(50));
        a.proxy.cut_inside = true;
        auto const begin = std::chrono::steady_clock::now();
        auto const results = a.wait();
        row.took(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 1.0);
        CHECK(!a.proxy.cut_inside);
        check_fatal(a.c, results[0], 3, "to", "its connection ended");
        check_fatal(a.c, results[1], 3, "from", "its connection ended");
        REQUIRE(!a.c.checkpoints().empty());
        check_resume_by_hand(a.c, a.words(0), a.words(1));
    }
}

TEST_CASE("F12: one bit of a run's frames is flipped behind TCP's checksum: the run ends, and says what came from whom")
{
    {
        Row row("F12", "a flipped bit ends a run", {.brief = 3, .stated = 100});
        while (row.next()) {
            Apart a(short_run("0.4"));
            REQUIRE(a.at_work(30));
            std::this_thread::sleep_for(random_time(100));
            a.proxy.flip = 64 + 8;  // header and the first number
            auto const begin = std::chrono::steady_clock::now();
            auto const results = a.wait();
            row.took(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 1.0);
            CHECK(a.proxy.flips == 1);
            int refusing = 0;
            for (std::size_t side : {0u, 1u}) {
                CHECK((results[side].exit == 5 || results[side].exit == 3));
                refusing += results[side].exit == 5;
                CHECK(has(first_line(results[side]), side == 0 ? "\"right\"" : "\"left\""));
                CHECK(has(first_line(results[side]), " (t = "));
            }
            CHECK(refusing >= 1);
            CHECK(a.c.leftovers() == 0);
            REQUIRE(!a.c.checkpoints().empty());
        }
    }
}
