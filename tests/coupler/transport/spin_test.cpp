#include "coupler/transport/spin.hpp"

#include <doctest/doctest.h>

using sluice::Spin;
using std::chrono::microseconds;
using std::chrono::milliseconds;

namespace {

//! How long a wait that begins now spins, looking every microsecond; time is made up.
microseconds spun(Spin& spin, Spin::Clock::time_point& now)
{
    auto const start = now;
    spin.begin(now);
    while (spin.again(now)) now += microseconds(1);
    return std::chrono::duration_cast<microseconds>(now - start);
}

}  // namespace

TEST_CASE("spin: short after long waits, longer after short ones, a millisecond at most")
{
    Spin spin;
    Spin::Clock::time_point now{};
    CHECK(spun(spin, now) == microseconds(50));
    for (int n = 0; n < 40; ++n) {
        spin.begin(now);
        now += microseconds(300);
        spin.found(now);
    }
    CHECK(spun(spin, now) >= microseconds(550));
    CHECK(spun(spin, now) <= milliseconds(1));
    for (int n = 0; n < 40; ++n) {
        spin.begin(now);
        now += milliseconds(20);
        spin.found(now);
    }
    CHECK(spun(spin, now) == microseconds(50));
}

TEST_CASE("spin: once for a wait, however many calls it takes")
{
    Spin spin;
    Spin::Clock::time_point now{};
    microseconds total{0};
    for (int call = 0; call < 1000; ++call) {  // receive(20 us), a thousand times in vain
        spin.begin(now);
        auto const end = now + microseconds(20);
        while (now < end && spin.again(now)) {
            now += microseconds(1);
            total += microseconds(1);
        }
        now = end;
        spin.gave_up(now);
    }
    CHECK(total == microseconds(50));
    spin.found(now);
    CHECK(spun(spin, now) >= microseconds(50));
}

TEST_CASE("spin: ends when somebody else ran on this core")
{
    Spin spin;
    Spin::Clock::time_point now{};
    spin.set_crowded(true);
    spin.begin(now);
    CHECK(spin.again(now += microseconds(1)));
    CHECK_FALSE(spin.again(now += microseconds(30)));
}
