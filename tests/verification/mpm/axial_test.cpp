#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "participants/mpm/measures.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/verification/mpm/bars.hpp"
#include "tests/verification/mpm/ledger_drift.hpp"

using namespace verification;

namespace {

//! A cylinder of radii 1 and 2 m under pressure from within, at rest: Lame's, plane strain,
//!     s_rr = A - B/r^2,   s_tt = A + B/r^2,   u = (1 + nu)/E ((1 - 2 nu) A r + B/r),   A = p a^2/(b^2 - a^2), B = A
//!     b^2
//! Source: Timoshenko and Goodier, Theory of Elasticity (1951), sec. 26.
struct Cylinder
{
    double opening;  //!< relative error of the displacement of the innermost points
    double hoop;     //!< of s_tt: root of the mean square, by p
};

Cylinder thick_walled(int cells)
{
    double const pressure = 100, young = 1e6, nu = 0.3, density = 1000;
    mpm::Config c;
    c.symmetry = mpm::Symmetry::axial;
    c.cell = 1.0 / cells;
    c.origin = {0.5, 0, 0};
    c.size = {2, c.cell, 0};
    c.density = density;
    c.law = mpm::LinearElastic{{young, nu}};
    c.bodies.push_back({.low = {1, 0, 0}, .high = {2, c.cell, 0}});
    for (int side : {-1, 1}) c.walls.push_back({.axis = 1, .side = side, .place = side < 0 ? 0 : c.cell});
    double const speed = std::sqrt(mpm::Elasticity{young, nu}.wave() / density);
    c.damping = speed;  // half of the critical one of the gravest breathing, about speed / r
    auto setup = mpm::make_setup<2>(c);
    auto state = mpm::make_state<2>(c);
    for (std::size_t p = 0; p < state.points.size(); ++p)
        if (state.points[p].place[0] < 1 + 0.5 * c.cell)
            setup.tractions.push_back({p, 0, -1, mpm::Vec<2>(pressure, 0)});
    auto const start = state.points;
    mpm::Solver<2> solver(setup, state);
    while (solver.time() < 40 / speed) solver.step(solver.longest_step());
    double const A = pressure / 3, B = 4 * A;
    Cylinder error{0, 0};
    for (std::size_t p = 0; p < start.size(); ++p) {
        auto const& now = solver.state().points[p];
        double const r = start[p].place[0];
        double const exact = (1 + nu) / young * ((1 - 2 * nu) * A * r + B / r);
        if (r < 1 + 0.5 * c.cell) error.opening = std::abs((now.place[0] - r) / exact - 1);
        error.hoop += std::pow((now.matter.stress(2, 2) - (A + B / (r * r))) / pressure, 2);
    }
    error.hoop = std::sqrt(error.hoop / static_cast<double>(start.size()));
    return error;
}

//! A heap's run-out (r - r0)/r0 at a depth of 5 % of the root of its area in the plane, and its ledger.
struct Heap
{
    double run_out;
    LedgerDrift::Result ledger;
};

Heap heap(double aspect_ratio, int cells)
{
    double const radius = 0.1, height = aspect_ratio * radius, friction = 31 * std::numbers::pi / 180;
    mpm::Elasticity const elastic{1e6, 0.25};
    mpm::Config c;
    c.symmetry = mpm::Symmetry::axial;
    c.cell = radius / cells;
    c.size = {radius * std::ceil(2 + 1.7 * aspect_ratio), c.cell * std::ceil(height / c.cell + 2), 0};
    c.gravity = {0, -9.81, 0};
    c.density = 1600;
    c.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, {.friction_angle = friction})};
    c.shared_volume = true;
    c.bodies.push_back({.high = {radius, height, 0}});
    c.walls = {{.axis = 0, .side = -1},
               {.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = std::tan(friction)}};
    c.geostatic = mpm::GeostaticConfig{.surface = height, .k0 = 1.0 / 3};
    auto solver = mpm::make_solver<2>(c);
    LedgerDrift drift(solver);
    while (solver.time() < 5 * std::sqrt(height / 9.81)) {
        solver.step(solver.longest_step());
        drift.add(solver);
    }
    auto const r = mpm::run_out_of(solver.setup(), solver.state(), 0.05 * std::sqrt(radius * height));
    return {r.front / radius - 1, drift.result(solver)};
}

//! The law of Lube, Huppert, Sparks and Hallworth, J. Fluid Mech. 508 (2004) 175, of any grains on any floor; mark 25
//! %: what materials differ by (file D12_column_collapse_axisym.csv).
void check_heap(double a, int cells)
{
    Stopwatch const watch;
    Heap const h = heap(a, cells);
    double const law = a < 1.7 ? 1.24 * a : 1.6 * std::sqrt(a);
    CHECK(report({"M15", named("a = %g: run-out of a round column", a), h.run_out, law, std::abs(h.run_out / law - 1),
                  0.25, watch.seconds()}));
    check_ledger("M15", named("a = %g: ", a), h.ledger, watch.seconds());
}

}  // namespace

//! Marks: 1 % of the displacement as of the bars of M01. Of the stress what a quarter of a cell in place makes of it at
//! the inner side, |ds/dr| h/4 = 8/3 p/128 = 0.021 p: points end there in the middle of a cell's weights, and the error
//! falls with the cell.
TEST_CASE("M15: a thick-walled cylinder under pressure")
{
    Stopwatch const watch;
    Cylinder const coarse = thick_walled(8), fine = thick_walled(16), finest = thick_walled(32);
    CHECK(
        report({"M15", "opening of the cylinder, 32 cells", finest.opening, 0, finest.opening, 0.01, watch.seconds()}));
    CHECK(report(
        {"M15", "hoop stress, 32 cells, rms by p", finest.hoop, 0, finest.hoop, 8.0 / 3 / 128, watch.seconds()}));
    double const order = std::log2(fine.hoop / finest.hoop);
    CHECK(report(
        {"M15", "hoop stress: order, 16 to 32 cells", order, 1, std::max(0.0, 1 - order), 0.2, watch.seconds()}));
    std::printf("      opening %.2e %.2e %.2e, hoop %.2e %.2e %.2e\n", coarse.opening, fine.opening, finest.opening,
                coarse.hoop, fine.hoop, finest.hoop);
}

TEST_CASE("M15: collapse of a round column, flat")
{
    check_heap(0.5, 12);
}

TEST_CASE("M15: collapse of round columns")
{
    for (double const a : {0.5, 1.0}) check_heap(a, 20);
}
