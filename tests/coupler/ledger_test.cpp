// The ledger: what came on an edge was taken, and what was written was sent.
#include "coupler/ledger.hpp"

#include <doctest/doctest.h>

#include <fstream>
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

}  // namespace

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
