#pragma once

#include <span>

#include "participants/dem/energy.hpp"
#include "participants/dem/state.hpp"

namespace dem {

//! Combinations of features that are compiled. A scene picks one when it starts.
inline constexpr Features supported[] = {{}, {.friction = true}, {.ledger = true}, {.friction = true, .ledger = true}};

//! A run: setup (constant) and state. A value: a copy continues on its own, bit for bit alike.
//!
//! Step, velocity Verlet (order 2):
//!     v(n+1/2) = v(n) + dt/2 a(n);   x(n+1) = x(n) + dt v(n+1/2);   v*(n+1) = v(n+1/2) + dt/2 a(n)
//!     a(n+1) from x(n+1) and v*(n+1);   v(n+1) = v(n+1/2) + dt/2 a(n+1)
//! a = gravity + (contacts + external) / m; the external forces of a step act in both half kicks.
class Solver
{
 public:
    //! Builds the lists and the forces at t = 0; `springs` are the elongations that contacts start with (a packing).
    //! Throws sluice::Error for an unlisted set of features, or a grain whose centre is behind a wall.
    Solver(Setup setup, Grains grains, std::span<SpringRecord const> springs = {});

    //! One step of dt [s]. Set grains().external_* before. Throws sluice::Error (numerical) when a grain has moved
    //! by more than the smallest radius in one step or is no longer finite.
    void step(double dt);

    Setup const& setup() const { return setup_; }
    State const& state() const { return state_; }
    Grains& grains() { return state_.grains; }
    Grains const& grains() const { return state_.grains; }
    double time() const { return state_.time; }
    Energies energies() const { return dem::energies(setup_, state_); }

    //! Replaces the laws of grains and of all walls from now on (used while a packing is prepared).
    void set_laws(NormalForce const& normal_force, TangentialForce const& tangential_force);
    //! Continues from a state that another solver of the same setup had (a checkpoint).
    void restore(State state);

 private:
    using Evaluate = void (*)(Setup const&, State&, double) noexcept;

    void remove_walls(double now);
    void drift(double dt);
    void kick(double dt);
    void book_step(double dt);

    Setup setup_;
    State state_;
    Evaluate evaluate_ = nullptr;
    double smallest_radius_ = 0.0;
};

std::vector<SpringRecord> springs_of(State const& state);
//! Sets the elongations of contacts in the lists; records of pairs that are not near are ignored.
void set_springs(State& state, std::span<SpringRecord const> records);

}  // namespace dem
