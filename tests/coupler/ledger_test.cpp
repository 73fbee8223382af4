// The ledger: what came on an edge was taken, and what was written was sent.
#include "coupler/ledger.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "tests/support/run_in_threads.hpp"

namespace {

std::vector<std::int64_t> const ids{1, 2};

//! Gives two points a force that changes from window to window.
void giver(sluice::Participant& self)
{
    self.config().finish();
    auto tell = [&](double t) {
        std::vector<double> const force{1 + t, 2, 3, 4}, torque{5, -6 * t};
        self.write("b", sluice::Load{ids, force, torque});
    };
    tell(0);
    for (sluice::Window const& window : self.windows()) tell(window.end);
}

//! Reads it `samples` times a window, up to a window; then no more.
in_threads::Solve taker(int samples, std::int64_t until)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        for (sluice::Window const& window : self.windows()) {
            auto load = self.read<sluice::Load>("a", window);
            if (window.index >= until) continue;
            for (int k = 0; k < samples; ++k) load.at(window.begin + (k + 0.5) * window.length / samples);
        }
    };
}

struct Ran
{
    in_threads::Outcome outcome;
    nlohmann::json summary;  //!< of the taker
};

Ran run(std::string const& edge, in_threads::Solve const& take, std::string const& more = "")
{
    std::string const scene = "sluice: 1\ntime: {end: 40, window: 1}\n" + more +
                              "participants: {a: {command: none}, b: {command: none}}\n"
                              "couplings: [{from: a, to: b, data: load, " +
                              edge + "}]\n";
    in_threads::Scratch scratch;
    Ran ran{in_threads::run(scene, {{"a", giver}, {"b", take}}, scratch.path()), {}};
    std::ifstream(scratch.path() / "run/.sluice/b.json") >> ran.summary;
    return ran;
}

// ---- mass and volume: 30 grains on a line, from M processes to N, a region in between

constexpr int grains = 30;
constexpr double from = 4.25, to = 21.75;  // m, the region

double place(int i, double t)
{
    return i + 0.2 * t;
}
double amount(int i, double t)
{
    return 1e-3 * (1 + i) + 1e-5 * t;
}

in_threads::Solve sender_of_amounts(int rank, int ranks)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        auto tell = [&](double t) {
            std::vector<std::int64_t> id;
            std::vector<double> position, mass;
            for (int i = rank; i < grains; i += ranks) {
                id.push_back(i);
                position.insert(position.end(), {place(i, t), 0});
                mass.push_back(amount(i, t));
            }
            self.write("b", "grains", id, {position, mass, mass});
        };
        tell(0);
        for (sluice::Window const& window : self.windows()) tell(window.end);
    };
}

struct Arrived
{
    std::mutex mutex;
    std::map<std::pair<std::int64_t, std::int64_t>, double> mass;  //!< window, id
};

in_threads::Solve taker_of_amounts(int rank, int ranks, bool covers, Arrived& arrived)
{
    return [=, &arrived](sluice::Participant& self) {
        self.config().finish();
        double const width = 40.0 / ranks;
        if (covers) self.covers({{rank * width, -1, 0}, {(rank + 1) * width, 1, 0}});
        for (sluice::Window const& window : self.windows()) {
            auto grains = self.read("a", "grains", window);
            auto const& columns = grains.columns(window.end);
            std::lock_guard const lock(arrived.mutex);
            for (std::size_t i = 0; i < grains.ids().size(); ++i)
                arrived.mass[{window.index, grains.ids()[i]}] = columns[1][i];
        }
    };
}

}  // namespace

TEST_CASE("ledger: mass and volume close with a region, from M processes to N")
{
    for (int const m : {1, 3})
        for (int const n : {1, 2, 3})
            for (bool const region : {false, true}) {
                CAPTURE(m);
                CAPTURE(n);
                CAPTURE(region);
                std::string const scene = fmt::format(
                    R"(sluice: 1
time: {{end: 20, window: 1}}
ledger: {{on-violation: stop, tolerance: 1e-13}}
data: {{grains: {{columns: {{position: {{shape: vector, unit: m}}, mass: {{unit: kg}}, volume: {{unit: m3}}}}}}}}
participants: {{a: {{command: none, ranks: {}}}, b: {{command: none, ranks: {}}}}}
couplings: [{{from: a, to: b, data: grains{}}}]
)",
                    m, n, region ? fmt::format(", region: {{min: [{}, -1], max: [{}, 1]}}", from, to) : "");
                Arrived arrived;
                std::vector<std::pair<std::string, in_threads::Solve>> all;
                for (int r = 0; r < m; ++r) all.emplace_back(fmt::format("a:{}", r), sender_of_amounts(r, m));
                for (int r = 0; r < n; ++r)
                    all.emplace_back(fmt::format("b:{}", r), taker_of_amounts(r, n, n > 1, arrived));
                in_threads::Scratch scratch;
                auto const outcome = in_threads::run(scene, all, scratch.path());
                for (auto const& error : outcome.errors) CHECK(error == "");
                double inside = 0, outside = 0, got = 0;  // of windows 0 to 19
                for (int w = 0; w < 20; ++w)
                    for (int i = 0; i < grains; ++i) {
                        double const x = place(i, w + 1);
                        bool const goes = !region || (x >= from && x <= to);
                        (goes ? inside : outside) += amount(i, w + 1);
                        CHECK(arrived.mass.contains({w, i}) == goes);
                        if (goes) got += arrived.mass[{w, i}];
                    }
                CHECK(std::abs(got - inside) < 1e-13);
                double written = 0, sent = 0, left = 0;
                for (int r = 0; r < m && (region || n > 1); ++r) {
                    nlohmann::json summary;
                    auto const name = m == 1 ? std::string("a") : fmt::format("a:{}", r);
                    std::ifstream(scratch.path() / "run/.sluice" / (name + ".json")) >> summary;
                    auto const& books = summary.at("ledger").at(0).at("books");
                    CHECK(books.at("mass [kg]") == books.at("volume [m3]"));
                    written += books.at("mass [kg]").at("written").get<double>();
                    sent += books.at("mass [kg]").at("sent").get<double>();
                    left += books.at("mass [kg]").at("outside").get<double>();
                }
                CHECK(std::abs(written - sent) < 1e-12);  // sent, or left outside
                if (region || n > 1) {
                    double initial = 0;  // frame 0 is booked, too
                    for (int i = 0; i < grains; ++i)
                        if (region && (place(i, 0) < from || place(i, 0) > to)) initial += amount(i, 0);
                    CHECK(std::abs(left - outside - initial) < 1e-12);
                }
            }
}

TEST_CASE("ledger: closes for every way to see an edge, up to what is under way")
{
    for (auto const edge :
         {"lag: 0", "lag: 0, sample: hold", "lag: 1", "lag: 1, predict: linear", "lag: 1, predict: quadratic"})
        for (int const samples : {1, 3}) {
            CAPTURE(edge);
            auto const ran = run(edge, taker(samples, 1000));
            for (auto const& error : ran.outcome.errors) CHECK(error == "");
            CHECK(ran.summary.at("warnings").empty());
            auto const& force = ran.summary.at("ledger").at(0).at("books").at("force_x [N]");
            double const came = force.at("came"), taken = force.at("taken");
            CHECK(came > 800);  // the sum of 4 + t over 40 windows, one of them earlier or later
            CHECK(std::abs(came - taken) < 2 * 44);
        }
}

TEST_CASE("ledger: samples say whether they vary within a window, and one of those that do not closes the books")
{
    for (auto const& [edge, vary] : std::map<std::string, bool>{{"lag: 0", true},
                                                                {"lag: 0, sample: hold", false},
                                                                {"lag: 1", false},
                                                                {"lag: 1, predict: linear", true},
                                                                {"lag: 1, predict: linear, sample: hold", false}}) {
        CAPTURE(edge);
        auto const ran = run(edge, [&](sluice::Participant& self) {
            self.config().finish();
            for (sluice::Window const& window : self.windows()) {
                auto load = self.read<sluice::Load>("a", window);
                CHECK(load.vary() == vary);
                double const early = load.at(window.begin + 0.25).force[0];
                if (load.vary() && window.index > 0) CHECK(load.at(window.begin + 0.75).force[0] != early);
                if (!load.vary() && window.index % 2 == 0) CHECK(load.at(window.begin + 0.75).force[0] == early);
            }
        });
        for (auto const& error : ran.outcome.errors) CHECK(error == "");
        CHECK(ran.summary.at("warnings").empty());
    }
}

TEST_CASE("ledger: a load that is no longer read is named, and stops the run if the scene says so")
{
    auto const warned = run("lag: 1", taker(1, 10));
    for (auto const& error : warned.outcome.errors) CHECK(error == "");
    REQUIRE(warned.summary.at("warnings").size() == 1);
    auto const text = warned.summary.at("warnings").at(0).get<std::string>();
    CHECK(text.find("a -> b: load: force_") != std::string::npos);
    CHECK(text.find("does not close") != std::string::npos);
    auto const stopped = run("lag: 1", taker(1, 10), "ledger: {on-violation: stop}\n");
    CHECK(stopped.outcome.errors[1].find("does not close") != std::string::npos);
    auto const off = run("lag: 1", taker(1, 10), "ledger: {on-violation: off}\n");
    CHECK(off.summary.at("warnings").empty());
    CHECK_FALSE(off.summary.contains("ledger"));
}

TEST_CASE("ledger: an amount that is sent twice, or nowhere, does not close")
{
    sluice::DataSpec const spec{"load", {{"force", sluice::Shape::vector, "N"}}, false, true};
    sluice::Account good(spec, 2, "a -> b: load"), doubled(spec, 2, "a -> b: load"), lost(spec, 2, "a -> b: load");
    for (int n = 0; n < 100; ++n) {
        good.sent({1, -2}, {0.75, -2}, {0.25, 0});
        doubled.sent({1, -2}, {1.001, -2}, {0, 0});
        lost.sent({1, -2}, {1, -1.999}, {0, 0});
    }
    CHECK(good.violation(1e-12) == "");
    CHECK(doubled.violation(1e-9).find("force_x [N] does not close") != std::string::npos);
    CHECK(lost.violation(1e-9).find("force_y [N] does not close") != std::string::npos);
}
