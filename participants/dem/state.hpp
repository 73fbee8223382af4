#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "participants/dem/laws.hpp"
#include "participants/dem/lubrication.hpp"
#include "participants/dem/periodic_cell.hpp"
#include "participants/dem/vec.hpp"
#include "participants/dem/wall_shape.hpp"
#include "participants/frame/rotating_frame.hpp"

//! The data of a run, in the plane (discs of unit thickness) or in space (spheres): no physics. Everything here is a
//! value: a copy is a checkpoint.
namespace dem {

//! Where a grain is. Rows of 32 bytes: a contact kernel loads one with a single instruction.
template <int D>
struct alignas(32) Place
{
    Vec<D> centre;        //!< [m]
    double radius = 0.0;  //!< [m]
};

//! Of a sphere [m3]; of a disc its area [m2].
template <int D>
constexpr double volume_of(double radius) noexcept
{
    double const pi = std::numbers::pi;
    return D == 2 ? pi * radius * radius : 4.0 / 3.0 * pi * radius * radius * radius;
}

//! How a grain moves.
template <int D>
struct alignas(32) Motion;
template <>
struct alignas(32) Motion<2>
{
    Vec2 velocity;      //!< [m/s]
    double spin = 0.0;  //!< [rad/s]
};
template <>
struct alignas(32) Motion<3>
{
    alignas(32) Vec3 velocity;  //!< [m/s]
    alignas(32) Vec3 spin;      //!< [rad/s]
};

//! What acts on a grain.
template <int D>
struct alignas(32) Load;
template <>
struct alignas(32) Load<2>
{
    Vec2 force;           //!< [N]
    double torque = 0.0;  //!< [N m]
};
template <>
struct alignas(32) Load<3>
{
    alignas(32) Vec3 force;   //!< [N]
    alignas(32) Vec3 torque;  //!< [N m]
};

//! All grains; an index stays that of its grain for the whole run, where one process has all of them.
template <int D>
struct Grains
{
    std::vector<std::int64_t> id;  //!< lasting id; 0 .. N-1 unless a file gives others
    std::vector<Place<D>> place;
    std::vector<Motion<D>> motion;    //!< on the step, between two steps
    std::vector<Motion<D>> half;      //!< in the middle of the step; scratch
    std::vector<double> mass;         //!< [kg]; discs: per metre of thickness
    std::vector<double> inertia;      //!< [kg m2]; m R^2/2 (disc), 2 m R^2/5 (sphere) unless set otherwise
    std::vector<Load<D>> contact;     //!< of contacts and walls at the current positions
    std::vector<Load<D>> external;    //!< set by the caller, held over a step
    std::vector<std::uint8_t> ghost;  //!< 1: another process's, seen here (domain.hpp); empty: all are ours

    std::size_t size() const { return place.size(); }
    bool is_ghost(std::size_t i) const { return !ghost.empty() && ghost[i] != 0; }
    //! Adds a grain of the given density [kg/m3] and returns its index, which is also its id.
    std::size_t add(Vec<D> centre, double radius, double density, Motion<D> const& motion = {});
};

//! A wall; what it looks like and how it moves is in wall_shape.hpp.
template <int D>
struct Wall
{
    std::string name;
    Shape<D> shape;
    WallMotion<D> motion;
    ContactLaw law;
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]; a gate
};

//! What a wall is to a place when the run begins.
template <int D>
Facing<D> facing_at_start(Wall<D> const& wall, Vec<D> centre)
{
    return std::visit([&](auto const& shape) { return shape.facing(centre - wall.motion.shift(0.0)); }, wall.shape);
}

//! What a contact remembers. One list entry each; zero where nothing touches. Forces rather than elongations: they stay
//! what they are when the stiffness changes with the overlap.
template <int D>
struct History
{
    std::vector<Tangent<D>> friction;  //!< elastic part of the friction, along the slip [N]
    std::vector<Tangent<D>> rolling;   //!< elastic part of the rolling resistance [N]; empty without it
};

//! Calls `each(array of from, array of to)` for the arrays that the first of two histories has.
template <int D, class Each>
void each_array(History<D> const& from, History<D>& to, Each&& each)
{
    if (!from.friction.empty()) each(from.friction, to.friction);
    if (!from.rolling.empty()) each(from.rolling, to.rolling);
}

//! The pairs of so many grains are booked together, so that books add up in one order whoever computes them.
constexpr std::size_t grains_booked = 64;

//! Grains that one thread takes at a time, with the pairs that they own.
struct Range
{
    std::uint32_t begin, end;            //!< grains
    std::vector<std::uint32_t> reaches;  //!< slots before, whose other grain is here, ascending
};

//! Neighbour pairs, CSR by the lower index: the pairs of i are slots first[i]..first[i+1], with other[slot] > i
//! ascending. The order of summation is thus that of the touching pairs, whenever the list was built.
template <int D>
struct Pairs
{
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> other;
    std::vector<std::uint32_t> owner;   //!< i of each slot
    std::vector<std::uint8_t> touched;  //!< 0: has no history; a hint for the packed loop
    std::vector<std::uint32_t> image;   //!< of other, that the pair sees; periodic scenes only
    std::vector<double> sqrt_mass;      //!< sqrt(m*) [sqrt(kg)]
    std::vector<Range> ranges;          //!< that threads take; empty: one thread
    History<D> history;
};

//! From the second grain of a pair, or the image of it that the pair sees, to the first [m].
template <int D>
Vec<D> apart(Grains<D> const& g, Pairs<D> const& pairs, Cell<D> const& cell, std::size_t i, std::size_t slot) noexcept
{
    Vec<D> const other = g.place[pairs.other[slot]].centre;
    if (pairs.image.empty()) return g.place[i].centre - other;
    return g.place[i].centre - (other + cell.images[pairs.image[slot]].shift);
}

//! A facet of a mesh near a grain.
template <int D>
struct Foot
{
    Facing<D> at, last;  //!< now; when the feet were looked at before
    bool bears = false;  //!< the grain touches the mesh there: it is a contact
    bool bore = false;   //!< it was one before
};

//! The grains near one wall, ascending, with their history. A mesh has an entry for each of its facets near a grain.
template <int D>
struct WallContacts
{
    bool active = true;  //!< false once the wall has been removed
    std::vector<std::uint32_t> grain;
    std::vector<std::uint32_t> facet;  //!< a mesh's; ascending for each grain
    std::vector<Foot<D>> foot;         //!< a mesh's; follows from the places of the grains
    History<D> history;
    Vec<D> shift;        //!< where the wall has moved to [m]
    Vec<D> built_shift;  //!< where it was when the lists were built [m]
    Vec<D> velocity;     //!< [m/s]
    Vec<D> force;        //!< on all its grains [N]
};

//! No grain is near the wall.
template <int D>
void forget_contacts(WallContacts<D>& wall)
{
    wall.grain.clear();
    wall.facet.clear();
    wall.foot.clear();
    wall.history = {};
}

//! What a wall is to the grain of one of its entries.
template <class AnyShape, int D>
Facing<D> facing_of(AnyShape const& shape, WallContacts<D> const& contacts, std::size_t entry, Vec<D> centre) noexcept
{
    if constexpr (is_mesh<AnyShape>)
        return contacts.foot[entry].at;
    else
        return shape.facing(centre - contacts.shift);
}
//! Whether an entry with this overlap [m] is a contact: a facet that overlaps need not be.
template <class AnyShape, int D>
bool is_contact(AnyShape const&, WallContacts<D> const& contacts, std::size_t entry, double overlap) noexcept
{
    if constexpr (is_mesh<AnyShape>)
        return contacts.foot[entry].bears;
    else
        return !(overlap <= 0.0);
}

//! The history of one touching contact, free of list layout: what has to be kept to continue a state.
template <int D>
struct ContactRecord
{
    std::uint32_t first = 0;   //!< grain
    std::uint32_t second = 0;  //!< grain > first, or wall index + number of grains + facet x number of walls
    Tangent<D> friction = {};  //!< [N]
    Tangent<D> rolling = {};   //!< [N]
    bool operator==(ContactRecord const&) const = default;
};

//! What the ledger sums up over time [J]. All others follow from the state (see energy.hpp).
struct Booked
{
    double normal_dashpot = 0.0;
    double tangential_dashpot = 0.0;
    double sliding = 0.0;
    double rolling = 0.0;        //!< dashpot and slip of the rolling resistance
    double external_work = 0.0;  //!< done on the grains by the external forces
    double wall_work = 0.0;      //!< done on the grains by moving walls and images
    double field_work = 0.0;     //!< done on the grains by gravity or a frame that changes
    double removed_walls = 0.0;  //!< elastic energy that vanished with walls; kinetic energy of grains that fell asleep
    double touch = 0.0;          //!< lost (> 0) or made (< 0) because contacts begin and end within a step
};

//! Of the forces that are not elastic, at the current time [W]; ledger only.
struct LossyPower
{
    double normal = 0.0, tangential = 0.0, sliding = 0.0, rolling = 0.0;
};

//! Forces on the first grains of contacts that are not elastic, summed by what they are booked as [N].
template <int D>
struct LossyForces
{
    Vec<D> normal, tangential, sliding;
};

//! What is not elastic of the contact loads, by what it is booked as; ledger only. Its power is what contacts lose.
template <int D>
struct LossyLoads
{
    std::vector<Load<D>> press_and_roll;       //!< force of normal dashpots, torque of resistances to rolling
    std::vector<Load<D>> tangential, sliding;  //!< empty where no law has a tangential dashpot
    std::vector<LossyForces<D>> wall;          //!< of the contacts with each wall
    std::array<LossyForces<D>, image_count<D>> image = {};  //!< of the pairs that see each image, but for that at home
};

//! What a contact that began within the step gives to a grain's half-step motion.
template <int D>
struct Push
{
    std::uint32_t grain;
    Motion<D> motion;
};

//! The load of a pair that sees another image of its second grain than that at home.
template <int D>
struct SeamLoad
{
    std::uint32_t image;
    Vec<D> force;          //!< on the first [N]
    LossyForces<D> lossy;  //!< with the ledger
};

//! A grain that was put back on the other side of a periodic cell within the step.
template <int D>
struct Crossing
{
    std::uint32_t grain;
    Vec<D> moved;  //!< [m]
    Vec<D> sped;   //!< with the images [m/s]
};

//! When grains may sleep (sleep.hpp).
struct Sleep
{
    double speed = 0.0;  //!< below which a grain is at rest; with it R |w| [m/s]
    double time = 0.0;   //!< for which it has been [s]; 0: grains do not sleep

    bool any() const noexcept { return time > 0.0; }
};

//! Who sleeps.
template <int D>
struct Rest
{
    std::vector<std::uint32_t> asleep;  //!< 1: yes; empty before the first look
    std::vector<double> slow_since;     //!< [s]
    std::vector<Load<D>> load;          //!< external, when the grain fell asleep
    Pairs<D> pairs;                     //!< between two that sleep; only within a step

    //! Whether these pairs are here and not in the list that is computed.
    bool is_apart() const noexcept { return !pairs.first.empty(); }
};

//! The force of a film of fluid in a narrow gap.
template <int D>
struct Film
{
    std::uint32_t first;   //!< grain
    std::uint32_t second;  //!< grain, or wall index + number of grains
    Vec<D> force;          //!< on the first [N]
};

//! What changes during a run.
template <int D>
struct State
{
    double time = 0.0;  //!< [s]
    std::int64_t steps = 0;
    Grains<D> grains;
    Pairs<D> pairs;
    std::vector<WallContacts<D>> walls;  //!< one per wall
    std::vector<Vec<D>> built;           //!< centres when the lists were built [m]
    std::int64_t rebuilds = 0;
    Cell<D> cell;  //!< periodic scenes only
    Booked booked;
    LossyPower power;
    LossyLoads<D> lossy;                 //!< of the last evaluation
    Rest<D> rest;                        //!< scenes whose grains may sleep only
    std::vector<Film<D>> films;          //!< at the last evaluation (film.hpp)
    std::vector<Push<D>> pushes;         //!< empty between steps
    std::vector<SeamLoad<D>> seams;      //!< empty between steps
    std::vector<Crossing<D>> crossings;  //!< empty between steps
};

//! What a scene needs; chosen once per run.
struct Features
{
    Elasticity elasticity = Elasticity::linear;
    bool friction = false;  //!< any friction coefficient > 0
    Rolling rolling = Rolling::none;
    Scheme scheme = Scheme::predicted;
    bool ledger = false;    //!< sums up dissipated energies and work
    bool periodic = false;  //!< pairs see images of their second grains
    bool operator==(Features const&) const = default;
};

//! What does not change during a run.
template <int D>
struct Setup
{
    Vec<D> gravity;                                //!< [m/s2]; with buoyancy already taken off
    Vec<D> first_gravity;                          //!< at t = 0, where it changes
    double gravity_ramp = 0.0;                     //!< time in which it becomes `gravity`, evenly [s]
    double weight = 1.0;                           //!< share of the weight that buoyancy leaves [-]
    std::optional<frame::RotatingFrame<D>> frame;  //!< that everything is seen in; absent: inertial
    ContactLaw law;                                //!< between grains
    std::vector<Wall<D>> walls;
    Periodic<D> periodic;
    double skin = 0.0;              //!< reach of the neighbour list beyond contact, the films' cutoff in it [m]
    bool absolute_damping = false;  //!< dashpots in N s/m, whatever the masses (LIGGGHTS' order only)
    Lubrication lubrication;
    Sleep sleep;
    bool loads = true;   //!< somebody may set grains.external
    int threads = 1;     //!< that share the loops over spheres
    bool plain = false;  //!< pairs one at a time: the oracle of the packed loop
    Features features;

    Vec<D> gravity_at(double time) const
    {
        if (!(time < gravity_ramp)) return gravity;
        return first_gravity + (time / gravity_ramp) * (gravity - first_gravity);
    }
    //! How far grains may come nearer before the lists are to be built again [m].
    double slack() const { return skin - lubrication.cutoff; }
    //! Whether gravity or the frame is on its way to what it will be.
    bool field_changes(double time) const { return time < gravity_ramp || (frame && frame->changes(time)); }
};

}  // namespace dem
