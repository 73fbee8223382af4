#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/mpm/grid.hpp"
#include "participants/mpm/state.hpp"
#include "participants/mpm/stencil.hpp"

namespace mpm {

//! An angular velocity or moment: out of the plane, or of space.
template <int D>
using Spin = Vec<D == 2 ? 1 : 3>;

template <int D>
Vec<D> velocity_of(Spin<D> const& spin, Vec<D> const& arm)
{
    if constexpr (D == 2)
        return {-spin[0] * arm[1], spin[0] * arm[0]};
    else
        return spin.cross(arm);
}
template <int D>
Spin<D> moment_of(Vec<D> const& arm, Vec<D> const& force)
{
    if constexpr (D == 2)
        return Spin<2>(arm[0] * force[1] - arm[1] * force[0]);
    else
        return arm.cross(force);
}

//! A rigid disc or sphere that somebody else moves.
template <int D>
struct Grain
{
    std::int64_t id = 0;
    Vec<D> place = Vec<D>::Zero();     //!< of its centre [m]
    Vec<D> velocity = Vec<D>::Zero();  //!< [m/s]
    Spin<D> spin = Spin<D>::Zero();    //!< [rad/s]
    double radius = 0;                 //!< [m]
};

//! A plate in a step: where it is when the points are where they are, and its velocity to where it is a step later.
template <int D>
struct PlateNow
{
    std::size_t number = 0;          //!< in the setup
    Vec<D> point, normal, velocity;  //!< [m], unit vector, [m/s]
    double friction = 0;
};
template <int D>
std::vector<PlateNow<D>> plates_at(Setup<D> const& setup, double time, double dt);

//! What a grain got in a step; plane: per metre.
template <int D>
struct Push
{
    Vec<D> impulse = Vec<D>::Zero();    //!< [N s]
    Spin<D> angular = Spin<D>::Zero();  //!< about its centre [N m s]
};

//! A node that contacts act on.
template <int D>
struct TouchedNode
{
    std::array<int, D> index{};
    double mass = 0;                   //!< [kg]
    Vec<D> before = Vec<D>::Zero();    //!< velocity that the points brought [m/s]
    Vec<D> velocity = Vec<D>::Zero();  //!< after forces and contacts, before walls [m/s]
    Vec<D> held = Vec<D>::Zero();      //!< after walls [m/s]
    std::uint32_t walls = 0;           //!< bit w: wall w holds it
};

//! Contact of points with grains and plates: unilateral, Coulomb friction, as impulses of one step that are found
//! together.
//!
//!     face     of a point towards a grain: its place - l n, l half its width now, n the normal of the grain
//!     u        velocity of the grid there less that of the grain there
//!     0 <= Pn  _|_  n.u + gap / dt >= 0      |Pt| <= mu Pn, against the slip
//!
//! P acts on the nodes by the weights of the face, -P on the grain: their sum and, since sum w (node - face) = 0, their
//! moment vanish, to rounding. Of a gap < 0 a share is opened in a step.
template <int D>
class GrainContacts
{
 public:
    double friction = 0;

    //! As they are at the start of the step to come; their motion its mean.
    void set(std::vector<Grain<D>> grains);
    std::vector<Grain<D>> const& grains() const { return grains_; }
    void set_plates(std::vector<PlateNow<D>> plates) { plates_ = std::move(plates); }
    bool any() const { return !grains_.empty() || !plates_.empty(); }
    double speed() const { return speed_; }  //!< of the fastest surface [m/s]

    //! Forgets the contacts of the last step.
    void begin(Setup<D> const& setup);
    //! Whether a point may touch a grain in this step.
    bool is_near(Setup<D> const& setup, Vec<D> const& place) const
    {
        std::size_t const cell = cell_at(setup, place);
        if (cell < first_.size() && first_[cell] != none) return true;
        for (PlateNow<D> const& p : plates_)
            if ((place - p.point).dot(p.normal) < 2 * setup.cell) return true;
        return false;
    }
    //! Lists the contacts of a point. Throws sluice::Error (numerical): it is more than a cell inside a grain or plate.
    void consider(Setup<D> const& setup, double dt, std::int64_t id, Vec<D> const& place, double ratio);

    //! Of all contacts: the caller fills in mass and velocities, and takes the velocities back after solve().
    std::vector<TouchedNode<D>>& nodes() { return nodes_.nodes(); }
    //! Books the work of the grains and of friction.
    void solve(Setup<D> const& setup, double time, double dt, Booked& booked);

    //! In the last step, one a grain.
    std::vector<Push<D>> const& pushes() const { return pushes_; }
    std::vector<Vec<D>> const& plate_impulses() const
    {
        return plate_impulses_;
    }  //!< what plates got that are not removed [N s]
    std::size_t contacts() const { return contacts_.size(); }
    int sweeps() const { return sweeps_; }

 private:
    static constexpr std::int32_t none = -1;

    struct Contact
    {
        std::int64_t point = 0;  //!< id
        std::size_t body = 0;    //!< grain, or a plate: number of grains + its own
        double friction = 0;
        Vec<D> normal, arm;               //!< from the body to the point; from its centre to the face [m]
        Vec<D> body_velocity;             //!< at the face [m/s]
        double bias = 0;                  //!< speed at which the gap may close, < 0: is to open [m/s]
        double response = 0;              //!< impulse that changes the velocity of the face by one [kg]
        Vec<D> impulse = Vec<D>::Zero();  //!< on the continuum [N s]
        std::size_t first = 0, last = 0;  //!< shares, one beyond the last
    };
    struct Share  //!< of the face of a contact
    {
        std::size_t node;
        double weight;
    };
    struct Mark  //!< a grain whose surface may be near a cell
    {
        std::size_t grain;
        std::int32_t next;
    };

    std::size_t cell_at(Setup<D> const& setup, Vec<D> const& place) const;
    void mark(Setup<D> const& setup, std::size_t grain);
    void add(Setup<D> const& setup, double dt, double gap, Vec<D> const& face, Contact contact);
    Vec<D> slip(Contact const& c, Vec<D> TouchedNode<D>::*velocity) const;
    std::span<Share const> shares(Contact const& c) const
    {
        return {shares_.data() + c.first, shares_.data() + c.last};
    }
    void hold(Setup<D> const& setup, TouchedNode<D>& node) const;
    double relax(Setup<D> const& setup, Contact& contact);

    std::vector<Grain<D>> grains_;
    double speed_ = 0;
    std::array<int, D> cells_{};
    std::vector<std::int32_t> first_;  //!< mark of each cell
    std::vector<Mark> marks_;
    std::vector<std::size_t> marked_;  //!< cells
    std::vector<Contact> contacts_;
    std::vector<Share> shares_;
    Grid<D, TouchedNode<D>> nodes_;
    std::vector<PlateNow<D>> plates_;
    std::vector<Push<D>> pushes_;
    std::vector<Vec<D>> plate_impulses_;
    int sweeps_ = 0;
};

}  // namespace mpm
