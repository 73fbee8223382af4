#include "coupler/cli/rehearsal.hpp"

#include <doctest/doctest.h>

using namespace sluice;

namespace {

//! A scene of participants a, b, c, ... with couplings from, to, lag.
Scene scene(int participants, std::vector<std::array<int, 3>> const& couplings)
{
    Scene s;
    s.data = vocabulary();
    for (int p = 0; p < participants; ++p) {
        s.participants.emplace_back();
        s.participants.back().name = std::string(1, static_cast<char>('a' + p));
    }
    for (auto const& [from, to, lag] : couplings) {
        s.edges.emplace_back();
        s.edges.back().from = from;
        s.edges.back().to = to;
        s.edges.back().lag = lag;
    }
    return s;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("rehearsal: lag 0 there and lag 1 back is one after the other")
{
    auto const r = rehearse(scene(2, {{0, 1, 0}, {1, 0, 1}}));
    CHECK(r.waits.empty());
    CHECK(r.critical.size() == 2);
    CHECK(r.units_per_window == 2);
}

TEST_CASE("rehearsal: two lags of 1 are all at once")
{
    auto const r = rehearse(scene(2, {{0, 1, 1}, {1, 0, 1}}));
    CHECK(r.waits.empty());
    CHECK(r.units_per_window == 1);
    CHECK(r.critical.size() == 1);
}

TEST_CASE("rehearsal: one direction is a pipeline, the sender runs ahead")
{
    auto const r = rehearse(scene(3, {{0, 1, 0}, {1, 2, 0}}));
    CHECK(r.waits.empty());
    CHECK(r.units_per_window == 1);
    CHECK(r.unread == Names{"c"});
    CHECK(r.leading == Names{"a"});
    CHECK(r.alone.empty());
}

TEST_CASE("rehearsal: a chain of three with a lag back takes three computations a window")
{
    auto const r = rehearse(scene(4, {{0, 1, 0}, {1, 2, 0}, {2, 0, 1}}));
    CHECK(r.units_per_window == 3);
    CHECK(r.critical == Names{"a", "b", "c"});
    CHECK(r.alone == Names{"d"});
}

TEST_CASE("rehearsal: a circle of lag 0 is a deadlock, with who waits for what of whom")
{
    auto const r = rehearse(scene(4, {{0, 1, 0}, {1, 0, 0}, {1, 2, 1}}));
    CHECK(r.waits == Names{"a waits in window 0 for frame 1 of kinematics from b",
                           "b waits in window 0 for frame 1 of kinematics from a",
                           "c waits in window 1 for the plan of a", "d waits in window 1 for the plan of a"});
    CHECK(r.critical.empty());
}

TEST_CASE("rehearsal: an implicit group repeats a window, and nobody is left waiting")
{
    auto s = scene(3, {{0, 1, 0}, {1, 0, 1}, {1, 2, 1}});
    s.implicit.emplace_back();
    s.implicit.back().participants = {0, 1};
    auto const r = rehearse(s);
    CHECK(r.waits.empty());
    CHECK(r.units_per_window == 2);
    CHECK(r.critical == Names{"a", "b"});
}

TEST_CASE("rehearsal: in a group whose members all have a lag they compute at once")
{
    auto s = scene(2, {{0, 1, 1}, {1, 0, 1}});
    s.implicit.emplace_back();
    s.implicit.back().participants = {0, 1};
    CHECK(rehearse(s).units_per_window == 1);
    CHECK(rehearse(s).waits.empty());
}

TEST_CASE("rehearsal: a circle of lag 0 stays a deadlock in a group")
{
    auto s = scene(2, {{0, 1, 0}, {1, 0, 0}});
    s.implicit.emplace_back();
    s.implicit.back().participants = {0, 1};
    CHECK(rehearse(s).waits.size() == 2);
}

TEST_CASE("rehearsal: one participant alone is no news")
{
    auto const r = rehearse(scene(1, {}));
    CHECK(r.alone.empty());
    CHECK(r.waits.empty());
    CHECK(r.critical == Names{"a"});
}
