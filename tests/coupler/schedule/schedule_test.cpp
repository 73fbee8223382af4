#include "coupler/schedule/schedule.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

using sluice::Action;
using sluice::InEdge;
using sluice::Schedule;
using Kind = sluice::Action::Kind;

TEST_CASE("schedule: a participant without in-edges alternates send and compute")
{
    Schedule schedule({}, 2);
    for (std::int64_t n = 0; n < 2; ++n) {
        CHECK(schedule.next() == Action{.kind = Kind::send, .window = n, .frame = n});
        schedule.sent();
        CHECK(schedule.next() == Action{.kind = Kind::compute, .window = n});
        schedule.computed();
    }
    CHECK(schedule.next().kind == Kind::send);  // the final state is sent too
    schedule.sent();
    CHECK(schedule.next().kind == Kind::finish);
}

TEST_CASE("schedule: lag 0 waits for this window's frame, lag 1 for the last one's")
{
    Schedule schedule({{.lag = 0}, {.lag = 1, .predict = 1}}, 1);
    schedule.sent();
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 0, .edge = 0});
    CHECK(schedule.received(0, 0));
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 1, .edge = 0});
    CHECK(schedule.received(0, 1));
    CHECK(schedule.next() == Action{.kind = Kind::await, .window = 0, .frame = 0, .edge = 1});
    CHECK(schedule.received(1, 0));
    CHECK(schedule.next().kind == Kind::compute);
}

TEST_CASE("schedule: a gap, a repetition and a frame beyond the end are refused")
{
    Schedule schedule({{.lag = 1}}, 2);
    CHECK_FALSE(schedule.received(0, 1));
    CHECK(schedule.received(0, 0));
    CHECK_FALSE(schedule.received(0, 0));
    CHECK_FALSE(schedule.received(0, 2));
    CHECK(schedule.received(0, 1));
    CHECK(schedule.received(0, 2));
    CHECK_FALSE(schedule.received(0, 3));
}

namespace {

struct Wire  // an edge of a random topology, with the frames under way on it
{
    int from, to, lag, slot;
    std::vector<std::int64_t> queue;
};

//! Runs n participants on in-memory queues in random order; returns whether all of them finished.
bool all_finish(std::vector<Wire> wires, int n, std::int64_t windows, std::mt19937& random)
{
    std::vector<std::vector<InEdge>> in(static_cast<std::size_t>(n));
    for (Wire& w : wires) {
        auto& list = in[static_cast<std::size_t>(w.to)];
        w.slot = static_cast<int>(list.size());
        list.push_back({.lag = w.lag});
    }
    std::vector<Schedule> schedules;
    for (auto const& edges : in) schedules.emplace_back(edges, windows);
    auto step = [&](int p) {
        Schedule& s = schedules[static_cast<std::size_t>(p)];
        Action const a = s.next();
        if (a.kind == Kind::finish) return false;
        if (a.kind == Kind::compute) return s.computed(), true;
        if (a.kind == Kind::send) {
            for (Wire& w : wires)
                if (w.from == p) w.queue.push_back(a.frame);
            return s.sent(), true;
        }
        for (Wire& w : wires)
            if (w.to == p && w.slot == a.edge && !w.queue.empty()) {
                bool const expected = s.received(w.slot, w.queue.front());
                w.queue.erase(w.queue.begin());
                REQUIRE(expected);
                return true;
            }
        return false;
    };
    std::vector<int> order(static_cast<std::size_t>(n));
    for (int p = 0; p < n; ++p) order[static_cast<std::size_t>(p)] = p;
    for (bool moved = true; moved;) {
        moved = false;
        std::shuffle(order.begin(), order.end(), random);
        for (int p : order) moved = step(p) || moved;
    }
    return std::all_of(schedules.begin(), schedules.end(), [](auto const& s) { return s.next().kind == Kind::finish; });
}

}  // namespace

TEST_CASE("schedule: every topology without a lag-0 circle ends, in any order of events")
{
    std::mt19937 random(1);
    for (int trial = 0; trial < 500; ++trial) {
        int const n = 2 + static_cast<int>(random() % 4);
        std::vector<Wire> wires;
        for (int from = 0; from < n; ++from)
            for (int to = 0; to < n; ++to)
                if (from != to && random() % 2) wires.push_back({from, to, from < to ? int(random() % 2) : 1, 0, {}});
        CHECK(all_finish(wires, n, 5, random));
    }
}

TEST_CASE("schedule: a lag-0 circle never starts")
{
    std::mt19937 random(1);
    CHECK_FALSE(all_finish({{0, 1, 0, 0, {}}, {1, 0, 0, 0, {}}}, 2, 5, random));
}

TEST_CASE("sample_weights: prediction of order p is exact for polynomials of degree p")
{
    auto value = [](int degree, double t) { return degree == 0 ? 3.0 : degree == 1 ? 3 + 2 * t : 3 + 2 * t - t * t; };
    for (int order = 0; order <= 2; ++order)
        for (double s : {0.0, 0.25, 1.0}) {
            auto const w = sluice::sample_weights({.lag = 1, .predict = order}, 3, s);
            double sum = 0;
            for (int k = 0; k < 3; ++k) sum += w.at[k] * value(order, -k);
            CHECK(sum == doctest::Approx(value(order, s)).epsilon(1e-14));
        }
}

TEST_CASE("sample_weights: lag 0 is linear between the last two frames, and the order drops without history")
{
    auto const w = sluice::sample_weights({.lag = 0}, 2, 0.25);
    CHECK(w.at[0] == 0.25);
    CHECK(w.at[1] == 0.75);
    CHECK(sluice::sample_weights({.lag = 1, .predict = 2}, 1, 0.5).at[0] == 1.0);
    CHECK(sluice::sample_weights({.lag = 1, .predict = 2}, 2, 0.5).at[1] == -0.5);
}
