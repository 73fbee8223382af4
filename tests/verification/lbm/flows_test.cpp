#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/verification/lbm/cavity.hpp"
#include "tests/verification/lbm/channel_cylinder.hpp"

//! Flows with tables of others: the lid-driven cavity, the cylinder in a channel, an oscillating channel.
using namespace lattice_case;

namespace {

void check_cavity(Cavity const& c)
{
    verification::Stopwatch const watch;
    double const error = cavity_error(c, 128, 0.05);
    CHECK(verification::report({"L04", text("RMS of 30 points / U at Re=%.0f, N=%.0f [-]", c.reynolds, 128), error, 0,
                                error, c.mark, watch.seconds()}));
}

}  // namespace

TEST_CASE("L04: lid-driven cavity, 128 cells, Re = 400")
{
    check_cavity(cavities()[1]);
}

TEST_CASE("L04: lid-driven cavity, 128 cells, Re = 100 and 1000" * doctest::skip())
{
    check_cavity(cavities()[0]);
    check_cavity(cavities()[2]);
}

TEST_CASE("L04: the same in central moments" * doctest::skip())
{
    for (Cavity const& c : cavities()) {
        verification::Stopwatch const watch;
        double const error = cavity_error(c, 128, 0.05, {.collision = lbm::Operator::central});
        CHECK(
            verification::report({"L04", text("central, RMS of 30 points / U at Re=%.0f, N=%.0f [-]", c.reynolds, 128),
                                  error, 0, error, c.mark, watch.seconds()}));
    }
}

namespace {

//! From 32 to `fine` cells.
void check_order(std::ptrdiff_t fine)
{
    verification::Stopwatch const watch;
    Cavity const c = cavities()[1];
    // compressibility goes with the square of the lid's speed: with the cell, all errors are of second order
    double const ratio = static_cast<double>(fine) / 32;
    double const coarse_error = cavity_error(c, 32, 0.1), fine_error = cavity_error(c, fine, 0.1 / ratio);
    std::printf("L04   Re = 400: N = 32 %.2e, N = %td %.2e\n", coarse_error, fine, fine_error);
    double const order = std::log(coarse_error / fine_error) / std::log(ratio);
    CHECK(verification::report(
        {"L04", text("order in dx from 32 to %.0f cells [-] (at least 1.7)", static_cast<double>(fine), 0), order, 2,
         std::max(0.0, 2 - order), 0.3, watch.seconds()}));
}

}  // namespace

TEST_CASE("L04: order of the error at Re = 400, 32 to 64 cells, the lid's speed with the cell")
{
    check_order(64);
}

TEST_CASE("L04: order of the error at Re = 400, 32 to 128 cells, the lid's speed with the cell" * doctest::skip())
{
    check_order(128);
}

namespace {

//! What single precision adds at Re = 400, by the lid's speed u. Mark: rounding may act as a force of 2^-24 u a step,
//! inertia as u^2/N.
void compare_precisions(std::ptrdiff_t n, double lid)
{
    verification::Stopwatch const watch;
    Cavity const c = cavities()[1];
    Box exact(n, lid, c.reynolds), rounded(n, lid, c.reynolds, {.precision = lbm::Precision::float32});
    run_until_steady(exact, &rounded);
    auto const a = exact.at_points(c), b = rounded.at_points(c);
    double const added = root_mean_square(a, b);
    std::printf("L04   N = %td, lid %g: double off by %.2e, single by %.2e\n", n, lid, root_mean_square(a, table_of(c)),
                root_mean_square(b, table_of(c)));
    CHECK(verification::report({"L04", text("single precision adds, N=%.0f, lid %g [U]", static_cast<double>(n), lid),
                                added, 0, added, std::ldexp(static_cast<double>(n) / lid, -24), watch.seconds()}));
}

}  // namespace

TEST_CASE("L04: what single precision adds at Re = 400, 64 cells")
{
    compare_precisions(64, 0.05);
}

TEST_CASE("L04: the same by the lid's speed" * doctest::skip())
{
    for (double const lid : {0.15, 0.1, 0.02, 0.01, 0.005}) compare_precisions(64, lid);
}

namespace {

void report_interval(char const* flow, char const* what, std::ptrdiff_t cells, double value, double low, double high,
                     double reference, verification::Stopwatch const& watch)
{
    char name[60];
    std::snprintf(name, sizeof name, "%s %s, d=%td dx (%g to %g)", flow, what, cells, low, high);
    CHECK(verification::report(
        {"L05", name, value, reference, std::abs(value - 0.5 * (high + low)), 0.5 * (high - low), watch.seconds()}));
}

void report_steady(std::ptrdiff_t cells, lbm::Precision precision = lbm::Precision::float64)
{
    verification::Stopwatch const watch;
    Forces const got = steady_cylinder(cells, {.precision = precision});
    char const* const flow = precision == lbm::Precision::float64 ? "2D-1" : "2D-1 single";
    auto const check = [&](char const* what, double value, double low, double high, double reference) {
        report_interval(flow, what, cells, value, low, high, reference, watch);
    };
    // intervals of the file
    check("c_D", got.drag, 5.52, 5.64, 5.57953523);
    check("c_L", got.lift, 0.008, 0.0135, 0.01061895);
    double const slack = cells < 40 ? 4 : 1;  // second order: the interval is for 40 cells
    check("dp [Pa]", got.pressure_drop, 0.1175 - 0.0015 * slack, 0.1175 + 0.0015 * slack, 0.11752017);
    double const half_cell = 0.05 / static_cast<double>(cells);  // of each end, the surface and where the flow turns
    check("length behind [m]", got.recirculation, 0.0846 - half_cell, 0.0846 + half_cell, 0.0846);
}

//! 2D-2 (Re = 100) once vortices are shed evenly. Intervals of the file.
void report_shedding(std::ptrdiff_t cells, Variant const& variant, bool absorbing)
{
    verification::Stopwatch const watch;
    Cylinder const c(cells, 1.5, 0.08, variant);
    lbm::Config config = c.config;
    config.walls[lbm::right].absorbing = absorbing;
    lbm::Solver<2> solver(config);
    std::vector<double> const position{0.2, 0.2}, rest{0, 0}, spin{0}, radius{0.05};
    solver.set_bodies({position, rest, spin, radius});
    while (solver.time() < 6) solver.step();
    double drag = 0, lift = 0, before = 0;
    std::vector<double> upward;  // times at which the lift crosses zero, rising
    while (solver.time() < 9) {
        solver.step();
        double const now = solver.loads().force[1];
        drag = std::max(drag, c.coefficient(solver.loads().force[0]));
        lift = std::max(lift, c.coefficient(now));
        if (before < 0 && now >= 0) upward.push_back(solver.time() - config.step * now / (now - before));
        before = now;
    }
    REQUIRE(upward.size() > 4);
    double const period = (upward.back() - upward.front()) / static_cast<double>(upward.size() - 1);
    std::string const flow = of_surface(variant.surface, "2D-2");
    auto const check = [&](char const* what, double value, double low, double high, double reference) {
        report_interval(flow.c_str(), what, cells, value, low, high, reference, watch);
    };
    check("largest c_D", drag, 3.14, 3.32, 3.2274);
    check("largest c_L", lift, 0.93, 1.07, 0.9866);
    check("Strouhal number", 0.1 / (period * c.mean_velocity), 0.292, 0.308, 0.3018);
}

}  // namespace

TEST_CASE("L05: cylinder in a channel at Re = 20, d = 20 cells")
{
    report_steady(20);
}

TEST_CASE("L05: the same in single precision" * doctest::skip())
{
    report_steady(20, lbm::Precision::float32);
}

TEST_CASE("L05: cylinder in a channel at Re = 20, d = 40 cells" * doctest::skip())
{
    report_steady(40);
}

//! Minutes: only `./dev verify` runs it.
TEST_CASE("L05: cylinder in a channel at Re = 100, d = 40 cells" * doctest::skip())
{
    report_shedding(40, {}, false);
}

//! A minute.
TEST_CASE("L05: the same with an interpolated surface and an outlet that absorbs sound" * doctest::skip())
{
    report_shedding(40, {.surface = lbm::Surface::interpolated}, true);
}
