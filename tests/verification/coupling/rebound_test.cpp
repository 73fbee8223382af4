#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "participants/dem/solver.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

//! A steel sphere falls on a wall through a liquid: what comes back, by the Stokes number. Lattice units; a quarter of
//! the fluid, mirrored.
namespace {

constexpr double radius = 4, diameter = 2 * radius, ratio = 7.8, speed = 0.05, dry = 0.97;
constexpr int substeps = 100;

struct Rebound
{
    double stokes;  //!< (rho_s + rho_f/2) d U/(9 mu), U the speed at a gap of 0.2 d
    double speed;   //!< at a gap of 0.1 d on the way up, over U `dry`
    double film;    //!< the film's impulse on the way down, by what the way takes, less 1
};

//! What a film takes on the way from one gap to a narrower one, down to its floor, at any speed: the integral of its
//! resistance.
double impulse_of(dem::Lubrication const& film, double from, double to)
{
    double const first = std::min(from, film.cutoff), last = std::min(to, film.cutoff);
    return 6 * std::numbers::pi * film.viscosity * radius * radius *
           (std::log(first / last) - (first - last) / film.cutoff);
}

//! Of a sphere that without walls would fall at rho_s d U/(9 mu) = `stokes`.
Rebound rebound(double stokes)
{
    double const reynolds = 9 * stokes / ratio;
    lbm::Config c;
    c.dimension = 3;
    c.cell = c.step = c.density = 1;
    c.size = {2 * diameter, 2 * diameter, 6 * diameter};
    c.viscosity = speed * diameter / reynolds;
    c.collision = lbm::Operator::trt;
    for (std::size_t const side : {0UL, 1UL, 2UL, 3UL}) c.walls[side].kind = lbm::Border::slip;
    lbm::Solver<3> fluid(c);

    double const volume = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3), mass = ratio * volume;
    // falls at U without walls: Schiller and Naumann
    double const c_d = 24 / reynolds * (1 + 0.15 * std::pow(reynolds, 0.687));
    double const weight = c_d * 0.5 * speed * speed * std::numbers::pi * radius * radius;
    double const contact_time = 1, stiffness = mass * std::pow(std::numbers::pi / contact_time, 2);
    dem::Setup<3> setup = scenes::setup<3>({.stiffness = stiffness, .damping_ratio = -std::log(dry) / std::numbers::pi},
                                           {0, 0, -weight / mass}, 1.0);
    scenes::add_wall<3>(setup, {0, 0, 0}, {0, 0, 1});
    setup.lubrication = {.viscosity = c.viscosity, .cutoff = 2.0 / 3, .floor = 1e-3};
    dem::Grains<3> grains;
    dem::Motion<3> motion{};
    motion.velocity = {0, 0, -speed};
    grains.add({0, 0, 3.5 * diameter}, radius, ratio, motion);
    dem::Solver<3> solid(setup, grains);

    std::vector<double> position(3), velocity(3), spin(3), size{radius};
    double last_exchange = 0, last_velocity = -speed, impact = 0, back = 0, taken = 0, expected = 0;
    for (int k = 0; k < 4000; ++k) {
        dem::Grains<3>& g = solid.grains();
        position[2] = g.place[0].centre.z;
        velocity[2] = g.motion[0].velocity.z;
        fluid.set_bodies({position, velocity, spin, size});
        fluid.step();
        double const exchange = 4 * fluid.exchange().force[2];
        double const load = 0.5 * (exchange + last_exchange) + volume * (velocity[2] - last_velocity);
        last_exchange = exchange;
        last_velocity = velocity[2];
        g.external[0].force = {0, 0, load};
        solid.steps(1.0 / substeps, substeps);
        double const up = g.motion[0].velocity.z, gap = g.place[0].centre.z - radius;
        if (up < 0 && gap > setup.lubrication.floor * radius) {
            taken += mass * (up - velocity[2]) - load + weight;
            expected += impulse_of(setup.lubrication, position[2] - radius, gap);
        }
        if (up < 0 && gap > 0.2 * diameter) impact = -up;
        if (up > 0 && gap > 0.1 * diameter) {
            back = up;
            break;
        }
    }
    return {(ratio + 0.5) * diameter * impact / (9 * c.viscosity), back / impact / dry, taken / expected - 1};
}

}  // namespace

TEST_CASE("C12: rebound of a sphere from a wall in a liquid, by the Stokes number")
{
    // e/e_dry = exp(-35/St): Legendre, Daniel and Guiraud, Phys. Fluids 17 (2005) 097105, a fit to the experiments of
    // Gondret, Lance and Petit, Phys. Fluids 14 (2002) 643, and others; mark: how far those scatter about it
    for (double const stokes : {5.0, 20.0, 50.0, 150.0}) {
        verification::Stopwatch const watch;
        Rebound const got = rebound(stokes);
        double const reference = std::exp(-35 / got.stokes);
        CHECK(verification::report({"C12", lattice_case::text("e/e_dry at St=%.1f, d=%.0f dx", got.stokes, diameter),
                                    got.speed, reference, std::abs(got.speed - reference), 0.15, watch.seconds()}));
        // it acts in the grains' steps, c dt/m = 0.006 at the floor: to some (c dt/m)^2
        CHECK(std::abs(got.film) < 1e-3);
    }
}
