#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "participants/lbm/solver.hpp"

namespace lattice_case {

//! One disc or sphere that the fluid's load and a given force move (symplectic Euler, order 1 in the fluid's step).
//! `images`: the lattice holds a half or a quarter of what is mirrored at sides without friction through the centre;
//! the body then gets so many times what its part of the lattice lost, and does not turn. No acceleration acts on the
//! lattice in that case.
template <int D>
struct FreeBody
{
    std::vector<double> position, velocity, spin, radius;
    double mass, displaced, inertia;  //!< displaced: of fluid
    double images = 1;
    double last_exchange = 0, last_velocity = 0;

    FreeBody(std::vector<double> place, double a, double density, double fluid_density)
        : position(std::move(place)), velocity(D), spin(lbm::spins<D>), radius{a}
    {
        double const volume = D == 2 ? std::numbers::pi * a * a : 4.0 / 3.0 * std::numbers::pi * a * a * a;
        mass = density * volume;
        displaced = fluid_density * volume;
        inertia = (D == 2 ? 0.5 : 0.4) * mass * a * a;
    }

    //! A step of the fluid and of the body.
    void step(lbm::Solver<D>& solver, std::array<double, D> const& force)
    {
        double const dt = solver.time_step();
        solver.set_bodies({position, velocity, spin, radius});
        solver.step();
        auto const move = [&](std::size_t k, double load) {
            velocity[k] += dt * (load + force[k]) / mass;
            position[k] += dt * velocity[k];
        };
        if (images == 1) {
            for (std::size_t k = 0; k < D; ++k) move(k, solver.loads().force[k]);
            for (std::size_t k = 0; k < spin.size(); ++k) spin[k] += dt * solver.loads().torque[k] / inertia;
            return;
        }
        double const exchange = images * solver.exchange().force[D - 1], now = up();
        move(D - 1, 0.5 * (exchange + last_exchange) + displaced * (now - last_velocity) / dt);
        last_exchange = exchange;
        last_velocity = now;
    }
    double up() const { return velocity[D - 1]; }
};

}  // namespace lattice_case
