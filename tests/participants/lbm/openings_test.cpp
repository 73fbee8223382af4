#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/bent_channel.hpp"
#include "tests/participants/lbm/kept_populations.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Sides through which fluid goes, and sides without friction. Lattice units.
namespace {

template <int D>
lbm::Config config(std::array<double, 3> const& size, double viscosity)
{
    auto c = unit_config<D>(size, viscosity);
    c.collision = lbm::Operator::trt;
    return c;
}

template <int D>
void run(lbm::Solver<D>& solver, int steps)
{
    for (int k = 0; k < steps; ++k) solver.step();
}

//! Largest difference of velocities in cells that both lattices have.
double largest_difference(lbm::Fields const& whole, lbm::Fields const& part, std::size_t components)
{
    double worst = 0;
    for (std::ptrdiff_t z = 0; z < part.nz; ++z)
        for (std::ptrdiff_t y = 0; y < part.ny; ++y)
            for (std::ptrdiff_t x = 0; x < part.nx; ++x)
                for (std::size_t k = 0; k < components; ++k) {
                    auto const at = [&](lbm::Fields const& f) {
                        auto const cell = static_cast<std::size_t>((z * f.ny + y) * f.nx + x);
                        return f.velocity[components * cell + k];
                    };
                    worst = std::max(worst, std::abs(at(whole) - at(part)));
                }
    return worst;
}

//! A channel with a disc at its inflow's end, from a uniform or a parabolic inflow to a pressure.
lbm::Config channel(bool parabola)
{
    auto c = config<2>({60, 20}, 0.05);
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.05, 0, 0}, .parabola = parabola};
    c.walls[lbm::right].kind = lbm::Border::pressure;
    return c;
}

}  // namespace

TEST_CASE("free slip: half a channel and a quarter of a duct are the same as the whole")
{
    auto c = config<2>({3, 20}, 0.05);
    c.set_periodic(0);
    c.acceleration = {1e-5, 0, 0};
    lbm::Solver<2> channel(c);
    c.size[1] = 10;
    c.walls[lbm::top<2>].kind = lbm::Border::slip;
    lbm::Solver<2> half(c);
    run(channel, 500);
    run(half, 500);
    CHECK(channel.max_speed() > 1e-3);
    CHECK(largest_difference(channel.fields(), half.fields(), 2) < 1e-14);

    auto d = config<3>({3, 12, 16}, 0.05);
    d.set_periodic(0);
    d.acceleration = {1e-5, 0, 0};
    lbm::Solver<3> duct(d);
    d.size = {3, 6, 8};
    d.walls[lbm::upper_y].kind = d.walls[lbm::upper_z].kind = lbm::Border::slip;
    lbm::Solver<3> quarter(d);
    run(duct, 200);
    run(quarter, 200);
    CHECK(duct.max_speed() > 5e-4);
    CHECK(largest_difference(duct.fields(), quarter.fields(), 3) < 1e-14);
}

TEST_CASE(
    "openings: a uniform stream between walls without friction stays what it is, in either direction and in space")
{
    for (double const u : {0.08, -0.08}) {
        auto c = config<2>({20, 8}, 0.02);
        auto const in = u > 0 ? lbm::left : lbm::right, out = u > 0 ? lbm::right : lbm::left;
        c.walls[in] = {.kind = lbm::Border::inflow, .velocity = {u, 0, 0}};
        c.walls[out] = {.kind = lbm::Border::pressure, .pressure = 0.01};
        c.walls[lbm::bottom<2>].kind = c.walls[lbm::top<2>].kind = lbm::Border::slip;
        lbm::Solver<2> solver(c);
        solver.set_state([&](auto const&) {
            return lbm::PointState<2>{.velocity = {u, 0}, .pressure = 0.01, .gradient = {}};
        });
        run(solver, 300);
        // what flows in is rho_0 u, so that with rho = 1.03 at the outlet it is slower by that
        double worst = 0;
        lbm::Fields const f = solver.fields();
        for (std::size_t k = 0; k < f.velocity.size(); k += 2)
            worst = std::max(worst, std::abs(f.velocity[k] * 1.03 - u));
        CHECK(worst < 0.01 * 0.08);
    }
    auto c = config<3>({12, 6, 6}, 0.02);
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.08, 0, 0}};
    c.walls[lbm::right].kind = lbm::Border::pressure;
    for (std::size_t s = 2; s < 6; ++s) c.walls[s].kind = lbm::Border::slip;
    lbm::Solver<3> solver(c);
    solver.set_state([](auto const&) {
        return lbm::PointState<3>{.velocity = {0.08, 0, 0}, .pressure = 0, .gradient = {}};
    });
    auto const before = populations_of(solver);
    run(solver, 300);
    auto const after = populations_of(solver);
    double worst = 0;
    for (std::size_t k = 0; k < before.size(); ++k) worst = std::max(worst, std::abs(before[k] - after[k]));
    CHECK(worst < 1e-14);
}

TEST_CASE("openings: a parabolic inflow stays one, what flows in flows out, the outlet has its pressure")
{
    // no disc: Poiseuille's profile all along; the inflow's mean over half cells is that of the parabola to 1/(2 n^2)
    auto c = config<2>({40, 16}, 0.1);
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.02, 0, 0}, .parabola = true};
    c.walls[lbm::right] = {.kind = lbm::Border::pressure, .pressure = 1e-3};
    lbm::Solver<2> solver(c);
    run(solver, 6000);
    double const mass = solver.mass();
    run(solver, 1);
    CHECK(std::abs(solver.mass() / mass - 1) < 1e-9);  // steady: as much out as in
    lbm::Fields const f = solver.fields();
    auto const at = [&](std::ptrdiff_t x, std::ptrdiff_t y) { return static_cast<std::size_t>(y * f.nx + x); };
    for (std::ptrdiff_t const x : {10, 20, 30})
        for (std::ptrdiff_t y = 0; y < 16; ++y) {
            double const s = (static_cast<double>(y) + 0.5) / 16, flux = (1 + 3 * f.pressure[at(x, y)]) * 0.02;
            CHECK(std::abs(f.velocity[2 * at(x, y)] * flux / 0.02 - 0.02 * 4 * s * (1 - s)) < 0.005 * 0.02);
        }
    // the gradient of pressure is 8 mu u_max/H^2; where the side's pressure is, is known to half a cell
    double const gradient = 8 * 0.1 * 0.02 / (16.0 * 16.0);
    CHECK(std::abs((f.pressure[at(20, 8)] - f.pressure[at(30, 8)]) / 10 / gradient - 1) < 0.01);
    CHECK(std::abs(f.pressure[at(39, 8)] - 1e-3 - 0.5 * gradient) < 0.51 * gradient);
}

namespace {

//! Of a pulse of sound, sigma = 8 cells, that runs into the right side: what is left of it in the domain after it has
//! left or come back, over its amplitude.
double left_of_a_pulse(bool absorbing)
{
    auto c = config<2>({200, 4}, 0.01);
    c.set_periodic(1);
    c.walls[lbm::right] = {.kind = lbm::Border::pressure, .absorbing = absorbing};
    lbm::Solver<2> solver(c);
    double const amplitude = 1e-4, sound = 1 / std::sqrt(3.0);
    solver.set_state([&](std::array<double, 2> const& at) {
        double const pressure = amplitude * std::exp(-0.5 * std::pow((at[0] - 120) / 8, 2));
        return lbm::PointState<2>{.velocity = {pressure / sound, 0}, .pressure = pressure, .gradient = {}};
    });
    run(solver, 260);  // a way of 150 cells; the side is 80 away
    lbm::Fields const f = solver.fields();
    double most = 0;
    for (double const p : f.pressure) most = std::max(most, std::abs(p));
    return most / amplitude;
}

}  // namespace

TEST_CASE("openings: sound leaves through a side that absorbs it")
{
    // a given pressure throws it back with the other sign, but for what friction takes
    CHECK(left_of_a_pulse(false) > 0.8);
    // of the recall, over the time that the pulse takes: 0.28 c_s/L sqrt(2 pi) sigma/c_s/2 = 0.014, and of the half
    // cell where the pressure is given, k/2 = 1/(2 sigma) = 0.06 of it at most
    CHECK(left_of_a_pulse(true) < 0.014 + 0.06);
}

TEST_CASE("openings: a side that absorbs sound has its pressure in the end, in a flow and in fluid at rest")
{
    auto c = config<2>({40, 16}, 0.1);
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.02, 0, 0}, .parabola = true};
    c.walls[lbm::right] = {.kind = lbm::Border::pressure, .pressure = 1e-3, .absorbing = true};
    lbm::Solver<2> solver(c);
    run(solver, 12000);
    lbm::Fields const f = solver.fields();
    double const gradient = 8 * 0.1 * 0.02 / (16.0 * 16.0);
    CHECK(std::abs(f.pressure[8 * 40 + 39] - 1e-3 - 0.5 * gradient) < 0.51 * gradient);
    for (std::ptrdiff_t y = 0; y < 16; ++y) {
        double const s = (static_cast<double>(y) + 0.5) / 16;
        double const flux = 1 + 3 * f.pressure[static_cast<std::size_t>(y * 40 + 30)];
        CHECK(std::abs(f.velocity[2 * static_cast<std::size_t>(y * 40 + 30)] * flux - 0.02 * 4 * s * (1 - s)) <
              0.005 * 0.02);
    }
    auto d = config<3>({12, 6, 6}, 0.1);
    d.walls[lbm::upper_z] = {.kind = lbm::Border::pressure, .pressure = 1e-3, .absorbing = true};
    lbm::Solver<3> still(d);
    run(still, 3000);
    for (double const p : still.fields().pressure) CHECK(std::abs(p - 1e-3) < 1e-6);
}

TEST_CASE("openings: a side is shut where a solid covers its cells wholly")
{
    for (bool const absorbing : {false, true}) {
        auto c = config<2>({40, 12}, 0.05);
        for (auto const side : {lbm::left, lbm::right})
            c.walls[side] = {.kind = lbm::Border::pressure, .absorbing = absorbing};
        c.walls[lbm::left].pressure = 1e-3;  // the right one's does not drive fluid through the solid
        c.solids = {block({38, 0, 0}, {40, 12, 0})};
        lbm::Solver<2> solver(c);
        REQUIRE(solver.layout().whole());
        solver.set_state([](auto const&) { return lbm::PointState<2>{.pressure = 1e-3}; });
        run(solver, 200);
        CHECK(solver.max_speed() < 1e-15);
    }
}

TEST_CASE("openings: a wall that moves rests where a solid covers its cells wholly")
{
    auto c = config<2>({24, 40}, 0.5);
    c.walls[lbm::top<2>].velocity[0] = 0.05;
    c.solids = {block({0, 38, 0}, {24, 40, 0})};
    lbm::Solver<2> solver(c);
    REQUIRE(solver.layout().whole());
    run(solver, 100);
    CHECK(solver.max_speed() == 0);
    CHECK(solver.solid_loads().force[0] == 0);
}

TEST_CASE("openings: past a solid that it rests at a wall that moves takes and brings as much fluid")
{
    auto c = config<2>({40, 20}, 0.1);
    c.walls[lbm::top<2>].velocity[0] = 0.05;
    c.solids = {block({0, 17, 0}, {8, 20, 0})};  // in one of the corners
    lbm::Solver<2> solver(c);
    REQUIRE(solver.layout().whole());
    double const before = solver.mass();
    run(solver, 200);
    CHECK(solver.max_speed() > 0.02);
    CHECK(std::abs(solver.mass() - before) < 1e-13 * before);  // u/6 a step, lost or gained, would be 2e-3 of it
}

TEST_CASE("openings: flow over a sill leaves through a side that absorbs sound")
{
    for (auto const collision : {lbm::Operator::trt, lbm::Operator::central}) {
        auto c = config<2>({30, 12}, 0.01);
        c.collision = collision;
        c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.02, 0, 0}, .ramp = 50};
        c.walls[lbm::right] = {.kind = lbm::Border::pressure, .absorbing = true};
        c.solids = {block({20, 0, 0}, {30, 5.5, 0})};
        lbm::Solver<2> solver(c);
        run(solver, 1500);
        CHECK(solver.max_speed() < 2 * 0.02 * 12 / 6.5);  // a parabola above the sill has 1.5 of the mean
    }
}

TEST_CASE("openings: a disc leaves through a side that absorbs sound, and a kept run goes on bit for bit")
{
    auto c = config<2>({40, 16}, 0.05);
    c.collision = lbm::Operator::central;
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.02, 0, 0}, .ramp = 50};
    c.walls[lbm::right] = {.kind = lbm::Border::pressure, .absorbing = true};
    lbm::Solver<2> solver(c), resumed(c);
    for (int k = 0; k < 600; ++k) {
        std::vector<double> const position{32 + 0.02 * k, 7.4}, velocity{0.02, 0}, spin{0}, radius{4.4};
        for (auto* each : {&solver, &resumed}) {
            if (each == &resumed && k <= 500) continue;
            each->set_bodies({position, velocity, spin, radius});
            each->step();
        }
        if (k != 500) continue;
        sluice::State kept;
        solver.keep(kept);
        resumed.restore(kept);
    }
    CHECK(solver.max_speed() < 0.1);
    CHECK(populations_of(solver) == populations_of(resumed));
}

TEST_CASE("openings: two pressures drive a flow")
{
    auto c = config<2>({40, 10}, 0.1);
    double const drop = 2e-3;
    c.walls[lbm::left] = {.kind = lbm::Border::pressure, .pressure = drop};
    c.walls[lbm::right].kind = lbm::Border::pressure;
    lbm::Solver<2> solver(c);
    run(solver, 8000);
    lbm::Fields const f = solver.fields();
    double const u_max = drop / 40 * 100 / (8 * 0.1);
    double const s = 5.5 / 10;
    // over 40 cells, or over 39 between the centres of the outermost
    CHECK(std::abs(f.velocity[2 * (5 * 40 + 20)] / (u_max * 4 * s * (1 - s)) - 1) < 1.05 / 39);
}

TEST_CASE("openings: a run that was kept goes on bit for bit, whatever the number of threads")
{
    std::vector<double> const position{18.3, 10.2, 59.1, 14.2}, velocity{0, 0, 0.01, 0}, spin{0, 0}, radius{3.2, 2.2};
    auto c = channel(true);
    c.walls[lbm::left].ramp = 80;
    c.walls[lbm::right].absorbing = true;
    auto const n = static_cast<double>(c.cells()[0]);
    c.solids = {{.name = "post", .centre = {30.2, 4.7, 0}, .radius = 2.6},
                {.name = "sill", .centre = {n, 1.3, 0}, .radius = 3.1}};  // beside the outlet
    for (int const before : {0, 100}) {
        c.threads = 1;
        lbm::Solver<2> whole(c);
        whole.set_bodies({position, velocity, spin, radius});
        run(whole, before);
        sluice::State kept;
        whole.keep(kept);
        run(whole, 100);
        c.threads = 3;
        lbm::Solver<2> resumed(c);
        run(resumed, before);  // what it knew is forgotten
        resumed.restore(kept);
        resumed.set_bodies({position, velocity, spin, radius});
        run(resumed, 100);
        CHECK(populations_of(whole) == populations_of(resumed));
        CHECK(whole.loads().force[0] > 0);
        CHECK(whole.loads().force[0] == resumed.loads().force[0]);
        CHECK(whole.solid_loads().force[0] != 0);
        CHECK(whole.solid_loads().force[0] == resumed.solid_loads().force[0]);
    }
}

TEST_CASE("openings: while an inflow grows a run that is looked at is that which is not, from the start on")
{
    auto c = channel(true);
    c.walls[lbm::left].ramp = 20;
    for (auto const surface : {lbm::Surface::covered, lbm::Surface::interpolated}) {
        c.surface = surface;
        lbm::Solver<2> unseen(c), seen(c);
        for (int k = 0; k < 25; ++k) {
            seen.mass();
            seen.step();
            unseen.step();
        }
        CHECK(populations_of(seen) == populations_of(unseen));
    }
}

TEST_CASE("openings: a wake leaves at Re = 1000 of the disc, and nothing grows")
{
    auto c = config<2>({120, 60}, 0.05 * 8 / 1000);
    c.collision = lbm::Operator::mrt;
    c.smagorinsky = 0.1;
    c.flux_rate = 1.2;
    c.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.05, 0, 0}, .ramp = 200};
    c.walls[lbm::right].kind = lbm::Border::pressure;
    c.walls[lbm::bottom<2>].kind = c.walls[lbm::top<2>].kind = lbm::Border::slip;
    lbm::Solver<2> solver(c);
    std::vector<double> const position{30, 29}, rest{0, 0}, spin{0}, radius{4};
    solver.set_bodies({position, rest, spin, radius});
    double low = 1e9, high = 0, lift = 0;
    for (int k = 0; k < 20000; ++k) {
        solver.step();
        if (k < 10000) continue;
        lift = std::max(lift, std::abs(solver.loads().force[1]));
        if (k % 500 != 0) continue;
        low = std::min(low, solver.max_speed());
        high = std::max(high, solver.max_speed());
    }
    CHECK(lift > 0.05 * 0.05 * 0.05 * 8 * 0.5);  // vortices are shed
    CHECK(high < 0.15);                          // three times the stream: potential flow has two beside a disc
}

TEST_CASE("solids at rest: a disc and a sphere have the loads of bodies that rest, a box those of its walls")
{
    auto c = channel(false);
    c.acceleration = {1e-5, -2e-5, 0};
    lbm::Solver<2> with_body(c);
    std::vector<double> const position{18.3, 10.2}, rest{0, 0}, spin{0}, radius{3.2};
    with_body.set_bodies({position, rest, spin, radius});
    c.solids = {{.name = "disc", .centre = {18.3, 10.2, 0}, .radius = 3.2}};
    lbm::Solver<2> with_solid(c);
    run(with_body, 400);
    run(with_solid, 400);
    double const force = with_body.loads().force[0];
    CHECK(force > 0);
    // they differ where a body has its core, out of reach of the flow
    for (std::size_t k = 0; k < 2; ++k)
        CHECK(std::abs(with_solid.solid_loads().force[k] - with_body.loads().force[k]) < 2e-3 * force);
    CHECK(std::abs(with_solid.solid_loads().torque[0] - with_body.loads().torque[0]) < 2e-3 * force);

    auto d = config<3>({16, 12, 12}, 0.05);
    for (std::size_t k = 0; k < 3; ++k) d.set_periodic(k);
    d.acceleration = {1e-5, 0, 0};
    d.solids = {{.name = "sphere", .centre = {8.2, 6.1, 5.8}, .radius = 3.1}};
    lbm::Solver<3> sphere(d);
    run(sphere, 3000);
    // steady: it takes what drives the fluid around it
    double const volume = 4.0 / 3.0 * 3.14159265358979 * 3.1 * 3.1 * 3.1;
    CHECK(std::abs(sphere.solid_loads().force[0] / (1e-5 * (16 * 12 * 12 - volume)) - 1) < 0.01);
}

TEST_CASE("solids at rest: a box of whole cells is a wall, a cylinder in space the disc in the plane")
{
    auto c = config<2>({4, 24}, 0.1);
    c.set_periodic(0);
    c.acceleration = {1e-5, 0, 0};
    c.solids = {{.name = "floor", .shape = lbm::Solid::Shape::box, .centre = {2, 2, 0}, .size = {4, 4, 0}}};
    lbm::Solver<2> solver(c);
    run(solver, 20000);
    lbm::Fields const f = solver.fields();
    // Poiseuille's profile above it, H = 20; B = 0.98 instead of 1 moves the wall by 2 % of a cell at most
    double const u_max = 1e-5 * 400 / (8 * 0.1), s = 9.5 / 20;
    CHECK(std::abs(f.velocity[2 * (13 * 4)] / (u_max * 4 * s * (1 - s)) - 1) < 0.01);
    CHECK(f.solid_fraction[3 * 4] == 1);
    CHECK(f.solid_fraction[4 * 4] == 0);
    CHECK(std::abs(solver.solid_loads().force[0] / (1e-5 * 20 / 2 * 4) - 1) < 0.01);  // half of what drives the fluid

    auto plane = config<2>({20, 16}, 0.1);
    for (std::size_t k = 0; k < 2; ++k) plane.set_periodic(k);
    plane.acceleration = {0, 1e-5, 0};
    plane.solids = {{.name = "pile", .centre = {9.7, 8.2, 0}, .radius = 4}};
    lbm::Solver<2> disc(plane);
    auto space = config<3>({20, 3, 16}, 0.1);
    for (std::size_t k = 0; k < 3; ++k) space.set_periodic(k);
    space.acceleration = {0, 0, 1e-5};
    space.solids = {
        {.name = "pile", .shape = lbm::Solid::Shape::cylinder, .centre = {9.7, 0, 8.2}, .radius = 4, .axis = 1}};
    lbm::Solver<3> cylinder(space);
    run(disc, 2000);
    run(cylinder, 2000);
    // two lattices: equal but for errors of second order
    CHECK(disc.solid_loads().force[1] > 0);
    CHECK(std::abs(cylinder.solid_loads().force[2] / 3 / disc.solid_loads().force[1] - 1) < 0.01);
}
