#include "coupler/schedule/schedule.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/close_to.hpp"

using sluice::Action;
using sluice::InEdge;
using sluice::Plan;
using sluice::Schedule;
using Kind = sluice::Action::Kind;

namespace {

constexpr std::int64_t length = 10;  // ticks

Plan plan_of(std::int64_t window, std::int64_t windows, std::int64_t checkpoint = -1, bool stop = false)
{
    return {.window = window,
            .begin = window * length,
            .length = length,
            .last = window + 1 == windows,
            .checkpoint = window == checkpoint,
            .stop = stop && window == checkpoint};
}

}  // namespace

TEST_CASE("schedule: a participant without in-edges alternates send, plan and compute")
{
    Schedule schedule({});
    for (std::int64_t n = 0; n < 2; ++n) {
        CHECK(schedule.next() == Action{.kind = Kind::send, .window = n, .frame = n});
        schedule.sent();
        CHECK(schedule.next() == Action{.kind = Kind::plan, .window = n});
        schedule.planned(plan_of(n, 2));
        CHECK(schedule.next() == Action{.kind = Kind::compute, .window = n});
        schedule.computed();
    }
    CHECK(schedule.next().kind == Kind::send);  // the final state is sent too
    schedule.sent();
    CHECK(schedule.next().kind == Kind::finish);
    CHECK_FALSE(schedule.stopped());
}

TEST_CASE("schedule: lag 0 waits for this window's frame, lag 1 for the last one's")
{
    Schedule schedule({{.lag = 0}, {.lag = 1, .predict = 1}});
    schedule.sent();
    schedule.planned(plan_of(0, 1));
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 0, .edge = 0});
    CHECK(schedule.received(0, 0));
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 0, .edge = 1});
    CHECK(schedule.received(1, 0));
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 1, .edge = 0});
    CHECK(schedule.received(0, 1));
    CHECK(schedule.next().kind == Kind::compute);
}

TEST_CASE("schedule: only the frame that is waited for is taken")
{
    Schedule schedule(std::vector<InEdge>{{.lag = 1}});
    CHECK_FALSE(schedule.received(0, 0));  // nothing was sent yet
    schedule.sent();
    schedule.planned(plan_of(0, 2));
    CHECK_FALSE(schedule.received(0, 1));
    CHECK_FALSE(schedule.received(0, 0, 1));
    CHECK_FALSE(schedule.received(1, 0));
    CHECK(schedule.received(0, 0));
    CHECK_FALSE(schedule.received(0, 0));
}

TEST_CASE("schedule: in an implicit group a window is repeated until all agree")
{
    // edge 0: lag 0, inside; edge 1: lag 1, inside; edge 2: lag 0, from outside
    Schedule schedule({{.lag = 0, .inside = true}, {.lag = 1, .inside = true}, {.lag = 0}}, true);
    schedule.sent();
    schedule.planned(plan_of(0, 1));
    for (int edge : {0, 1, 2}) CHECK(schedule.received(edge, 0));
    CHECK(schedule.next() == Action{.kind = Kind::await, .frame = 1, .edge = 0});
    CHECK(schedule.received(0, 1, 0));
    CHECK(schedule.received(2, 1));
    for (std::uint32_t iteration = 0; iteration < 3; ++iteration) {
        if (iteration > 0) CHECK(schedule.received(0, 1, iteration));  // the edge from outside does not come again
        CHECK(schedule.next() == Action{.kind = Kind::compute, .iteration = iteration});
        schedule.computed();
        CHECK(schedule.next() == Action{.kind = Kind::await, .frame = 1, .iteration = iteration, .edge = 1});
        CHECK(schedule.received(1, 1, iteration));
        CHECK(schedule.next() == Action{.kind = Kind::agree, .iteration = iteration});
        schedule.agreed(iteration == 2);
    }
    CHECK(schedule.next() == Action{.kind = Kind::send, .window = 1, .frame = 1});
    schedule.sent();
    CHECK(schedule.next().kind == Kind::finish);
}

namespace {

struct Wire  // an edge of a random topology, with the frames under way on it
{
    int from, to, lag;
    bool inside = false;
    int slot = 0;
    std::vector<std::pair<std::int64_t, std::uint32_t>> queue = {};
    std::int64_t taken = -1;  //!< the newest frame that the receiver took
};

//! What a run of n participants on in-memory queues came to.
struct Outcome
{
    bool finished = false;  //!< all of them
    bool stopped = false;
    std::vector<std::vector<std::int64_t>> taken_when_stored;  //!< per participant: the newest frame on each in-edge
};

struct Crowd
{
    std::vector<Wire> wires;
    int n;
    std::int64_t windows;
    std::vector<char> grouped;
    std::int64_t checkpoint = -1, begin = 0;
    bool stop = false;
    std::uint32_t iterations = 3;  //!< of every window of the group

    Outcome run(std::mt19937& random)
    {
        std::vector<std::vector<InEdge>> in(static_cast<std::size_t>(n));
        for (Wire& w : wires) {
            auto& list = in[static_cast<std::size_t>(w.to)];
            w.slot = static_cast<int>(list.size());
            w.taken = begin > 0 ? begin : -1;
            list.push_back({.lag = w.lag, .inside = w.inside});
        }
        for (std::size_t p = 0; p < in.size(); ++p) schedules.emplace_back(in[p], grouped[p] != 0, begin);
        planned = begin;
        agreed.assign(in.size(), 0);
        outcome.taken_when_stored.resize(in.size());
        std::vector<int> order(static_cast<std::size_t>(n));
        for (int p = 0; p < n; ++p) order[static_cast<std::size_t>(p)] = p;
        for (bool moved = true; moved;) {
            moved = false;
            std::shuffle(order.begin(), order.end(), random);
            for (int p : order) moved = step(p) || moved;
        }
        outcome.finished = std::all_of(schedules.begin(), schedules.end(),
                                       [](auto const& s) { return s.next().kind == Kind::finish; });
        outcome.stopped = std::all_of(schedules.begin(), schedules.end(), [](auto const& s) { return s.stopped(); });
        return outcome;
    }

    //! One action of one participant; false if it has to wait.
    bool step(int p)
    {
        auto const at = static_cast<std::size_t>(p);
        Schedule& s = schedules[at];
        Action const a = s.next();
        switch (a.kind) {
            case Kind::finish:
                return false;
            case Kind::plan:
                if (p == 0) planned = std::max(planned, a.window + 1);  // the first one paces
                if (planned <= a.window) return false;
                s.planned(plan_of(a.window, windows, checkpoint, stop));
                return true;
            case Kind::checkpoint:
                for (Wire const& w : wires)
                    if (w.to == p) outcome.taken_when_stored[at].push_back(w.taken);
                s.stored();
                return true;
            case Kind::compute:
                s.computed();
                for (Wire& w : wires)
                    if (w.from == p && (w.inside || !grouped[at])) w.queue.push_back({a.window + 1, a.iteration});
                return true;
            case Kind::send:
                for (Wire& w : wires)
                    if (w.from == p && (a.frame == 0 || (grouped[at] && !w.inside))) w.queue.push_back({a.frame, 0});
                s.sent();
                return true;
            case Kind::agree:
                return agree(p, a);
            case Kind::await:
                break;
        }
        for (Wire& w : wires)
            if (w.to == p && w.slot == a.edge && !w.queue.empty()) {
                auto const [frame, iteration] = w.queue.front();
                w.queue.erase(w.queue.begin());
                REQUIRE(s.received(w.slot, frame, iteration));
                w.taken = frame;
                return true;
            }
        return false;
    }

    //! Everybody in the group must have come to the same point before anybody goes on.
    bool agree(int p, Action const& a)
    {
        auto const rank = a.window * 1000 + a.iteration + 1;
        agreed[static_cast<std::size_t>(p)] = std::max<std::int64_t>(agreed[static_cast<std::size_t>(p)], rank);
        for (std::size_t q = 0; q < agreed.size(); ++q)
            if (grouped[q] && agreed[q] < rank) return false;
        schedules[static_cast<std::size_t>(p)].agreed(a.iteration + 1 == iterations);
        return true;
    }

    std::vector<Schedule> schedules = {};
    std::int64_t planned = 0;
    std::vector<std::int64_t> agreed = {};
    Outcome outcome = {};
};

//! A topology without a lag-0 circle; with `grouped`, the first two of three or more iterate.
Crowd random_crowd(std::mt19937& random, bool grouped)
{
    int const n = 2 + static_cast<int>(random() % 4);
    Crowd crowd{.wires = {}, .n = n, .windows = 5, .grouped = std::vector<char>(static_cast<std::size_t>(n))};
    if (grouped) crowd.grouped[0] = crowd.grouped[1] = true;
    for (int from = 0; from < n; ++from)
        for (int to = 0; to < n; ++to) {
            bool const inside = grouped && from < 2 && to < 2;
            if (from != to && (inside || random() % 2))
                crowd.wires.push_back({from, to, from < to ? static_cast<int>(random() % 2) : 1, inside});
        }
    return crowd;
}

}  // namespace

TEST_CASE("schedule: every topology without a lag-0 circle ends, in any order of events")
{
    std::mt19937 random(1);
    for (int trial = 0; trial < 1000; ++trial) CHECK(random_crowd(random, trial % 2).run(random).finished);
}

TEST_CASE("schedule: a lag-0 circle never starts")
{
    std::mt19937 random(1);
    Crowd crowd{.wires = {{0, 1, 0}, {1, 0, 0}}, .n = 2, .windows = 5, .grouped = {0, 0}};
    CHECK_FALSE(crowd.run(random).finished);
}

TEST_CASE("schedule: at a checkpoint every edge has brought the same frame, and the run goes on from it")
{
    std::mt19937 random(2);
    for (int trial = 0; trial < 1000; ++trial) {
        auto crowd = random_crowd(random, trial % 2);
        auto again = crowd;
        crowd.checkpoint = 1 + static_cast<std::int64_t>(random() % 4);
        crowd.stop = trial % 3 == 0;
        auto const outcome = crowd.run(random);
        CHECK(outcome.finished);
        CHECK(outcome.stopped == crowd.stop);
        for (auto const& taken : outcome.taken_when_stored)
            for (auto const frame : taken) CHECK(frame == crowd.checkpoint);
        again.begin = crowd.checkpoint;
        CHECK(again.run(random).finished);
    }
}

TEST_CASE("sample_weights: prediction of order p is exact for polynomials of degree p, at any spacing of frames")
{
    auto value = [](int degree, double t) { return degree == 0 ? 3.0 : degree == 1 ? 3 + 2 * t : 3 + 2 * t - t * t; };
    for (auto const& past : {std::array{1.0, 2.0}, std::array{0.3, 2.5}})
        for (int order = 0; order <= 2; ++order)
            for (double s : {0.0, 0.25, 1.0}) {
                auto const w = sluice::sample_weights({.lag = 1, .predict = order}, 3, s, past);
                double const sum =
                    w.at[0] * value(order, 0) + w.at[1] * value(order, -past[0]) + w.at[2] * value(order, -past[1]);
                CHECK(sum == close_to(value(order, s)).epsilon(1e-14));
            }
}

TEST_CASE("sample_weights: lag 0 is linear between the last two frames, and the order drops without history")
{
    std::array const past{1.0, 2.0};
    auto const w = sluice::sample_weights({.lag = 0}, 2, 0.25, past);
    CHECK(w.at[0] == 0.25);
    CHECK(w.at[1] == 0.75);
    CHECK(sluice::sample_weights({.lag = 1, .inside = true}, 2, 0.25, past).at[1] == 0.75);
    CHECK(sluice::sample_weights({.lag = 1, .predict = 2}, 1, 0.5, past).at[0] == 1.0);
    CHECK(sluice::sample_weights({.lag = 1, .predict = 2}, 2, 0.5, past).at[1] == -0.5);
}
