// Windows that change their length, runs that end early, data without points, columns that nobody reads.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/toys.hpp"

namespace {

void expect_well(in_threads::Outcome const& outcome)
{
    for (auto const& error : outcome.errors) CHECK(error == "");
}

std::string two(std::string const& time, std::string const& couplings)
{
    return "sluice: 1\ntime: {" + time +
           "}\ndata: {place: {columns: {place: {unit: m}}}}\n"
           "participants: {a: {command: none}, b: {command: none}}\ncouplings:\n" +
           couplings;
}

char const* const parallel =
    "  - {from: a, to: b, data: place, lag: 1, predict: linear}\n"
    "  - {from: b, to: a, data: place, lag: 1, predict: linear}\n";

struct Seen
{
    std::vector<double> begins, ends;
    double worst = 0;  //!< largest error of a linear signal, sampled inside the windows
};

//! Tells its partner 3 + 2 t and expects the same of it, also in the middle of windows.
in_threads::Solve signal(std::string const& partner, Seen& seen,
                         std::function<void(sluice::Participant&, sluice::Window const&)> const& steer = {})
{
    return [&seen, partner, steer](sluice::Participant& self) {
        self.config().finish();
        auto tell = [&](double t) {
            double const value = 3 + 2 * t;
            self.write(partner, "place", toys::one_point, {std::span(&value, 1)});
        };
        tell(0);
        self.propose_window(0.1);
        for (sluice::Window const& window : self.windows()) {
            seen.begins.push_back(window.begin);
            seen.ends.push_back(window.end);
            auto other = self.read(partner, "place", window);
            if (window.index > 0)  // before there is no history to predict from
                for (int k = 0; k <= 4; ++k) {
                    double const t = window.time(k, 4);
                    seen.worst = std::max(seen.worst, std::abs(other.columns(t)[0][0] - (3 + 2 * t)));
                }
            if (steer) steer(self, window);
            tell(window.end);
        }
    };
}

}  // namespace

TEST_CASE("windows: equal ones end at the doubles nearest to their multiples, and the last one at the end")
{
    Seen a, b;
    in_threads::Scratch scratch;
    expect_well(in_threads::run(two("end: 1.05, window: 0.1", parallel), {{"a", signal("b", a)}, {"b", signal("a", b)}},
                                scratch.path()));
    REQUIRE(a.ends.size() == 11);
    for (std::size_t n = 0; n < 10; ++n) {
        CHECK(a.begins[n] == 0.1 * static_cast<double>(n));
        CHECK(a.ends[n] == 0.1 * static_cast<double>(n + 1));
    }
    CHECK(std::abs(a.ends[10] - 1.05) < 1e-8);  // a tick is 1e-8 of a window
    CHECK(a.ends == b.ends);
    CHECK(a.worst < 1e-12);
    CHECK(b.worst < 1e-12);
}

TEST_CASE("windows: a rest that is a sliver is shared by the last two windows")
{
    Seen a, b;
    in_threads::Scratch scratch;
    expect_well(in_threads::run(two("end: 0.4001, window: 0.1", parallel),
                                {{"a", signal("b", a)}, {"b", signal("a", b)}}, scratch.path()));
    REQUIRE(a.ends.size() == 5);
    CHECK(a.ends[4] - a.begins[4] > 0.05);
}

TEST_CASE("windows: the one who paces changes their length, and prediction follows")
{
    Seen a, b;
    in_threads::Scratch scratch;
    auto const steer = [](sluice::Participant& self, sluice::Window const& window) {
        self.next_window(0.01 + 0.05 * std::abs(std::sin(static_cast<double>(window.index))));
    };
    expect_well(in_threads::run(two("end: 1, window: auto, pace: b", parallel),
                                {{"a", signal("b", a)}, {"b", signal("a", b, steer)}}, scratch.path()));
    CHECK(a.ends.size() > 20);
    CHECK(a.ends == b.ends);
    CHECK(std::abs(a.ends.back() - 1) < 1e-8);
    for (std::size_t n = 1; n < a.ends.size(); ++n) CHECK(a.begins[n] == a.ends[n - 1]);
    CHECK(a.worst < 1e-12);
    CHECK(b.worst < 1e-12);
}

TEST_CASE("windows: others than the one who paces may neither change their length nor end the run")
{
    for (bool const ends : {true, false}) {
        Seen a, b;
        in_threads::Scratch scratch;
        auto const steer = [&](sluice::Participant& self, sluice::Window const&) {
            ends ? self.end_run("enough") : self.next_window(0.1);
        };
        auto const outcome = in_threads::run(two("end: 1, window: 0.1, pace: a", parallel),
                                             {{"a", signal("b", a)}, {"b", signal("a", b, steer)}}, scratch.path());
        CHECK(outcome.errors[1].find("\"a\" paces this run. Set time.pace: b.") != std::string::npos);
        CHECK(outcome.errors[0] != "");
    }
}

TEST_CASE("windows: a run may end early, after one more window that everybody knows to be the last")
{
    Seen a, b;
    std::vector<char> last;
    in_threads::Scratch scratch;
    auto const steer = [&](sluice::Participant& self, sluice::Window const& window) {
        last.push_back(window.last);
        if (window.index == 3) self.end_run("the flow has come to rest");
    };
    expect_well(in_threads::run(two("end: 1, window: 0.1, pace: a", parallel),
                                {{"a", signal("b", a, steer)}, {"b", signal("a", b)}}, scratch.path()));
    CHECK(last == std::vector<char>{0, 0, 0, 0, 1});
    CHECK(b.ends.size() == 5);
}

TEST_CASE("windows: steps that are exact keep every window a multiple of them")
{
    Seen b;
    std::vector<double> lengths;
    in_threads::Scratch scratch;
    auto const exact = [&](sluice::Participant& self) {
        self.config().finish();
        double value = 3;
        auto tell = [&] { self.write("b", "place", toys::one_point, {std::span(&value, 1)}); };
        tell();
        self.propose_window(0.03, true);
        for (sluice::Window const& window : self.windows()) {
            lengths.push_back(window.length / 0.03);
            value = 3 + 2 * window.end;
            tell();
            self.next_window(0.1 + 0.03 * static_cast<double>(window.index % 3));
        }
    };
    expect_well(in_threads::run(
        two("end: 1, window: auto, pace: a",
            "  - {from: a, to: b, data: place, lag: 1, predict: linear}\n  - {from: b, to: a, data: place, lag: 1}\n"),
        {{"a", exact}, {"b", signal("a", b)}}, scratch.path()));
    for (double const ratio : lengths) CHECK(std::abs(ratio - std::round(ratio)) < 1e-9);
    CHECK(*std::max_element(lengths.begin(), lengths.end()) > 4.5);
    CHECK(b.worst < 1e-12);
}

TEST_CASE("windows: an exact step too short to be counted in ticks only keeps them from changing their length")
{
    Seen b;
    std::string why;
    in_threads::Scratch scratch;
    auto const tiny = [&](sluice::Participant& self) {
        self.config().finish();
        double value = 3;
        auto tell = [&] { self.write("b", "place", toys::one_point, {std::span(&value, 1)}); };
        tell();
        self.propose_window(1e-12, true);
        for (sluice::Window const& window : self.windows()) {
            try {
                self.next_window(0.2);
            } catch (sluice::Error const& error) {
                why = error.what();
            }
            value = 3 + 2 * window.end;
            tell();
        }
    };
    expect_well(in_threads::run(two("end: 1, window: 0.1, pace: a", parallel), {{"a", tiny}, {"b", signal("a", b)}},
                                scratch.path()));
    CHECK(b.ends.size() == 10);
    CHECK(why.find("no common divisor that ticks can express") != std::string::npos);
}

TEST_CASE("data: without points, and columns that the receiver does not read")
{
    std::string const scene = R"(sluice: 1
time: {end: 3, window: 1}
dimension: 3
data:
  level: {meshless: true, columns: {height: {unit: m}, normal: {shape: vector, unit: "1"}}}
participants: {a: {command: none}, b: {command: none}}
couplings: [{from: a, to: b, data: level}, {from: a, to: b, data: load}]
)";
    auto const a = [](sluice::Participant& self) {
        self.config().finish();
        std::vector<std::int64_t> const ids{5, 9};
        std::vector<double> const force{1, 2, 3, 4, 5, 6}, torque{7, 8, 9, 10, 11, 12};
        auto tell = [&](double t) {
            self.write_values("b", "level", std::vector<double>{t, 0, 0, 1});
            self.write("b", sluice::Load{ids, force, torque});
        };
        tell(0);
        for (sluice::Window const& window : self.windows()) tell(window.end);
    };
    auto const b = [](sluice::Participant& self) {
        self.config().finish();
        self.reads("load", {"torque"});
        for (sluice::Window const& window : self.windows()) {
            CHECK(self.read_values("a", "level", window) == std::vector<double>{window.end, 0, 0, 1});
            auto const load = self.read<sluice::Load>("a", window).at(window.end);
            CHECK(load.force.empty());
            CHECK(load.torque[5] == 12);
        }
    };
    in_threads::Scratch scratch;
    expect_well(in_threads::run(scene, {{"a", a}, {"b", b}}, scratch.path()));
}

TEST_CASE("participant: writing twice in a window, or not at all, is a bug that is named")
{
    for (int const times : {0, 2}) {
        Seen b;
        auto const a = [&](sluice::Participant& self) {
            self.config().finish();
            double const value = 3;
            auto tell = [&] { self.write("b", "place", toys::one_point, {std::span(&value, 1)}); };
            tell();
            for (sluice::Window const& window : self.windows())
                for (int k = 0; k < (window.index == 2 ? times : 1); ++k) tell();
        };
        in_threads::Scratch scratch;
        auto const outcome =
            in_threads::run(two("end: 1, window: 0.1", parallel), {{"a", a}, {"b", signal("a", b)}}, scratch.path());
        CHECK(outcome.errors[0].find(times == 0 ? "wrote nothing to \"b\"" : "wrote place twice in window 2") !=
              std::string::npos);
        CHECK(outcome.errors[1].find("participant \"a\" stopped in window 2") != std::string::npos);
    }
}
