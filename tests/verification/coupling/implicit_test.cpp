// C09b and C09c with implicit groups: windows are repeated until the exchanged numbers converge. C09c is where explicit
// staggering must fail (closed form: the error is multiplied by -C_A rho_f / rho_s in every window, whatever its
// length) and implicit coupling must not. Table: C09c_added_mass_stability.csv of the catalogue.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/toys.hpp"
#include "tests/support/verification.hpp"

namespace {

constexpr double pi = 3.14159265358979323846;

struct Counted
{
    double worst = 0;  //!< largest error over all windows
    std::vector<double> errors;
    double iterations = 0;  //!< a window, on average
    std::string wrong;      //!< what went wrong, if anything
};

void note_outcome(Counted& counted, in_threads::Outcome const& outcome)
{
    for (auto const& error : outcome.errors)
        if (counted.wrong.empty()) counted.wrong = error;
}

// ---- C09c

//! What moves the body, per rho_f V; `wobble` makes it change from window to window.
double force(double t, double wobble)
{
    return 1 + wobble * std::sin(0.5 * t);
}

//! rho_s V a = F - reaction. Its state is nothing: each window stands for itself, but the reaction of the last one.
in_threads::Solve solid(double density, double added_mass, double wobble, Counted& counted)
{
    return [=, &counted](sluice::Participant& self) {
        self.config().finish();
        self.keeps([](sluice::State&) {}, [](sluice::State const&) {});
        double a = 0;
        auto tell = [&] { self.write("fluid", "acceleration", toys::one_point, {std::span(&a, 1)}); };
        tell();
        double computed = 0, windows = 0;
        for (sluice::Window const& window : self.windows()) {
            double const reaction = self.read("fluid", "reaction", window).columns(window.end)[0][0];
            a = (force(window.end, wobble) - reaction) / density;
            tell();
            ++computed;
            if (!self.accepted(window)) continue;
            ++windows;
            counted.errors.push_back(a - force(window.end, wobble) / (density + added_mass));
        }
        counted.iterations = computed / windows;
    };
}

//! The fluid that the body takes along: reaction = C_A rho_f V a.
in_threads::Solve fluid(double added_mass)
{
    return [=](sluice::Participant& self) {
        self.config().finish();
        self.keeps([](sluice::State&) {}, [](sluice::State const&) {});
        double reaction = 0;
        auto tell = [&] { self.write("solid", "reaction", toys::one_point, {std::span(&reaction, 1)}); };
        tell();
        for (sluice::Window const& window : self.windows()) {
            reaction = added_mass * self.read("solid", "acceleration", window).columns(window.end)[0][0];
            tell();
        }
    };
}

Counted added_mass_run(double density, double added_mass, double wobble, std::string const& implicit)
{
    auto const scene = R"(sluice: 1
time: {end: 20, window: 1}
data:
  acceleration: {columns: {acceleration: {unit: m/s2}}}
  reaction: {columns: {reaction: {unit: N}}}
participants: {solid: {command: none}, fluid: {command: none}}
couplings:
  - {from: solid, to: fluid, data: acceleration, sample: hold}
  - {from: fluid, to: solid, data: reaction, lag: 1, sample: hold}
)" + implicit;
    Counted counted;
    in_threads::Scratch scratch;
    note_outcome(
        counted,
        in_threads::run(scene, {{"solid", solid(density, added_mass, wobble, counted)}, {"fluid", fluid(added_mass)}},
                        scratch.path()));
    for (double const e : counted.errors) counted.worst = std::max(counted.worst, std::abs(e));
    return counted;
}

std::string group_of(std::string const& method, double relaxation)
{
    return fmt::format(
        "implicit: [{{participants: [solid, fluid], method: {}, relaxation: {}, tolerance: 1e-10, "
        "max_iterations: 500}}]\n",
        method, relaxation);
}

// ---- C09b, as in c09_test.cpp: x = (cos 2 pi t +- cos 6 pi t) / 2

//! One of the two masses, with `steps` of velocity Verlet in a window.
in_threads::Solve mass(int number, int steps, Counted& counted)
{
    return [=, &counted](sluice::Participant& self) {
        self.config().finish();
        std::string const partner = number == 1 ? "right" : "left";
        double x = number == 1 ? 1 : 0, v = 0;
        self.keeps(
            [&](sluice::State& s) {
                s.put_number("x", x);
                s.put_number("v", v);
            },
            [&](sluice::State const& s) {
                x = s.number("x");
                v = s.number("v");
            });
        auto tell = [&] { self.write(partner, "place", toys::one_point, {std::span(&x, 1)}); };
        tell();
        double computed = 0, windows = 0;
        for (sluice::Window const& window : self.windows()) {
            auto other = self.read(partner, "place", window);
            double const h = window.length / steps;
            auto pull = [&](double t) { return -4 * pi * pi * x - 16 * pi * pi * (x - other.columns(t)[0][0]); };
            for (int k = 0; k < steps; ++k) {
                v += h / 2 * pull(window.time(k, steps));
                x += h * v;
                v += h / 2 * pull(window.time(k + 1, steps));
            }
            tell();
            ++computed;
            if (!self.accepted(window)) continue;
            ++windows;
            double const t = window.end, slow = std::cos(2 * pi * t), fast = std::cos(6 * pi * t);
            counted.worst = std::max(counted.worst, std::abs(x - (number == 1 ? slow + fast : slow - fast) / 2));
        }
        counted.iterations = computed / windows;
    };
}

Counted oscillator_run(int windows, int steps, std::string const& forth, std::string const& back,
                       std::string const& implicit)
{
    auto const scene = fmt::format(R"(sluice: 1
time: {{end: 1, window: {}}}
data: {{place: {{columns: {{place: {{unit: m}}}}}}}}
participants: {{left: {{command: none}}, right: {{command: none}}}}
couplings:
  - {{from: left, to: right, data: place, {}}}
  - {{from: right, to: left, data: place, {}}}
{})",
                                   1.0 / windows, forth, back, implicit);
    Counted left, right;
    in_threads::Scratch scratch;
    note_outcome(left, in_threads::run(scene, {{"left", mass(1, steps, left)}, {"right", mass(2, steps, right)}},
                                       scratch.path()));
    left.worst = std::max(left.worst, right.worst);
    return left;
}

struct Scheme
{
    std::string name, forth, back, implicit;
    double order;      //!< by theory
    double exchanges;  //!< frames a window and iteration
};

}  // namespace

TEST_CASE("C09c: explicit staggering multiplies the error by the table's ratio and fails where the body is light")
{
    struct Row
    {
        double density, disc;
    };
    for (Row const& row : {Row{2.65, -0.3773584906}, {1.1, -0.9090909091}, {0.9, -1.111111111}, {0.1, -10}}) {
        verification::Stopwatch watch;
        auto const run = added_mass_run(row.density, 1.0, 0.0, "");
        REQUIRE(run.wrong == "");
        double const ratio = run.errors[1] / run.errors[0], grown = std::abs(run.errors.back() / run.errors.front());
        CHECK(verification::report({"C09c", fmt::format("error ratio, explicit, rho_s/rho_f = {}", row.density), ratio,
                                    row.disc, std::abs(ratio - row.disc), 1e-9, watch.seconds()}));
        CHECK((grown > 1) == (row.disc < -1));
    }
}

TEST_CASE("C09c: implicit coupling converges where explicit staggering fails")
{
    // F / (rho_s + C_A) is reached to the tolerance: |error| <= 1e-10 |a| times the amplification 1 / (1 + m) of the
    // map
    for (double const density : {2.65, 1.1, 0.9, 0.5, 0.1})
        for (std::string const method : {"constant", "aitken", "iqn-ils"}) {
            verification::Stopwatch watch;
            double const limit = 2 / (1 + 1 / density);  // constant relaxation is stable below it
            double const relaxation = method == "constant" ? limit / 2 : 0.5 * std::min(1.0, limit);
            auto const run = added_mass_run(density, 1.0, 0.2, group_of(method, relaxation));
            REQUIRE(run.wrong == "");
            CHECK(verification::report(
                {"C09c", fmt::format("error, {}, rho_s/rho_f = {}, {:.1f} iterations", method, density, run.iterations),
                 run.worst, 0, run.worst, 1e-9, watch.seconds()}));
            CHECK(run.iterations <=
                  8);  // scalar and linear: 3 by Aitken's and the secant method, 2 with the best factor
        }
}

TEST_CASE("C09b: schemes, their orders, iterations and exchanges")
{
    std::string const iqn = "implicit: [{participants: [left, right], tolerance: 1e-9}]\n",
                      aitken = "implicit: [{participants: [left, right], method: aitken, tolerance: 1e-9}]\n";
    std::vector<Scheme> const schemes{
        {"serial, no prediction", "lag: 0, sample: hold", "lag: 1", "", 1, 2},
        {"serial, linear prediction", "lag: 0", "lag: 1, predict: linear", "", 2, 2},
        {"serial, quadratic prediction", "lag: 0", "lag: 1, predict: quadratic", "", 2, 2},
        {"parallel, no prediction", "lag: 1", "lag: 1", "", 1, 2},
        {"parallel, linear prediction", "lag: 1, predict: linear", "lag: 1, predict: linear", "", 2, 2},
        {"implicit serial, iqn-ils", "lag: 0", "lag: 1, predict: linear", iqn, 2, 2},
        {"implicit serial, aitken", "lag: 0", "lag: 1, predict: linear", aitken, 2, 2},
        {"implicit parallel, iqn-ils", "lag: 1, predict: linear", "lag: 1, predict: linear", iqn, 2, 2}};
    std::printf("%-30s %8s %12s %14s %20s\n", "scheme", "order", "error (400)", "iterations", "exchanges a window");
    for (auto const& scheme : schemes) {
        verification::Stopwatch watch;
        Counted coarse, fine;
        for (int windows : {200, 400}) {
            coarse = fine;
            fine = oscillator_run(windows, 10, scheme.forth, scheme.back, scheme.implicit);
            REQUIRE(fine.wrong == "");
        }
        double const order = std::log2(coarse.worst / fine.worst);
        std::printf("%-30s %8.3f %12.3e %14.2f %20.1f\n", scheme.name.c_str(), order, fine.worst, fine.iterations,
                    scheme.exchanges * fine.iterations);
        CHECK(verification::report({"C09b", "order, " + scheme.name, order, scheme.order,
                                    std::max(0.0, scheme.order - order), 0.1, watch.seconds()}));
    }
}
