#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/dem/measures.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! The sweeps D6 to D10 of the catalogue's part D: every run ends stable, or refused with a message.
namespace {

dem::Config read(std::string const& text)
{
    auto config = dem::read_config(sluice::read_yaml(text, "sweep.yaml"), 2, {0.0, -9.81, 0.0});
    config.loads = false;
    return config;
}

//! Two equal discs of 1 mm radius, far above a floor.
std::string const pair_scene =
    "density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n"
    "walls:\n  - {name: floor, point: [0, 0], normal: [0, 1]}\ngrains:\n";

std::string disc(double x, double y, double vx = 0.0, double vy = 0.0)
{
    char text[192];
    std::snprintf(text, sizeof text, "  - {position: [%.17g, %.17g], radius: 0.001, velocity: [%.17g, %.17g]}\n", x, y,
                  vx, vy);
    return text;
}

//! What a run shows while it goes on.
struct Course
{
    double gap = 0.0;      //!< of the energy ledger, largest, of its sum at the start
    double overlap = 0.0;  //!< largest, of a diameter
};

//! The step's error: energy of a spring as Verlet sees it swings by (w dt)^2/4 of itself, w = pi/t_c, in leading order.
double swing(double steps_per_contact)
{
    return 1.01 * std::pow(std::numbers::pi / steps_per_contact, 2) / 4;
}

Course run(dem::Solver<2>& solver, double step, double end)
{
    double const start = solver.energies().balance();
    Course course;
    while (solver.time() < end) {
        for (int k = 0; k < 100; ++k) solver.step(step);
        course.gap = std::max(course.gap, std::abs(solver.energies().balance() / start - 1));
        course.overlap = std::max(course.overlap, dem::contact_numbers(solver.setup(), solver.state()).largest_overlap);
    }
    return course;
}

std::optional<std::string> refusal(std::string const& text, double end)
{
    try {
        auto const config = read(text);
        auto solver = dem::make_solver<2>(config, {});
        while (solver.time() < end) solver.step(config.step);
    } catch (sluice::Error const& error) {
        return error.what();
    }
    return {};
}

bool contains(std::optional<std::string> const& text, char const* part)
{
    return text && text->find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("sweep D6: a collapse with steps of t_c/50 to t_c/5, of which the coarse ones are warned about")
{
    auto const text = scenes::column_text(150, 1.0);
    auto const whole = read(text);
    auto const packing = dem::pour_packing<2>(whole);
    double const contact_time = 50 * whole.step;
    double finest = 0;
    for (double const n : {50.0, 25.0, 15.5, 14.5, 10.0, 7.0, 5.1}) {
        verification::Stopwatch watch;
        char step[64], name[64];
        std::snprintf(step, sizeof step, "step: %.17g\n", contact_time / n);
        auto const config = read(text + step);
        CHECK(config.warnings.size() == (n < 15 ? 1 : 0));
        auto solver = dem::make_solver<2>(config, packing, dem::Ledger::on);
        double const before = dem::centre_of_mass(solver.grains()).x;
        auto const course = run(solver, config.step, 0.25);
        // C08's mark where no warning is given; where one is, what the catalogue grants a gas: 1e-3
        std::snprintf(name, sizeof name, "t_c/%g: ledger, largest gap / initial energy", n);
        CHECK(verification::report(
            {"sweep D6", name, course.gap, 0.0, course.gap, n > 15 ? 1e-4 : 1e-3, watch.seconds()}));
        auto const way = dem::centre_of_mass(solver.grains()).x / before - 1;
        if (n == 50.0) finest = way;
        CHECK(std::abs(way / finest - 1) < 0.15);  // D11's mark for run-outs, which differ from sample to sample
        CHECK(course.overlap < 0.02);
    }
    char step[64];
    std::snprintf(step, sizeof step, "step: %.17g\n", contact_time / 4.9);
    CHECK(contains(refusal(text + step, 0), "is too long (must be at most t_c/5"));
}

//! Minutes: only `./dev verify` runs it. Centres of mass tell more of a small column than its front, a single grain.
TEST_CASE("sweep D7: stiffness from 1e2 to 1e6 times the pressure, run-out" * doctest::skip())
{
    int const seeds = 24;
    //! Means over the seeds, with their standard errors.
    struct Sample
    {
        double front = 0, front_error = 0, centre = 0, centre_error = 0, overlap = 0;
    };
    auto const mean_of = [](std::vector<double> const& values, double& mean, double& error) {
        double square = 0;
        for (double const value : values) mean += value / seeds;
        for (double const value : values) square += (value - mean) * (value - mean);
        error = std::sqrt(square / (seeds - 1) / seeds);
    };
    auto const collapses = [&](double stiffness) {
        Sample mean;
        std::vector<double> fronts, centres;
        for (int seed = 1; seed <= seeds; ++seed) {
            auto text = scenes::column_text(200, 1.0);
            char more[64];
            std::snprintf(more, sizeof more, "normal_stiffness: %g", stiffness);
            text.replace(text.find("normal_stiffness: 1e6"), 21, more);
            text.replace(text.find("count: 200"), 10, "count: 200, seed: " + std::to_string(seed));
            auto const config = read(text);
            auto solver = dem::make_solver<2>(config, dem::pour_packing<2>(config));
            auto const before = dem::measure(solver);
            double overlap = 0;
            while (solver.time() < 6 * std::sqrt(before.height / 9.81)) {
                for (int k = 0; k < 200; ++k) solver.step(config.step);
                overlap = std::max(overlap, dem::contact_numbers(solver.setup(), solver.state()).largest_overlap);
            }
            auto const after = dem::measure(solver);
            fronts.push_back(after.front / before.front - 1);
            centres.push_back(after.centre_of_mass.x / before.centre_of_mass.x - 1);
            mean.overlap = std::max(mean.overlap, overlap);
        }
        mean_of(fronts, mean.front, mean.front_error);
        mean_of(centres, mean.centre, mean.centre_error);
        return mean;
    };
    double const pressure = 2650 * 0.82 * 9.81 * std::sqrt(200 * 1.4e-3 * 1.4e-3 * 0.785 / 0.82);
    auto const hardest = collapses(1e6 * pressure);
    for (double const ratio : {1e2, 1e3, 1e4, 1e5}) {
        verification::Stopwatch watch;
        auto const c = collapses(ratio * pressure);
        double const error = std::abs(c.centre / hardest.centre - 1);
        // two means of samples: the difference of equal ones is within two of its standard errors
        double const sampling = 2 * std::hypot(c.centre_error / c.centre, hardest.centre_error / hardest.centre);
        std::printf("sweep D7: k/P = %g: run-out %.3f +- %.3f (hardest %.3f +- %.3f), overlaps up to %.2g d\n", ratio,
                    c.front, c.front_error, hardest.front, hardest.front_error, c.overlap);
        char name[96];
        std::snprintf(name, sizeof name, "k/P = %g: way of the centre of mass (sampling %.1f %%)", ratio,
                      100 * sampling);
        bool const hard = ratio >= 1e4;  // the catalogue: 3 % from 1e4 on
        CHECK(verification::report(
            {"sweep D7", name, c.centre, hardest.centre, error, hard ? 0.03 + sampling : 0.5, watch.seconds()}));
        if (hard)
            CHECK(std::abs(c.front - hardest.front) <
                  0.03 * hardest.front + 2 * std::hypot(c.front_error, hardest.front_error));
    }
}

TEST_CASE(
    "sweep D8: discs that overlap at the start by 1 to 50 % of a diameter part with no more than their springs' energy")
{
    for (double const share : {0.009, 0.05, 0.2, 0.49}) {
        auto const config = read(pair_scene + disc(0.1, 0.5) + disc(0.1 + 0.002 * (1 - share), 0.5));
        CHECK(config.warnings.size() == (share > 0.01 ? 1 : 0));
        auto solver = dem::make_solver<2>(config, {}, dem::Ledger::on);
        double const springs = 0.5e6 * std::pow(0.002 * share, 2), start = solver.energies().balance();
        CHECK(solver.energies().elastic() == close_to(springs));
        double gap = 0;
        for (int n = 0; n < 1000; ++n) {
            solver.step(config.step);
            gap = std::max(gap, std::abs(solver.energies().balance() - start) / springs);
        }
        auto const& motion = solver.grains().motion;
        double const away = motion[1].velocity.x - motion[0].velocity.x, m = solver.grains().mass[0];
        CHECK(away > 0.0);
        CHECK(0.25 * m * away * away < springs);  // the dashpot took its share
        CHECK(gap < swing(50));
    }
    // a heap of 5 x 5, each 20 % within its neighbours
    std::string heap = pair_scene;
    for (int k = 0; k < 25; ++k) heap += disc(0.1 + 0.0016 * (k % 5), 0.05 + 0.0016 * (k / 5));
    auto const config = read(heap);
    CHECK(config.warnings.size() == 1);
    auto solver = dem::make_solver<2>(config, {}, dem::Ledger::on);
    CHECK(run(solver, config.step, 0.02).gap < swing(50));
}

TEST_CASE("sweep D8: a disc whose centre lies within another one is refused, and so are two in one place")
{
    for (double const apart : {0.99e-3, 1e-6, 0.0})
        CHECK(contains(refusal(pair_scene + disc(0.1, 0.01) + disc(0.1 + apart, 0.01), 0),
                       "sweep.yaml:5:1: grains: the centre of grain 1 lies within grain 0 (must be outside)"));
    CHECK(!refusal(pair_scene + disc(0.1, 0.01) + disc(0.10101, 0.01), 0));
}

namespace {

//! A column of so many discs (stiffness in N/m), the largest `ratio` times the smallest, with as much mass in every
//! doubling of size.
void check_sizes(double ratio, int count, double stiffness, int steps)
{
    verification::Stopwatch watch;
    char text[640];
    std::snprintf(text, sizeof text,
                  "density: 2650\ndiameter: {min: 1.0e-3, max: %.17g, law: fractal, fractal_dimension: 2}\n"
                  "contact: {normal_stiffness: %g, damping_ratio: 0.2, friction_angle: 26}\n"
                  "walls:\n  - {name: floor, point: [0, 0], normal: [0, 1]}\n"
                  "  - {name: back, point: [0, 0], normal: [1, 0]}\n"
                  "column: {count: %d, aspect_ratio: 1, preparation: random, packing_fraction: 0.7}\n",
                  1e-3 * ratio, stiffness, count);
    auto config = dem::read_config(sluice::read_yaml(text, "sizes.yaml"), 2, {0.0, 0.0, 0.0});
    auto packing = dem::pour_packing<2>(config);
    config.gravity = {0.0, -9.81, 0.0};
    auto solver = dem::make_solver<2>(config, packing, dem::Ledger::on);
    auto const [least, most] = std::minmax_element(solver.grains().place.begin(), solver.grains().place.end(),
                                                   [](auto const& a, auto const& b) { return a.radius < b.radius; });
    double const seen = most->radius / least->radius;
    CHECK(seen > 0.8 * ratio);
    CHECK(solver.grains().size() == static_cast<std::size_t>(count));
    auto const course = run(solver, config.step, steps * config.step);
    char name[96];
    std::snprintf(name, sizeof name, "%d discs, sizes 1 : %.1f, dropped: ledger gap", count, seen);
    CHECK(verification::report({"sweep D9", name, course.gap, 0.0, course.gap, 1e-4, watch.seconds()}));
    CHECK(course.overlap < 0.05);
    CHECK(dem::centre_of_mass(solver.grains()).y > 0.0);
}

}  // namespace

TEST_CASE("sweep D9: discs of sizes 1 to 1.8, 5 and 20 are dropped")
{
    for (double const ratio : {1.8, 5.0, 20.0}) check_sizes(ratio, 2000, 1e6, 5000);
}

//! Minutes: only `./dev verify` runs it.
TEST_CASE("sweep D9: 100 000 discs of sizes 1 to 20 are dropped" * doctest::skip())
{
    check_sizes(20.0, 100'000, 1e7, 20'000);  // a column of a metre
}

TEST_CASE("sweep D10: a disc that is too fast for its springs or its step is refused, slower ones bounce")
{
    int refused = 0, bounced = 0;
    for (double const speed : {1.0, 10.0, 20.0, 30.0, 60.0, 100.0, 200.0, 240.0, 300.0, 1000.0}) {
        double const end = 0.02 / speed;
        auto const pair = refusal(pair_scene + disc(0.1, 0.5, speed) + disc(0.11, 0.5), end);
        auto const wall = refusal(pair_scene + disc(0.1, 0.01, 0.0, -speed), end);
        for (auto const& [what, why] : {std::pair{pair, "the centre of grain 1 lies within grain 0 at t ="},
                                        std::pair{wall, "the centre of grain 0 is behind wall \"floor\" at t ="}}) {
            if (what) CHECK((contains(what, why) || contains(what, "moves by more than the smallest radius")));
            ++(what ? refused : bounced);
        }
        if (!pair) {
            auto const config = read(pair_scene + disc(0.1, 0.5, speed) + disc(0.11, 0.5));
            auto solver = dem::make_solver<2>(config, {}, dem::Ledger::on);
            CHECK(run(solver, config.step, end).gap < swing(50));
            CHECK(solver.grains().place[0].centre.x < solver.grains().place[1].centre.x);
        }
    }
    CHECK(refused >= 10);
    CHECK(bounced >= 4);
}
