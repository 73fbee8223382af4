#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>

#include "tests/support/close_to.hpp"
#include "tests/support/run_in_threads.hpp"
#include "tests/support/toys.hpp"

TEST_CASE("participant: a sender to whom nothing comes back waits for its receiver")
{
    std::string const scene = R"(sluice: 1
time: {end: 1, window: 0.01}
data: {place: {columns: {place: {unit: m}}}}
participants: {fast: {command: none}, slow: {command: none}}
couplings: [{from: fast, to: slow, data: place}]
)";
    std::atomic<std::int64_t> sent = 0;
    auto fast = [&](sluice::Participant& self) {
        self.config().finish();
        double x = 0;
        auto tell = [&] { self.write("slow", "place", toys::one_point, {std::span(&x, 1)}); };
        tell();
        for (sluice::Window const& window : self.windows()) {
            x = window.end;
            tell();
            sent = window.index + 1;
        }
    };
    std::int64_t wrong = 0, ahead = 0;
    auto slow = [&](sluice::Participant& self) {
        self.config().finish();
        for (sluice::Window const& window : self.windows()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
            ahead = std::max<std::int64_t>(ahead, sent - window.index);
            wrong += self.read("fast", "place", window).columns(window.end)[0][0] != window.end;
        }
    };
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(scene, {{"fast", fast}, {"slow", slow}}, scratch.path());
    for (auto const& error : outcome.errors) CHECK(error == "");
    CHECK(wrong == 0);
    CHECK(ahead <= 8);  // four frames of credit, one under way on each side, one being computed, one just sent
}

TEST_CASE("participant: points that change in number and order are sampled by their ids")
{
    std::string const scene = R"(sluice: 1
time: {end: 4, window: 1}
data: {place: {columns: {place: {unit: m}}}}
participants: {a: {command: none}, b: {command: none}}
couplings: [{from: a, to: b, data: place}]
)";
    // point k is at 10 k + t; the set and its order change in every window
    std::vector<std::vector<std::int64_t>> const sets{{1, 2, 3}, {3, 1}, {1, 3, 7}, {}, {2}};
    auto a = [&](sluice::Participant& self) {
        self.config().finish();
        auto tell = [&](std::size_t n) {
            std::vector<double> places;
            for (auto id : sets[n]) places.push_back(10.0 * static_cast<double>(id) + static_cast<double>(n));
            self.write("b", "place", sets[n], {places});
        };
        tell(0);
        for (sluice::Window const& window : self.windows()) tell(static_cast<std::size_t>(window.index) + 1);
    };
    auto b = [&](sluice::Participant& self) {
        self.config().finish();
        for (sluice::Window const& window : self.windows()) {
            auto samples = self.read("a", "place", window);
            auto const ids = samples.ids();
            auto const& now = sets[static_cast<std::size_t>(window.index) + 1];
            auto const& before = sets[static_cast<std::size_t>(window.index)];
            CHECK(std::vector<std::int64_t>(ids.begin(), ids.end()) == now);
            auto const places = samples.columns(window.begin + 0.5)[0];
            for (std::size_t i = 0; i < now.size(); ++i) {
                bool const was_there = std::find(before.begin(), before.end(), now[i]) != before.end();
                double const t =
                    was_there ? window.begin + 0.5 : window.end;  // a new point has no past: its value holds
                CHECK(places[i] == close_to(10.0 * static_cast<double>(now[i]) + t).epsilon(1e-14));
            }
        }
    };
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(scene, {{"a", a}, {"b", b}}, scratch.path());
    for (auto const& error : outcome.errors) CHECK(error == "");
}

TEST_CASE("participant: a frame that rotates is refused for a solver that does not ask for the rotation")
{
    std::string const scene = R"(sluice: 1
time: {end: 0.02, window: 0.01}
frame: {rotating: {axis: [0, 2], rate: 5, ramp: 0.5, euler: false}}
participants: {a: {command: none}}
)";
    sluice::Rotation seen;
    auto solve = [&](bool asks) {
        return [&, asks](sluice::Participant& self) {
            if (asks) seen = *self.rotation();
            self.config().finish();
            for ([[maybe_unused]] sluice::Window const& window : self.windows()) {
            }
        };
    };
    auto without_config = [](sluice::Participant& self) { (void)self.windows(); };
    in_threads::Scratch scratch;
    auto const error = [&](std::function<void(sluice::Participant&)> const& body) {
        return in_threads::run(scene, {{"a", body}}, scratch.path()).errors.at(0);
    };
    std::string const refusal = "3:1: frame = rotating: the solver of \"a\" knows no frame but the inertial one";
    CHECK(error(solve(false)).find(refusal) != std::string::npos);
    CHECK(error(without_config).find(refusal) != std::string::npos);
    CHECK(error(solve(true)) == "");
    CHECK(seen.point == std::array<double, 3>{0, 2, 0});
    CHECK(seen.direction == std::array<double, 3>{0, 0, 1});
    CHECK(seen.rate == 5.0);
    CHECK(seen.ramp == 0.5);
    CHECK(seen.coriolis);
    CHECK_FALSE(seen.euler);
}

TEST_CASE("participant: the one sender of what only one may send, several are an error")
{
    std::string const scene = R"(sluice: 1
time: {end: 1, window: 1}
data: {place: {columns: {place: {unit: m}}}}
participants: {a: {command: none}, b: {command: none}, c: {command: none}}
couplings: [{from: a, to: b, data: place}, {from: a, to: c, data: place}, {from: b, to: c, data: place}]
)";
    auto const ask = [](sluice::Participant& self) {
        self.config().finish();
        std::string const from = self.sender("place");
        CHECK(from == (self.name() == "b" ? "a" : ""));
    };
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(scene, {{"a", ask}, {"b", ask}, {"c", ask}}, scratch.path());
    CHECK(outcome.errors[2] == "c: place from a and b (at most one participant may send it).");
}
