#include "tests/verification/lbm/settling.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

//! Spheres that start from rest. A quarter of the box, mirrored at two sides without friction.
using namespace lattice_case;

namespace {

//! The fastest that it gets [m/s].
double check_settling(Oil const& oil, double cells, double mark)
{
    verification::Stopwatch const watch;
    Settled const got = settle(oil, cells);
    std::string const name = oil.name + text(", d = %.0f dx: ", cells, 0);
    CHECK(verification::report({"C02", name + "fastest [m/s]", got.fastest, oil.fastest,
                                relative(got.fastest, oil.fastest), mark, watch.seconds()}));
    // mark: what curves can be read to, 4 %
    CHECK(verification::report({"C02", name + "fall from h/d = 4 to 1 [s]", got.fall, oil.fall,
                                relative(got.fall, oil.fall), 0.04, watch.seconds()}));
    CHECK(got.last < 0.9);  // it slows down above the floor
    return got.fastest;
}

// E3: what good codes reach with 24 cells. E1: the measured speed is 1.4 % above that of creeping flow in the box,
// which inertia only lowers; published codes are 2.5 to 5 % below it
constexpr double e1_mark = 0.08, e3_mark = 0.025;

//! E1, 3.4 % below the measured speed: where covered and interpolated surfaces meet on fine lattices (0.03472, 0.03476
//! m/s with 18 cells a diameter at a lattice velocity of 0.02); finite elements with 24 cells have 0.03484.
//! Mark: well below what published codes differ by.
constexpr double e1_limit = 0.03475;

void check_e1(double cells)
{
    verification::Stopwatch const watch;
    double const got = check_settling(e1, cells, e1_mark);
    CHECK(verification::report({"C02", text("E1, d = %.0f dx: by the limit of fine lattices", cells, 0), got, e1_limit,
                                relative(got, e1_limit), 0.01, watch.seconds()}));
}

}  // namespace

TEST_CASE("C02: a sphere settles in a box, ten Cate's E1, E3 and E4, d = 6 cells")
{
    check_e1(6);
    check_settling(e3, 6, e3_mark);
    check_settling(e4, 6, 0.02);  // interpolated bounce-back with 6 cells: -2.3 %
}

TEST_CASE("C02: the same, d = 9 cells, and E4 with 12" * doctest::skip())
{
    check_e1(9);
    check_settling(e3, 9, e3_mark);
    for (double const cells : {9.0, 12.0})
        check_settling(e4, cells, 0.009);  // interpolated bounce-back with 12: -0.9 %
}

namespace {

//! F/(6 pi mu a U) of the sphere in the middle of its box, creeping along it: at rest there, its surface moves.
double creeping_drag_in_box(double cells, lbm::Surface surface)
{
    PartOfBox const part(surface);
    lbm::Config c = part.config(cells);
    c.surface = surface;
    c.density = c.viscosity = 1;
    c.step = 0.2 * c.cell * c.cell;  // tau as in E1 with 6 cells
    lbm::Solver<3> solver(c);
    double const u = 1e-5 * c.cell / c.step;
    std::vector<double> const place{part.axis(), part.axis(), 0.5 * box_height}, velocity{0, 0, -u}, spin(3),
        radius{0.5 * sphere_diameter};
    solver.set_bodies({place, velocity, spin, radius});
    double const force =
        run_to_steady(solver, 200, 1e-4, 20'000, [&] { return part.images() * solver.exchange().force[2]; });
    return force / (3 * std::numbers::pi * sphere_diameter * u);
}

void check_creeping(lbm::Surface surface, double cells)
{
    // finite differences for a force of the sphere's second moment, spread as a Gaussian (exact to (a/width)^5), cells
    // of 3.3 to 2 mm, continued to fine ones: 1/0.7200, to 2e-4; mark: that of drag in arrays (L07)
    constexpr double reference = 1 / 0.7200;
    verification::Stopwatch const watch;
    double const got = creeping_drag_in_box(cells, surface);
    CHECK(verification::report({"C02", of_surface(surface, text("creeping in the box, d = %.0f dx", cells, 0)), got,
                                reference, relative(got, reference), 0.02, watch.seconds()}));
}

}  // namespace

//! Walls and drag, in which inertia and the experiment have no part.
TEST_CASE("C02: a sphere creeps in ten Cate's box, d = 6 cells")
{
    for (lbm::Surface const surface : sharp_surfaces) check_creeping(surface, 6);
}

//! What interpolated bounce-back elsewhere has with 9 cells, -2.5 % (waLBerla), to see that it is the same here. It is
//! not nearer to the flow: its drag is 1 % too small there, and with 12 to 18 cells it is at -3.1 to -3.3 %.
TEST_CASE("C02: E1 with an interpolated surface, and creeping, d = 9 cells" * doctest::skip())
{
    verification::Stopwatch const watch;
    constexpr Variant variant{.collision = lbm::Operator::trt, .surface = lbm::Surface::interpolated};
    double const got = settle(e1, 9, variant).fastest;
    CHECK(verification::report({"C02", "E1, interpolated, d = 9 dx: fastest [m/s]", got, e1.fastest,
                                relative(got, e1.fastest), 0.025, watch.seconds()}));
    for (lbm::Surface const surface : sharp_surfaces) check_creeping(surface, 9);
}

namespace {

//! Reynolds number of a sphere of 1.5 times the fluid's density that has fallen 24 diameters through fluid at rest, at
//! Ga = sqrt(g d^3/2)/nu = 144, where its wake is steady and round: Uhlmann and Dusek, Int. J. Multiphase Flow 59
//! (2014) 221, 185.08 in a period of 5.34 d. Lengths in diameters, velocities in that of their sphere.
double heavy_sphere(double cells)
{
    constexpr double reynolds = 185.08, galileo = 144, height = 34, viscosity = 1 / reynolds;
    double const cell = 1 / cells, half_period = std::round(2.67 * cells) * cell;
    lbm::Config c = quarter(2 * half_period, height, cell);
    for (auto const side : {lbm::right, lbm::upper_y}) c.walls[side].kind = lbm::Border::slip;  // mirrors: a period
    c.density = 1;
    c.viscosity = viscosity;
    c.step = 0.1 * cell;
    c.collision = lbm::Operator::central;
    lbm::Solver<3> solver(c);
    FreeBody<3> sphere({0, 0, height - 2}, 0.5, 1.5, 1);
    sphere.images = 4;
    double const weight = (sphere.mass - sphere.displaced) * 2 * std::pow(galileo * viscosity, 2);
    while (sphere.position[2] > height - 2 - 24) sphere.step(solver, {0, 0, -weight});
    return -sphere.up() / viscosity;
}

}  // namespace

//! Minutes. Marks: 3 % of the file; 5 %, which other codes reach with 24 cells at such a Reynolds number (Rettinger and
//! Ruede, Comput. Fluids 154 (2017) 74).
TEST_CASE("C02c: a heavy sphere falls freely at Ga = 144, d = 18 and 24 cells" * doctest::skip())
{
    for (auto const& [cells, mark] : {std::pair{18.0, 0.05}, std::pair{24.0, 0.03}}) {
        verification::Stopwatch const watch;
        double const got = heavy_sphere(cells);
        CHECK(verification::report({"C02c", text("d = %.0f dx: Reynolds number [-]", cells, 0), got, 185.08,
                                    relative(got, 185.08), mark, watch.seconds()}));
    }
}

TEST_CASE("C02: E1 and E4 with direct forcing, d = 6 and 9 cells")
{
    // mark: half a cell of the radius, since the surface lies in the cells that are forced in part; Stokes' velocity
    // goes with 1/radius
    for (Oil const& oil : {e1, e4})
        for (double const cells : {6.0, 9.0}) {
            verification::Stopwatch const watch;
            double const got =
                settle(oil, cells, {.collision = lbm::Operator::trt, .surface = lbm::Surface::forced}).fastest;
            CHECK(verification::report(
                {"C02", std::string("forced, ") + oil.name + text(", d = %.0f dx: fastest [m/s]", cells, 0), got,
                 oil.fastest, relative(got, oil.fastest), 1 / cells, watch.seconds()}));
        }
}

namespace {

//! Drag c_D of a sphere of d cells in a stream, Re = U d/nu, after 5 d of way from a sudden start: `moves`, or the duct
//! and the fluid in it do. A quarter of a duct 4 d wide and 9 d long, periodic.
double drag_in_stream(double d, double reynolds, bool moves)
{
    constexpr double u = 0.05;
    lbm::Config c = quarter(4 * d, 9 * d, 1);
    c.step = c.density = 1;
    c.viscosity = u * d / reynolds;
    c.set_periodic(2);
    if (!moves) c.walls[lbm::right].velocity[2] = c.walls[lbm::upper_y].velocity[2] = -u;
    lbm::Solver<3> solver(c);
    if (!moves)
        solver.set_state([&](std::array<double, 3> const&) {
            return lbm::PointState<3>{.velocity = {0, 0, -u}, .pressure = 0, .gradient = {}};
        });
    std::vector<double> place{0, 0, 2.5 * d}, spin(3);
    std::vector<double> const velocity{0, 0, moves ? u : 0}, radius{0.5 * d};
    auto const way = static_cast<int>(d / u);
    double sum = 0;  // over the last d of way
    for (int k = 0; k < 5 * way; ++k) {
        solver.set_bodies({place, velocity, spin, radius});
        solver.step();
        place[2] += velocity[2];
        if (k >= 4 * way) sum -= 4 * solver.exchange().force[2] / way;
    }
    return sum / (0.5 * u * u * std::numbers::pi * d * d / 4);
}

}  // namespace

TEST_CASE("C02: drag of a sphere in a stream, at rest and moving, d = 6, 9, 12 cells")
{
    // of 18 and 24 cells, continued to fine ones (first and second order: 2.121 to 2.124, 4.486 to 4.489); mark: 2 % as
    // in creeping flow (L07), to which drag is fitted. What moves: beside what rests.
    for (auto const& [reynolds, reference] : {std::pair{10.0, 4.487}, std::pair{32.0, 2.122}})
        for (double const cells : {6.0, 9.0, 12.0})
            for (bool const moves : {false, true}) {
                verification::Stopwatch const watch;
                double const got = drag_in_stream(cells, reynolds, moves);
                CHECK(verification::report(
                    {"C02", (moves ? "c_D moving" : "c_D at rest") + text(", Re=%.0f, d=%.0f dx", reynolds, cells), got,
                     reference, relative(got, reference), 0.02, watch.seconds()}));
            }
}
