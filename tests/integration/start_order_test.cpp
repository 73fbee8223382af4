// Three and more participants, started by hand at once or one after the other, in every order.

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <random>

#include "tests/support/launched.hpp"
#include "tests/support/ports.hpp"
#include "tests/support/repeats.hpp"

using namespace launched;

namespace {

//! Masses that all pull at each other; who comes earlier in the list is waited for by the others.
std::string all_to_all(std::vector<std::string> const& names, std::string const& more)
{
    std::string text = "sluice: 1\ntime: {end: 0.1, window: 0.001}\ndata: {place: {columns: {place: {unit: m}}}}\n" +
                       more + "participants:\n";
    for (std::size_t i = 0; i < names.size(); ++i)
        text += "  " + names[i] + ": {command: " + toy +
                ", config: {mass: 1, wall_spring: 39, middle_spring: 158, place: " + std::to_string(i) + "}}\n";
    text += "couplings:\n";
    for (std::size_t i = 0; i < names.size(); ++i)
        for (std::size_t j = i + 1; j < names.size(); ++j)
            text += "  - {from: " + names[i] + ", to: " + names[j] + ", data: place}\n  - {from: " + names[j] +
                    ", to: " + names[i] + ", data: place, lag: 1, predict: linear}\n";
    return text;
}

//! Starts them in that order, `pauses` [ms] apart, and waits; where each mass is in the end.
std::vector<double> places_after(Case const& c, std::vector<std::string> const& order, std::vector<int> const& pauses)
{
    std::vector<std::unique_ptr<shell::Background>> running;
    for (std::size_t i = 0; i < order.size(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(i == 0 ? 0 : pauses[i]));
        running.push_back(std::make_unique<shell::Background>(c.by_hand(order[i]), c.scratch.path() / order[i]));
    }
    for (auto& process : running) {
        auto const result = process->wait(60);
        CHECK_MESSAGE(result.exit == 0, result.output);
    }
    std::vector<double> places;
    auto names = order;
    std::sort(names.begin(), names.end());
    for (auto const& name : names) places.push_back(c.final_place(name));
    return places;
}

}  // namespace

TEST_CASE("start order: three participants in all orders, over zmq, shared memory and tcp")
{
    std::vector<std::string> const names{"a", "b", "c"};
    auto const tcp =
        "transport: zmq\naddress: tcp://127.0.0.1:" + std::to_string(ports::take()) + "\n";
    std::mt19937 random(1);
    std::vector<double> expected;
    for (auto const& transport : {std::string("transport: zmq\n"), std::string("transport: shm\n"), tcp})
        for (int repeat = 0; repeat < sluice::test::repeats(1); ++repeat) {
            auto order = names;
            do {
                std::vector<int> pauses;
                for (std::size_t i = 0; i < order.size(); ++i) pauses.push_back(static_cast<int>(random() % 3 * 15));
                CAPTURE(transport);
                CAPTURE(order);
                CAPTURE(pauses);
                Case const c(all_to_all(names, transport));
                auto const places = places_after(c, order, pauses);
                if (expected.empty()) expected = places;
                CHECK(places == expected);  // bit for bit; NaN, where one did not end, equals nothing
            } while (std::next_permutation(order.begin(), order.end()));
        }
}

TEST_CASE("start order: eight participants at once, all to all")
{
    std::vector<std::string> const names{"a", "b", "c", "d", "e", "f", "g", "h"};
    std::vector<int> const pauses(names.size());
    std::vector<double> expected;
    for (int repeat = 0; repeat < sluice::test::repeats(1); ++repeat)
        for (auto const* transport : {"transport: zmq\n", "transport: shm\n"}) {
            Case const c(all_to_all(names, transport));
            auto const places = places_after(c, names, pauses);
            if (expected.empty()) expected = places;
            CHECK(places == expected);
        }
}
