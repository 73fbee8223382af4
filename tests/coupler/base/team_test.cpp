#include "coupler/base/team.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace {

//! How often each index of a loop is given out.
std::vector<int> given_out(sluice::Team& team, std::ptrdiff_t count, std::ptrdiff_t chunk)
{
    std::vector<int> times(static_cast<std::size_t>(count), 0);
    team.share(count, chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        std::this_thread::yield();  // others take chunks, too
        for (std::ptrdiff_t i = begin; i < end; ++i) ++times[static_cast<std::size_t>(i)];
    });
    return times;
}

bool is_once(std::vector<int> const& times)
{
    return std::ranges::all_of(times, [](int n) { return n == 1; });
}

}  // namespace

TEST_CASE("team: each index is given out once, whatever the threads, the loop and its chunks")
{
    for (int const threads : {1, 2, 3, 8}) {
        sluice::Team team(threads);
        CHECK(team.size() == threads);
        for (std::ptrdiff_t const count : {0, 1, 2, 7, 64, 1001})
            for (std::ptrdiff_t const chunk : {1, 3, 64, 2000}) {
                CAPTURE(threads);
                CAPTURE(count);
                CAPTURE(chunk);
                CHECK(is_once(given_out(team, count, chunk)));
            }
    }
}

TEST_CASE("team: loops that follow each other at once do not mix, though their sizes change")
{
    sluice::Team team(4);  // more than there are cores here and there: some come late to every loop
    sluice::Team::Awake const awake(team);
    for (int n = 0; n < 500; ++n) REQUIRE(is_once(given_out(team, 1 + n * 7 % 50, 1 + n % 3)));
}

TEST_CASE("team: what a loop has written the next one sees, on whatever thread")
{
    sluice::Team team(3);
    std::vector<long> values(40, 0);
    for (int n = 0; n < 500; ++n) {
        std::vector<long> const before = values;
        team.share(40, 1, [&](std::ptrdiff_t begin, std::ptrdiff_t) {
            auto const i = static_cast<std::size_t>(begin);
            values[i] = before[(i + 1) % 40] + 1;
        });
    }
    CHECK(std::ranges::all_of(values, [](long v) { return v == 500; }));
}
