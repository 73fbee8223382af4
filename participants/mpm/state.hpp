#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "participants/frame/rotating_frame.hpp"
#include "participants/motion/prescribed_motion.hpp"
#include "participants/mpm/basis.hpp"
#include "participants/mpm/laws.hpp"

//! Material points, walls, and what a run is made of; no physics.
namespace mpm {

template <int D>
struct Point
{
    std::int64_t id = 0;
    Vec<D> place = Vec<D>::Zero();     //!< [m]
    Vec<D> velocity = Vec<D>::Zero();  //!< [m/s]
    Mat<D> slope = Mat<D>::Zero();     //!< gradient of the velocity around it [1/s]; affine transfer only
    double mass = 0;                   //!< [kg]; plane: per metre, axial: of its ring
    double volume = 0;                 //!< at the start [m3]; plane: [m2]
    Matter matter;

    double volume_now() const { return volume * matter.ratio; }
};

enum class WallKind
{
    open,    //!< none: a point that passes it leaves the domain
    joined,  //!< none: a point that passes it comes in again at the opposite side (periodic)
    fixed,   //!< nothing moves
    roller,  //!< no motion across, free motion along
    rough    //!< no motion into it, Coulomb friction along; may be left
};

//! A plane across one axis, on a grid line. Nodes on it and behind it obey it.
struct Wall
{
    int axis = 0;
    int side = 0;      //!< -1: matter lies above it on its axis, +1: below
    double place = 0;  //!< [m]
    WallKind kind = WallKind::roller;
    double friction = 0;                                          //!< mu, of a rough one
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]
};

//! A plane anywhere, that moves as it is told. Matter lies where its normal points to, and may leave it.
template <int D>
struct Plate
{
    Vec<D> point = Vec<D>::Zero();   //!< on it, before it moves [m]
    Vec<D> normal = Vec<D>::Zero();  //!< unit vector
    double friction = 0;             //!< mu
    motion::PrescribedMotion<Vec<D>> motion = {};
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]
};

//! Stress that acts on the outer face of a point, across one axis.
template <int D>
struct Traction
{
    std::size_t point = 0;  //!< index
    int axis = 0;
    int side = 0;                    //!< +1: on the face of larger coordinate, -1: on the other
    Vec<D> stress = Vec<D>::Zero();  //!< force per area at the start [Pa]
};

enum class Width
{
    fixed,   //!< a point stays as wide as it was
    stretch  //!< it follows its stretch along each axis, up to a cell
};

//! What lies across the plane.
enum class Symmetry
{
    plane,  //!< the same for ever: plane strain
    axial   //!< the same around the axis x = 0; x is the radius, masses and energies are of whole rings
};

enum class Scheme
{
    musl,  //!< strain from velocities that the points gave back to the grid
    usl    //!< strain from the grid's own
};

//! Cells a step at the speed of sound: beyond, energy grows (README.md, Limits).
inline constexpr double largest_courant = 0.6;

//! The constant part of a run.
template <int D>
struct Setup
{
    Vec<D> origin = Vec<D>::Zero();  //!< lower corner of the domain [m]
    std::array<int, D> cells{};      //!< of the domain along each axis
    double cell = 0;                 //!< h [m]
    Vec<D> period = Vec<D>::Zero();  //!< from a joined side to the other along each axis [m]; 0: they are not joined
    double half_width = 0;           //!< of a point at the start, in cells
    Width width = Width::fixed;
    Symmetry symmetry = Symmetry::plane;  //!< in the plane
    double density = 0;                   //!< of the matter at the start [kg/m3]; what a full cell has
    BasisKind basis = BasisKind::gimp;
    Scheme scheme = Scheme::musl;
    double flip = 1;             //!< share of FLIP in the velocity update; the rest is PIC
    bool affine = false;         //!< points bring the gradient of their velocity to the grid
    bool shared_volume = false;  //!< the points of a cell share its change of volume (cell_means.hpp)
    bool one_at_a_time = false;  //!< the plain way, where there is a faster one
    double damping = 0;          //!< of all velocities [1/s]
    double courant = 0.4;
    Vec<D> gravity = Vec<D>::Zero();               //!< [m/s2]
    std::optional<frame::RotatingFrame<D>> frame;  //!< none: inertial
    Law law = LinearElastic{};
    std::vector<Wall> walls;
    std::vector<Plate<D>> plates;
    std::vector<Traction<D>> tractions;

    //! From one place to another the nearer way, through joined sides if need be.
    Vec<D> arm(Vec<D> const& from, Vec<D> const& to) const
    {
        Vec<D> way = to - from;
        for (int a = 0; a < D; ++a)
            if (period[a] > 0) way[a] -= period[a] * std::round(way[a] / period[a]);
        return way;
    }
};

//! Energies that left the points, since the start [J]; plane: per metre, axial: of whole rings.
struct Booked
{
    double plastic = 0;        //!< dissipated by the law
    double sliding = 0;        //!< dissipated by friction at walls
    double damping = 0;        //!< dissipated by Setup::damping
    double numerical = 0;      //!< lost between points and grid, and where a wall stops a node; < 0: gained
    double external_work = 0;  //!< done on the points by tractions, loads, grains and plates
    double field_work = 0;     //!< done by a frame whose rate changes; and what points gain by a way round joined sides
};

//! What changes.
template <int D>
struct State
{
    std::vector<Point<D>> points;
    std::vector<std::int32_t> order;  //!< in which sums run over the points, where that is not their own (none: empty)
    double time = 0;                  //!< [s]
    std::int64_t steps = 0;
    Booked booked;
};

}  // namespace mpm
