#include "coupler/cli/watchdog.hpp"

#include <doctest/doctest.h>

using namespace sluice;
using std::chrono::duration_cast;
using std::chrono::milliseconds;

namespace {

//! Two processes with a clock of the test's own.
struct Two
{
    explicit Two(double limit) : dog({"left", "right"}, limit)
    {
        for (auto const* name : {"left", "right"}) {
            pages.emplace_back(name, MappedStatus::Mode::unshared);
            pages.back()->phase = Phase::running;
            pages.back()->windows = 1000;
        }
    }
    //! `windows` windows of `each` seconds, in which right computes and left waits for it.
    void compute(int windows, double each)
    {
        for (int w = 0; w < windows; ++w) {
            CHECK(!stay(each));
            for (auto& page : pages) ++page->window;
        }
    }
    //! Time in which no window ends; what the watchdog found first in it.
    std::optional<Watchdog::Finding> stay(double seconds)
    {
        std::optional<Watchdog::Finding> first;
        for (double t = 0; t < seconds; t += 0.1) {
            now += milliseconds(100);
            pages[0]->wait_ns += 100'000'000;
            auto found = dog.look(pages, now);
            if (found && !first) first = found;
        }
        return first;
    }

    std::vector<MappedStatus> pages;
    Watchdog dog;
    Watchdog::Clock::time_point now{std::chrono::hours(1)};
};

}  // namespace

TEST_CASE("watchdog: a window of 10 times the usual and 30 s is found once, with who waits for whom")
{
    Two two(0);
    two.compute(5, 1.0);
    auto const found = two.stay(31);
    REQUIRE(found);
    CHECK(!found->fatal);
    CHECK(found->text.find("\"right\" takes more than 10 times as long") == 0);
    CHECK(found->text.find("computing: \"right\" in window 5 of 1000") != std::string::npos);
    CHECK(found->text.find("waiting for that: \"left\" in window 5") != std::string::npos);
    CHECK(!two.stay(300));
}

TEST_CASE("watchdog: who looks too late for a warning of its own gets it all the same, and then the end")
{
    Two two(33);
    two.compute(5, 1.0);
    CHECK(!two.stay(1));
    two.now += std::chrono::seconds(40);
    auto const look = [&] { return two.dog.look(two.pages, two.now += milliseconds(100)); };
    two.pages[0]->wait_ns += 40'000'000'000;
    auto const first = look(), second = look();
    REQUIRE(first);
    REQUIRE(second);
    CHECK(!first->fatal);
    CHECK(first->text.find("\"right\" takes more than 10 times as long") == 0);
    CHECK(second->fatal);
}

TEST_CASE("watchdog: long windows that are usual, and short ones, are no finding")
{
    Two slow(0);
    slow.compute(5, 40.0);
    CHECK(!slow.stay(300));
    CHECK(slow.stay(101));
    Two fast(0);
    fast.compute(5, 0.1);
    CHECK(!fast.stay(29));
    Two first(0);  // the first window has nothing to be compared with
    CHECK(!first.stay(300));
}

TEST_CASE("watchdog: beyond timeouts.window the run is to end, also in the first window")
{
    Two two(2.0);
    CHECK(!two.stay(1.9));
    auto const found = two.stay(0.5);
    REQUIRE(found);
    CHECK(found->fatal);
    CHECK(found->text.find("a window takes longer than timeouts.window = 2 s: computing: \"right\"") == 0);
}

TEST_CASE("watchdog: who prepares or has ended is left alone")
{
    Two two(2.0);
    two.pages[0]->phase = Phase::connecting;
    two.pages[1]->phase = Phase::preparing;
    CHECK(!two.stay(100));
    two.pages[1]->phase = Phase::done;
    CHECK(!two.stay(100));
}
