#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "participants/dem/contacts.hpp"
#include "participants/dem/energy.hpp"
#include "participants/dem/sleep.hpp"

namespace ranks {
class Peers;
}

namespace dem {

template <int D>
class Domain;

//! A run: setup (constant) and state. A value: a copy continues on its own, bit for bit alike.
//!
//! Step, velocity Verlet (order 2):
//!     v(n+1/2) = v(n) + dt/2 a(n);   x(n+1) = x(n) + dt v(n+1/2);   v*(n+1) = v(n+1/2) + dt/2 a(n)
//!     a(n+1) from x(n+1) and v*(n+1);   v(n+1) = v(n+1/2) + dt/2 a(n+1)
//! a = gravity + (contacts + external) / m; the external forces of a step act in both half kicks. In a frame that
//! turns velocities are turned by the Coriolis part between kick and drift (half_step.hpp).
template <int D>
class Solver
{
 public:
    //! Builds the lists and the forces at t = 0; `records` is what contacts start with (a packing).
    //! Throws sluice::Error for an unlisted set of features, or a grain whose centre is behind a wall.
    Solver(Setup<D> setup, Grains<D> grains, std::span<ContactRecord<D> const> records = {});

    //! So many steps of dt [s]. Set grains().external before, or call set_loads(). Throws sluice::Error (numerical)
    //! when a grain has moved by more than the smallest radius in one step, is no longer finite, or comes to a mesh or
    //! behind a wall. Many at once are the same as one by one, and faster: each grain is then gone through once a step.
    void steps(double dt, std::int64_t count);
    void step(double dt) { steps(dt, 1); }

    Setup<D> const& setup() const { return setup_; }
    //! The list of pairs is whole: those between grains that sleep are in it, too.
    State<D> const& state() const
    {
        take_back(setup_, state_);
        return state_;
    }
    Grains<D>& grains() { return state_.grains; }
    Grains<D> const& grains() const { return state_.grains; }
    double time() const { return state_.time; }
    Energies energies() const { return dem::energies(setup_, state()); }

    //! Replaces laws, gravity and frame by those of another setup with the same walls (used while a packing is
    //! prepared).
    void set_laws(Setup<D> const& from);
    //! Continues from a state that another solver of the same setup had (a checkpoint). Where grains are shared out
    //! that is the whole state on process 0, and its like without grains on the others.
    void restore(State<D> state);

    //! From now on this process has its part of the run only: every process of `peers` calls it, with solvers of the
    //! same setup, and those grains are shared out that process 0 has. The others' solvers are made without grains. All
    //! that steps then talks to the other processes. Not with periodic sides, sleep or a mesh: throws sluice::Error.
    //! `peers` outlives it.
    void share_out(ranks::Peers& peers);
    //! What partners do to all grains of the run from now on, in their order. Where grains are shared out all processes
    //! call it, and process 0 says it.
    void set_loads(std::vector<Load<D>> const& loads);
    //! Where grains are shared out, and then by all: brings where all grains are and how they move into `all`, those of
    //! whole(), on process 0.
    void gather_motion(Grains<D>& all) const;
    //! The state of the whole run: its own, or where grains are shared out what Domain::gather() says; then all call
    //! it.
    State<D> whole() const;
    Domain<D> const* domain() const { return domain_.get(); }  //!< null: all grains are here

 private:
    void derive();
    void rebuild_if(bool late);
    template <class Body>
    void share(Body&& body);
    auto loads() const;
    void remove_walls(double now);
    bool walls_have_moved() const;
    void move_cell(double dt);
    bool kick_can_wait(double dt) const;
    template <class Half>
    Motion<D> kicked(double dt, Half const& second, std::size_t i, Load<D> const& load) const;
    template <class Half>
    void drift(double dt, std::optional<Half> const& due, Half const& first, Half const& second);
    template <class Half>
    void kick(double dt, Half const& second);
    template <class Half, class Halves>
    void advance(double dt, std::int64_t count, Halves const& halves);
    double work_of_field(double dt) const;
    void book_step(double dt);
    void book_cell(double dt);
    void evaluate(double dt);
    void evaluate_again();
    void evaluate_power();
    void let_sleep();

    Setup<D> setup_;
    mutable State<D> state_;              //!< mutable: whether its list is whole is nobody's business
    std::shared_ptr<sluice::Team> team_;  //!< shared by copies, which take turns; null: one thread
    std::shared_ptr<Domain<D>> domain_;   //!< shared by copies: only one of them goes on
    Evaluate<D> evaluate_ = nullptr;
    double smallest_radius_ = 0.0;
    std::vector<double> per_mass_, per_inertia_;  //!< [1/kg], [1/(kg m2)]
};

template <int D>
std::vector<ContactRecord<D>> records_of(State<D> const& state);
//! Sets the histories of contacts in the lists; records of pairs that are not near are ignored.
template <int D>
void set_records(State<D>& state, std::span<ContactRecord<D> const> records);

}  // namespace dem
