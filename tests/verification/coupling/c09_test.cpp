// C09a, C09b: the order of accuracy of the staggered schemes, through the real coupler with two trivial solvers.
// Reference values and pass marks: C09a_coupled_drag_order.csv and C09b_two_mass_oscillator.csv of the catalogue; the
// closed forms are evaluated here, the table's scheme predictions are quoted.

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <mutex>

#include "tests/support/run_in_threads.hpp"
#include "tests/support/toys.hpp"
#include "tests/support/verification.hpp"

namespace {

constexpr double pi = 3.14159265358979323846;

// ---- C09b: m1 = m2 = 1, k = 4 pi^2, 16 pi^2, 4 pi^2, x(0) = (1, 0): x = sum of cos(2 pi t) and cos(6 pi t)

double exact_place(int mass, double t)
{
    double const slow = std::cos(2 * pi * t), fast = std::cos(6 * pi * t);
    return mass == 1 ? (slow + fast) / 2 : (slow - fast) / 2;
}

std::string oscillator_scene(int windows, int steps, std::string const& back, std::string const& forth)
{
    return fmt::format(R"(sluice: 1
title: two masses
time: {{end: 1, window: {}}}
data: {{place: {{columns: {{place: {{unit: m}}}}}}}}
participants:
  left:  {{command: none, config: {{mass: 1, wall_spring: {}, middle_spring: {}, place: 1, steps: {}}}}}
  right: {{command: none, config: {{mass: 1, wall_spring: {}, middle_spring: {}, place: 0, steps: {}}}}}
couplings:
  - {{from: left, to: right, data: place, {}}}
  - {{from: right, to: left, data: place, {}}}
)",
                       1.0 / windows, 4 * pi * pi, 16 * pi * pi, steps, 4 * pi * pi, 16 * pi * pi, steps, forth, back);
}

//! Largest error of both places over the whole trajectory. Never at t = 1 alone: that is the period, of order 3.
double oscillator_error(int windows, int steps, std::string const& back, std::string const& forth)
{
    double worst[2] = {0, 0};
    auto watch = [&](int mass) {
        return [&worst, mass](double t, double x) {
            worst[mass - 1] = std::max(worst[mass - 1], std::abs(x - exact_place(mass, t)));
        };
    };
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(oscillator_scene(windows, steps, back, forth),
                                         {{"left", [&](auto& self) { toys::oscillator(self, watch(1)); }},
                                          {"right", [&](auto& self) { toys::oscillator(self, watch(2)); }}},
                                         scratch.path());
    for (auto const& error : outcome.errors) REQUIRE(error == "");
    return std::max(worst[0], worst[1]);
}

void check_oscillator_order(std::string const& scheme, std::string const& back, std::string const& forth, int steps,
                            double order, double mark)
{
    verification::Stopwatch watch;
    double coarse = 0, fine = 0;
    for (int windows : {100, 200, 400}) {
        coarse = fine;
        fine = oscillator_error(windows, steps, back, forth);
    }
    double const observed = std::log2(coarse / fine);
    CHECK(verification::report({"C09b", fmt::format("order, {}, {} steps, err(400) {:.2e}", scheme, steps, fine),
                                observed, order, std::max(0.0, order - observed), order - mark, watch.seconds()}));
}

// ---- C09a: m_p v' = -k (v - u) + m_p g, m_f u' = k (v - u); m_p = 1, m_f = 4, k = 1, g = 0.5, v(0) = 1, u(0) = 0

constexpr double mp = 1, mf = 4, drag = 1, g = 0.5;
constexpr double exact_v = 0.757522302493;  // at T = 1, from the catalogue

struct Momentum
{
    double v = 0, u = 0;
    double defect = 0;  //!< largest | m_p v + m_f u - (m_p + m_p g t) | over the run
};

//! Particle under linear drag. Serial: integrates its window by `rk4` steps and sends the impulse that the fluid gets.
void particle(sluice::Participant& self, Momentum& result)
{
    auto r = self.config();
    self.sends({"impulse"});
    self.takes({"velocity"});
    r.finish();
    double v = 1, impulse = 0;
    auto tell = [&] { self.write("fluid", "impulse", toys::one_point, {std::span(&impulse, 1)}); };
    tell();
    for (sluice::Window const& window : self.windows()) {
        auto u = self.read("fluid", "velocity", window);
        double const before = v;
        constexpr int steps = 50;
        double const h = window.length / steps;
        for (int k = 0; k < steps; ++k) {
            double const t = window.begin + k * h;
            auto slope = [&](double at, double value) { return -drag / mp * (value - u.columns(at)[0][0]) + g; };
            double const k1 = slope(t, v), k2 = slope(t + h / 2, v + h / 2 * k1), k3 = slope(t + h / 2, v + h / 2 * k2),
                         k4 = slope(t + h, v + h * k3);
            v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        }
        impulse = mp * (before - v + g * window.length);
        tell();
    }
    result.v = v;
}

void fluid(sluice::Participant& self, Momentum& result)
{
    auto r = self.config();
    r.finish();
    double u = 0;
    auto tell = [&] { self.write("particle", "velocity", toys::one_point, {std::span(&u, 1)}); };
    tell();
    for (sluice::Window const& window : self.windows()) {
        u += self.read("particle", "impulse", window).columns(window.end)[0][0] / mf;
        tell();
    }
    result.u = u;
}

Momentum run_drag(int windows, std::string const& predict)
{
    auto const scene = fmt::format(R"(sluice: 1
time: {{end: 1, window: {}}}
data:
  impulse: {{columns: {{impulse: {{unit: N s}}}}}}
  velocity: {{columns: {{velocity: {{unit: m/s}}}}}}
participants:
  particle: {{command: none}}
  fluid: {{command: none}}
couplings:
  - {{from: particle, to: fluid, data: impulse, lag: 0}}
  - {{from: fluid, to: particle, data: velocity, lag: 1, predict: {}}}
)",
                                   1.0 / windows, predict);
    Momentum result;
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(scene,
                                         {{"particle", [&](auto& self) { particle(self, result); }},
                                          {"fluid", [&](auto& self) { fluid(self, result); }}},
                                         scratch.path());
    for (auto const& error : outcome.errors) REQUIRE(error == "");
    result.defect = std::abs(mp * result.v + mf * result.u - (mp + mp * g));
    return result;
}

//! Both lag 1: each takes an explicit Euler step with the partner's state at the window's start ("jacobi_force").
double run_parallel_drag(int windows)
{
    auto const scene = fmt::format(R"(sluice: 1
time: {{end: 1, window: {}}}
data: {{velocity: {{columns: {{velocity: {{unit: m/s}}}}}}}}
participants: {{particle: {{command: none}}, fluid: {{command: none}}}}
couplings:
  - {{from: particle, to: fluid, data: velocity, lag: 1}}
  - {{from: fluid, to: particle, data: velocity, lag: 1}}
)",
                                   1.0 / windows);
    double final_v = 0;
    auto euler = [&](double start, double mass, double weight, char const* partner, double* out) {
        return [=](sluice::Participant& self) {
            self.config().finish();
            double x = start;
            self.write(partner, "velocity", toys::one_point, {std::span(&x, 1)});
            for (sluice::Window const& window : self.windows()) {
                double const other = self.read(partner, "velocity", window).columns(window.begin)[0][0];
                x += window.length * (drag / mass * (other - x) + weight);
                self.write(partner, "velocity", toys::one_point, {std::span(&x, 1)});
            }
            if (out) *out = x;
        };
    };
    in_threads::Scratch scratch;
    auto const outcome = in_threads::run(
        scene, {{"particle", euler(1, mp, g, "fluid", &final_v)}, {"fluid", euler(0, mf, 0, "particle", nullptr)}},
        scratch.path());
    for (auto const& error : outcome.errors) REQUIRE(error == "");
    return final_v;
}

}  // namespace

TEST_CASE("C09b: serial staggering without prediction is of order 1, with 1 and 10 sub-steps")
{
    for (int steps : {1, 10}) check_oscillator_order("frozen", "lag: 1", "lag: 0, sample: hold", steps, 1.0, 0.9);
}

TEST_CASE("C09b: serial staggering with linear prediction and sampling is of order 2, one exchange a window")
{
    for (int steps : {1, 10}) check_oscillator_order("predicted", "lag: 1, predict: linear", "lag: 0", steps, 2.0, 1.9);
}

TEST_CASE("C09b: parallel staggering with linear prediction is of order 2")
{
    check_oscillator_order("parallel", "lag: 1, predict: linear", "lag: 1, predict: linear", 10, 2.0, 1.9);
}

TEST_CASE("C09a: the serial scheme has the catalogue's errors and conserves momentum to rounding")
{
    // abs_err_v of scheme `serial` at N = 10, 20, 40, 80; "errors equal to the table within 1 %", defect 1e-14 N
    double const table[][2] = {{10, 5.163690576e-3}, {20, 2.541002431e-3}, {40, 1.26052225e-3}, {80, 6.277943481e-4}};
    for (auto const& [windows, reference] : table) {
        verification::Stopwatch watch;
        auto const run = run_drag(static_cast<int>(windows), "none");
        double const error = std::abs(run.v - exact_v);
        CHECK(verification::report({"C09a", fmt::format("error of v(T), serial, N = {}", windows), error, reference,
                                    std::abs(error / reference - 1), 0.01, watch.seconds()}));
        CHECK(verification::report({"C09a", fmt::format("momentum defect, serial, N = {}", windows), run.defect, 0.0,
                                    run.defect, 1e-14 * windows, watch.seconds()}));
    }
}

TEST_CASE("C09a: linear prediction makes it order 2 and keeps momentum")
{
    verification::Stopwatch watch;
    double coarse = 0, fine = 0;
    for (int windows : {40, 80, 160}) {
        auto const run = run_drag(windows, "linear");
        coarse = fine;
        fine = std::abs(run.v - exact_v);
        CHECK(run.defect <= 1e-14 * windows);
    }
    double const order = std::log2(coarse / fine);
    CHECK(verification::report({"C09a", fmt::format("order, serial with prediction, err(160) {:.2e}", fine), order, 2.0,
                                std::abs(order - 2), 0.1, watch.seconds()}));
}

TEST_CASE("C09a: the parallel scheme has the catalogue's errors")
{
    double const table[][2] = {{10, 1.124602593e-2}, {20, 5.494083346e-3}, {40, 2.716105212e-3}, {80, 1.350472177e-3}};
    for (auto const& [windows, reference] : table) {
        verification::Stopwatch watch;
        double const error = std::abs(run_parallel_drag(static_cast<int>(windows)) - exact_v);
        CHECK(verification::report({"C09a", fmt::format("error of v(T), parallel, N = {}", windows), error, reference,
                                    std::abs(error / reference - 1), 0.01, watch.seconds()}));
    }
}
