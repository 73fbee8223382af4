// C09d: the energy that staggering makes, by the ledger, beside closed forms. A free mass R gets the force of a spring
// S that integrates the velocity it is told: R's kinetic energy changes by (impulse)(mean of old and new velocity), S's
// by (mean of old and new force)(way), both exactly: what the ledger says that staggering makes must be what the total
// energy gains, to rounding. How much it is in a period follows from the schemes' amplification of x'' = -w^2 x, with
// h = w (window): without prediction the determinant of one window, 1 + h^2/2 (serial: v' = v - w^2 T x, x' = x +
// T (v + v') / 2) and 1 + h^2 (parallel: explicit Euler); with prediction the parallel scheme is Adams-Bashforth 2 or
// 3, whose principal roots have |z| = 1 + h^4/4 and 1 - 3 h^4/8 to leading order (expand z^2 - z = i h (3 z - 1) / 2,
// and likewise), and the serial one, whose other half is the trapezoidal rule, has half of that. The notion: Piperno,
// Farhat, Comput. Methods Appl. Mech. Engrg. 190 (2001) 3147.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/toys.hpp"
#include "tests/support/verification.hpp"

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double stiffness = 4 * pi * pi;  // N/m; the mass is 1 kg and starts at rest 1 m away: the period is 1 s
constexpr int steps = 20;                  // a window; quadratics are integrated by midpoints, to 1 / (12 steps^2)

struct Energies
{
    std::vector<double> kinetic, elastic;  //!< J, at the ends of the windows
    nlohmann::json books;                  //!< of the force, by the mass
    std::string warnings, error;           //!< of the mass

    double total(std::size_t window) const { return kinetic[window] + elastic[window]; }
    double made() const { return books.at("energy").at("made [J]"); }
};

in_threads::Solve mass(std::vector<double>& energy)
{
    return [&](sluice::Participant& self) {
        self.config().finish();
        double v = 0;
        self.keeps([&](sluice::State& s) { s.put_number("v", v); }, [&](sluice::State const& s) { v = s.number("v"); });
        auto tell = [&] { self.write("spring", "motion", toys::one_point, {std::span(&v, 1)}); };
        tell();
        energy.assign(1, 0);
        for (sluice::Window const& window : self.windows()) {
            auto force = self.read("spring", "force", window);
            double const h = window.length / steps;
            for (int k = 0; k < steps; ++k) v += h * force.columns(window.begin + (k + 0.5) * h)[0][0];
            tell();
            if (self.accepted(window)) energy.push_back(v * v / 2);
        }
    };
}

in_threads::Solve spring(std::vector<double>& energy)
{
    return [&](sluice::Participant& self) {
        self.config().finish();
        double x = 1, force = 0;
        self.keeps([&](sluice::State& s) { s.put_number("x", x); }, [&](sluice::State const& s) { x = s.number("x"); });
        auto tell = [&] {
            force = -stiffness * x;
            self.write("mass", "force", toys::one_point, {std::span(&force, 1)});
        };
        tell();
        energy.assign(1, stiffness / 2);
        for (sluice::Window const& window : self.windows()) {
            auto motion = self.read("mass", "motion", window);
            double const h = window.length / steps;
            for (int k = 0; k < steps; ++k) x += h * motion.columns(window.begin + (k + 0.5) * h)[0][0];
            tell();
            if (self.accepted(window)) energy.push_back(stiffness / 2 * x * x);
        }
    };
}

//! `forth`: the velocity's edge, `back`: the force's.
Energies run(int windows, int per_period, std::string const& forth, std::string const& back,
             std::string const& more = "ledger: {energy: {every: 1, tolerance: 10}}\n", bool fails = false)
{
    auto const scene = fmt::format(R"(sluice: 1
time: {{end: {}, window: {}}}
data: {{motion: {{columns: {{velocity: {{unit: m/s}}}}}}, force: {{columns: {{force: {{unit: N}}}}}}}}
participants: {{mass: {{command: none}}, spring: {{command: none}}}}
couplings:
  - {{from: mass, to: spring, data: motion, {}}}
  - {{from: spring, to: mass, data: force, {}}}
{})",
                                   static_cast<double>(windows) / per_period, 1.0 / per_period, forth, back, more);
    Energies result;
    in_threads::Scratch scratch;
    auto const outcome =
        in_threads::run(scene, {{"mass", mass(result.kinetic)}, {"spring", spring(result.elastic)}}, scratch.path());
    result.error = outcome.errors[0];
    for (auto const& error : outcome.errors) REQUIRE((error == "") != fails);
    nlohmann::json summary;
    std::ifstream(scratch.path() / "run/.sluice/mass.json") >> summary;
    result.books = summary.at("ledger").at(0);
    result.warnings = summary.at("warnings").dump();
    return result;
}

struct Scheme
{
    std::string name, forth, back;
    int order;      //!< of the energy made in a period, in h
    double factor;  //!< c: a window multiplies the energy by 1 + c h^(order + 1)
};

std::vector<Scheme> const schemes{
    {"serial, no prediction", "lag: 0", "lag: 1", 1, 1.0 / 2},
    {"serial, linear", "lag: 0", "lag: 1, predict: linear", 3, 1.0 / 4},
    {"serial, quadratic", "lag: 0", "lag: 1, predict: quadratic", 3, -3.0 / 8},
    {"parallel, no prediction", "lag: 1", "lag: 1", 1, 1},
    {"parallel, linear", "lag: 1, predict: linear", "lag: 1, predict: linear", 3, 1.0 / 2},
    {"parallel, quadratic", "lag: 1, predict: quadratic", "lag: 1, predict: quadratic", 3, -3.0 / 4},
};

}  // namespace

TEST_CASE("C09d: what the ledger says that staggering makes is what the total energy gains, to rounding")
{
    std::vector<Scheme> all = schemes;
    all.push_back({"serial, no prediction, velocity held", "lag: 0, sample: hold", "lag: 1", 0, 0});
    for (auto const& scheme : all) {
        verification::Stopwatch watch;
        int const windows = 250;
        auto const e = run(windows, 100, scheme.forth, scheme.back);
        // the last window's force is not waited for: its work is not booked
        double const gained = e.total(windows - 1) - e.total(0);
        CHECK(e.books.at("energy").at("windows") == windows - 1);
        CHECK(e.books.at("energy").at("closes to").get<double>() < 1e-12);
        // rounding of 249 sums of 20 steps, relative to an energy of about 20 J
        CHECK(verification::report({"C09d", "total energy gained, " + scheme.name + " [J]", e.made(), gained,
                                    std::abs(e.made() - gained), 1e-11, watch.seconds()}));
    }
}

TEST_CASE("C09d: staggering makes the energy of the closed form in a period, of order 1 or 3")
{
    std::printf("%-26s %8s %14s %14s %8s\n", "scheme", "windows", "made / E", "closed form", "order");
    for (auto const& scheme : schemes) {
        verification::Stopwatch watch;
        double before = 0, made = 0, order = 0, expected = 0;
        for (int per_period : {100, 200}) {
            // the second period: in the first windows prediction has no history
            auto const one = run(per_period + 1, per_period, scheme.forth, scheme.back),
                       two = run(2 * per_period + 1, per_period, scheme.forth, scheme.back);
            before = made;
            made = (two.made() - one.made()) / one.total(static_cast<std::size_t>(per_period));
            expected =
                std::expm1(per_period * std::log1p(scheme.factor * std::pow(2 * pi / per_period, scheme.order + 1)));
            if (before != 0) order = std::log2(std::log1p(before) / std::log1p(made));
            std::printf("%-26s %8d %14.4e %14.4e %8.3f\n", scheme.name.c_str(), per_period, made, expected, order);
        }
        // what is left out is h^2 = 1e-3 times a few
        CHECK(verification::report({"C09d", "energy made in a period, " + scheme.name + ", 200 windows", made, expected,
                                    std::abs(made / expected - 1), 5e-3, watch.seconds()}));
        CHECK(verification::report({"C09d", "order of the energy made, " + scheme.name, order,
                                    static_cast<double>(scheme.order), std::abs(order - scheme.order), 0.02,
                                    watch.seconds()}));
    }
}

TEST_CASE("C09d: an implicit group makes no energy")
{
    for (auto const* const back : {"lag: 1", "lag: 1, predict: linear"}) {
        verification::Stopwatch watch;
        auto const e = run(201, 100, "lag: 0", back,
                           "implicit: [{participants: [mass, spring], tolerance: 1e-11}]\n"
                           "ledger: {energy: {every: 1}}\n");
        // each window's force is off by 1e-11 of itself, as is the work, of which 2 periods move 8 times 20 J
        CHECK(verification::report({"C09d", fmt::format("energy made, implicit, {} [J]", back), e.made(), 0,
                                    std::abs(e.made()), 1e-8, watch.seconds()}));
    }
}

TEST_CASE("C09d: staggering that makes more than allowed is warned of, or stops the run")
{
    auto const few = run(400, 20, "lag: 0", "lag: 1");
    CHECK(few.warnings == "[]");
    auto const warned = run(400, 20, "lag: 0", "lag: 1", "ledger: {energy: {every: 1, tolerance: 0.05}}\n");
    CHECK(warned.warnings.find("spring -> mass: force: staggering makes") != std::string::npos);
    auto const sampled = run(4000, 20, "lag: 0", "lag: 1", "ledger: {energy: {every: 7, tolerance: 0.05}}\n");
    CHECK(sampled.warnings.find("staggering makes") != std::string::npos);
    auto const predicted =
        run(400, 20, "lag: 0", "lag: 1, predict: linear", "ledger: {energy: {every: 1, tolerance: 0.05}}\n");
    CHECK(predicted.warnings == "[]");
    auto const off = run(400, 20, "lag: 0", "lag: 1", "ledger: {energy: {every: 0}}\n");
    CHECK(!off.books.contains("energy"));
    auto const stopped =
        run(400, 20, "lag: 0", "lag: 1", "ledger: {on-violation: stop, energy: {every: 1, tolerance: 0.05}}\n", true);
    CHECK(stopped.error.find("spring -> mass: force: staggering makes") != std::string::npos);
}
