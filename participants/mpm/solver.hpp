#pragma once

#include <optional>
#include <span>
#include <string>

#include "participants/mpm/energy.hpp"
#include "participants/mpm/grains.hpp"
#include "participants/mpm/grid.hpp"
#include "participants/mpm/packed_step.hpp"
#include "participants/mpm/transfer.hpp"

namespace mpm {

//! A run: setup (constant) and state. A value: a copy continues on its own, bit for bit alike. Here is the plain
//! version: one thread, every quantity where a reader looks for it. PackedStep does the same faster, where it can.
//! Several processes may share the points, each with a solver that was made alike: all make the same calls, and get the
//! bits that one process would.
//!
//! A step of dt, weights w at the places x(n):
//!     m = sum w mp,  v = sum w mp vp / m,  v* = walls(v + dt (sum w fp - sum V s grad w) / m + dt g)
//!     vp(n+1) = flip (vp + sum w (v* - v)) + (1 - flip) sum w v*,   x(n+1) = x(n) + dt sum w v*
//! In a frame that turns half of the acceleration, the turn of Coriolis, the other half (field.hpp); the vp of the
//! points are turned as well, each by itself: what the grid does not see of them takes part.
//!     dF = I + dt sum u grad w,  u = v* (usl) or walls(sum w mp vp(n+1) / m) (musl);  then the law
template <int D>
class Solver
{
 public:
    //! Throws sluice::Error (config) for points outside the domain or behind a wall. `peers`: the processes that share
    //! the points (null: there is one); then also for what they cannot share (require_shareable).
    Solver(Setup<D> setup, State<D> state, ranks::Peers* peers = nullptr);

    //! Throws sluice::Error (numerical): dt above the limit, a point turned inside out, not finite, or outside.
    void step(double dt);
    //! `courant` cells at the speed of the fastest wave over the fastest point [s].
    double longest_step() const { return setup_.courant * limit(); }
    //! One cell at that speed [s]; step() refuses more than 0.6 of it.
    double limit() const;

    //! Whether a point may be there: in the domain, or in a side that is a wall by less than half a cell, where nothing
    //! moves it further.
    bool contains(Vec<D> const& place) const;

    Setup<D> const& setup() const { return setup_; }
    ranks::Peers* peers() const { return peers_; }
    //! Of several processes the first has the points as they are now, the others as they once were.
    State<D> const& state() const
    {
        write_points(Whom::first);
        return state_;
    }
    //! Where points are now and how they move; nothing else is up to date.
    State<D> const& in_motion() const
    {
        if (!peers_) return state();
        if (first_is_behind_) packed_.give_motion(state_);
        return state_;
    }
    //! All processes have all of them, and change them alike.
    std::vector<Point<D>>& points()
    {
        leave_packed();
        return state_.points;
    }
    double time() const { return state_.time; }
    std::size_t count() const { return state_.points.size(); }            //!< of points
    Energies energies() const { return mpm::energies(setup_, state()); }  //!< as state()
    //! Force on each point [N] from now on; none: empty.
    void set_loads(std::vector<Vec<D>> loads) { loads_ = std::move(loads); }
    //! Grains that points touch in the steps to come, as they are at the start of the next one; their motion is its
    //! mean.
    void set_grains(std::vector<Grain<D>> grains) { grains_.set(std::move(grains)); }
    //! Of the points on grains.
    void set_friction(double friction) { grains_.friction = friction; }
    //! The contacts of the last step, and what the grains got in it.
    GrainContacts<D> const& grains() const { return grains_; }
    //! No bit of a result depends on it.
    void use_threads(int threads);
    void set_gravity(Vec<D> const& gravity);
    //! Of the fastest wave over the fastest point, after the last step [m/s].
    double speed() const { return speed_; }
    //! Continues from a state that another solver of the same setup had, and from its speed(), which the two ways of a
    //! step round differently. Absent: that of the points.
    void restore(State<D> state, std::optional<double> speed = std::nullopt);

    //! With mass, in the last step.
    std::size_t nodes() const { return nodes_reached_; }
    //! Nodes with less than 1e-9 of a full cell's mass, summed over the steps: strain does not see their acceleration.
    std::int64_t light_nodes() const { return light_nodes_; }
    void count_light_nodes_from(std::int64_t count) { light_nodes_ = count; }

 private:
    void step_plain(double dt);
    bool step_packed(double dt);
    void write_points(Whom whom) const;
    void leave_packed();
    void check_upright() const;
    void move_nodes(Field<D> const& field, double dt);
    void touch_grains(double dt);
    void hold_nodes(double dt);
    void set_strain_velocities();
    std::vector<double> shifts_of_stress() const;
    void share_volume();
    double deform(double dt);
    void bring_round();
    double work_of_field(Field<D> const& field) const;
    void check_places() const;
    void find_speed();
    std::string where(Point<D> const& point) const;

    Setup<D> setup_;
    mutable State<D> state_;  //!< its points may be behind those of packed_
    ranks::Peers* peers_;
    PackedStep<D> packed_;
    bool packed_has_points_ = false;
    mutable bool first_is_behind_ = false, others_are_behind_ = false;  //!< the same on all processes
    std::size_t nodes_reached_ = 0;
    Grid<D> grid_;
    Transfer<D> const* transfer_;
    GrainContacts<D> grains_;
    std::vector<Vec<D>> loads_, places_;
    std::vector<Mat3> increments_;  //!< of the deformation gradient
    double speed_ = 0;
    std::int64_t light_nodes_ = 0;
};

//! Throws sluice::Error (config) if so many processes cannot share a run.
template <int D>
void require_shareable(Setup<D> const& setup, std::size_t points, int processes);

}  // namespace mpm
