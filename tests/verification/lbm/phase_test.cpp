// Solids finer than a cell against closed forms: P01 to P04.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/verification/lbm/lattice_case.hpp"

using namespace lattice_case;

namespace {

constexpr double inertia = 1.65;  // density that the partner moves, over the fluid's

lbm::Config with_phase(std::ptrdiff_t nx, std::ptrdiff_t ny, double tau, lbm::Drag law, double diameter)
{
    lbm::Config c = config(nx, ny, tau);
    c.collision = lbm::Operator::trt;
    c.phase = lbm::PhaseConfig{.law = law, .diameter = diameter, .solid_density = inertia, .matter = false};
    return c;
}

//! Four points a cell.
struct Bed
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, volume;

    //! Of the rows [low, high).
    Bed(std::ptrdiff_t nx, std::ptrdiff_t low, std::ptrdiff_t high, double solid)
    {
        for (std::ptrdiff_t k = 2 * low; k < 2 * high; ++k)
            for (std::ptrdiff_t i = 0; i < 2 * nx; ++i) {
                id.push_back(static_cast<std::int64_t>(id.size()));
                position.insert(position.end(),
                                {0.5 * static_cast<double>(i) + 0.25, 0.5 * static_cast<double>(k) + 0.25});
                velocity.insert(velocity.end(), {0, 0});
                volume.push_back(0.25 * solid);
            }
    }
    lbm::PhaseView view() const { return {id, position, velocity, volume}; }
};

//! Ergun's own: gradient of pressure over rho for a flux w.
double ergun(double solid, double nu, double d, double w)
{
    double const cube = std::pow(1 - solid, 3);
    return 150 * nu * solid * solid * w / (cube * d * d) + 1.75 * solid * w * w / (cube * d);
}

}  // namespace

// P01: a bed at rest under a uniform force has Ergun's flux: the scheme is exact there, for any resistance.
TEST_CASE("P01: flux through a bed at rest, resistances from 1e-3 to 3e3 a step, slow and fast flow: Ergun")
{
    for (double const d : {200.0, 20.0, 1.0, 0.1})
        for (double const flux : {1e-6, 0.05}) {
            verification::Stopwatch watch;
            auto c = with_phase(4, 4, 0.6, lbm::Drag::ergun, d);
            make_periodic(c, true, true);
            double const nu = c.viscosity;
            c.acceleration = {ergun(0.6, nu, d, flux), 0};
            if (c.acceleration[0] > 0.1) continue;  // no lattice carries such a gradient of pressure
            lbm::Solver<2> solver(c);
            Bed const bed(4, 0, 4, 0.6);
            int const steps = 200 + static_cast<int>(40 * flux / c.acceleration[0]);
            for (int k = 0; k < steps; ++k) {
                solver.set_phase(bed.view(), 1);
                solver.step();
            }
            double const measured = mean_velocity(solver, 0);
            CHECK(verification::report({"P01", text("flux by Ergun's, d = %g, w = %g [cells a step]", d, flux),
                                        measured, flux, relative(measured, flux), 1e-6, watch.seconds()}));
        }
}

// P01: the drop of pressure across a bed in a channel. Its ends are smeared over a cell each, where n, and so the
// resistance, is not that of the bed: of first order in cell/length. Mark: 2 cells of 40.
TEST_CASE("P01: drop of pressure across a bed of 40 cells between an inflow and a pressure")
{
    verification::Stopwatch watch;
    auto c = with_phase(4, 100, 0.8, lbm::Drag::ergun, 3);
    make_periodic(c, true, false);
    double const flux = 1e-5;
    c.walls[lbm::lower_y] = {.kind = lbm::Border::inflow, .velocity = {0, flux, 0}};
    c.walls[lbm::upper_y] = {.kind = lbm::Border::pressure};
    lbm::Solver<2> solver(c);
    Bed const bed(4, 30, 70, 0.4);
    struct Held
    {
        lbm::Solver<2>& fluid;
        Bed const& bed;
        void step()
        {
            fluid.set_phase(bed.view(), 1);
            fluid.step();
        }
    } held{solver, bed};
    double const steady = run_to_steady(held, 500, 1e-6, 60000, [&] {
        auto const p = solver.fields().pressure;
        return p[4 * 20] - p[4 * 80];
    });
    double const reference = 40 * ergun(0.4, c.viscosity, 3, flux);
    CHECK(verification::report({"P01", "drop of pressure across a bed of 40 cells", steady, reference,
                                relative(steady, reference), 0.05, watch.seconds()}));
}

// P02: a suspension in a closed box falls through the fluid that it drives up: there is no mean flux, and its velocity
// is the one at which the law of drag carries its weight. With Di Felice's it goes with n^m, like Richardson and Zaki's
// m = 4.65 in slow flow (Trans. Inst. Chem. Eng. 32 (1954) 35); the law itself has 1 + chi = 4.7.
TEST_CASE("P02: hindered settling in a closed box: velocity by the law, exponent of Richardson and Zaki")
{
    double speed[2], porosity[2];
    int n = 0;
    for (double const solid : {0.02, 0.3}) {
        verification::Stopwatch watch;
        double const d = 0.6, gravity = 1e-6;
        auto c = with_phase(2, 24, 0.8, lbm::Drag::di_felice, d);
        make_periodic(c, true, false);
        lbm::Solver<2> solver(c);
        Bed bed(2, 4, 20, solid);
        for (int k = 0; k < 12000; ++k) {
            solver.set_phase(bed.view(), 1);
            solver.step();
            auto const force = solver.phase_force();
            for (std::size_t i = 0; i < bed.velocity.size(); ++i) {
                bed.velocity[i] += force[i] / (inertia * bed.volume[i / 2]) - (i % 2 == 1 ? gravity : 0);
                bed.position[i] += bed.velocity[i];
            }
        }
        double const v = -bed.velocity[2 * (bed.id.size() / 2) + 1];
        lbm::DragLaw const law{lbm::Drag::di_felice, d, c.viscosity};
        double const weight = solid * inertia * gravity, carried = law.resistance(solid, v) * v;
        CHECK(verification::report({"P02", text("drag by weight of a suspension, phi = %g [-]", solid, 0), carried,
                                    weight, relative(carried, weight), 1e-3, watch.seconds()}));
        speed[n] = v, porosity[n] = 1 - solid, ++n;
    }
    double const exponent = std::log(speed[1] / speed[0]) / std::log(porosity[1] / porosity[0]);
    CHECK(verification::report(
        {"P02", "exponent of the porosity in slow flow", exponent, 4.65, std::abs(exponent - 4.65), 0.1, 0}));
}

// P03: points that answer, for any resistance, solid fraction and weight: the relative motion of the two goes, and
// their momentum stays. An explicit force would need r/M < 2.
TEST_CASE("P03: bed and fluid come to move together, dust and dense beds, permeable and not")
{
    verification::Stopwatch watch;
    double worst = 0, lost = 0;
    for (double const d : {10.0, 0.3, 1e-2, 1e-5})
        for (double const solid : {1e-4, 0.05, 0.6}) {
            auto c = with_phase(8, 8, 0.6, lbm::Drag::di_felice, d);
            make_periodic(c, true, true);
            lbm::Solver<2> solver(c);
            Bed bed(8, 0, 8, solid);
            for (std::size_t i = 0; i < bed.velocity.size(); i += 2) bed.velocity[i] = 0.05;
            double const resistance = 18 * c.viscosity / (d * d), settled = 20 / resistance + 200;
            for (int k = 0; k < std::min(3000.0, settled); ++k) {
                solver.set_phase(bed.view(), 1);
                solver.step();
                auto const force = solver.phase_force();
                for (std::size_t i = 0; i < bed.velocity.size(); ++i) {
                    bed.velocity[i] += force[i] / (inertia * bed.volume[i / 2]);
                    bed.position[i] += bed.velocity[i];
                }
            }
            double momentum = solver.momentum()[0], total = 64 * solid * inertia * 0.05;
            for (std::size_t i = 0; i < bed.velocity.size(); i += 2)
                momentum += inertia * bed.volume[i / 2] * bed.velocity[i];
            lost = std::max(lost, std::abs(momentum / total - 1));
            if (settled > 3000) continue;
            double const together = total / (64 * (1 + solid * inertia));
            for (std::size_t i = 0; i < bed.velocity.size(); i += 2)
                worst = std::max(worst, std::abs(bed.velocity[i] - together) / 0.05);
        }
    CHECK(verification::report(
        {"P03", "relative motion left, of that at the start", worst, 0, worst, 1e-6, watch.seconds()}));
    CHECK(verification::report({"P03", "momentum lost", lost, 0, lost, 1e-11, watch.seconds()}));
}
