#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "participants/dem/normal_force.hpp"
#include "participants/dem/tangential_force.hpp"
#include "participants/dem/vec2.hpp"

//! The data of a run: structure of arrays, no physics. Everything here is a value: a copy is a checkpoint.
namespace dem {

//! All grains; index = lasting id, 0..N-1 in creation order. Discs of unit thickness.
struct Grains
{
    std::vector<double> x, y;            //!< centre [m]
    std::vector<double> angle;           //!< [rad]
    std::vector<double> vx, vy;          //!< velocity [m/s]; on the step, between two steps
    std::vector<double> spin;            //!< angular velocity [rad/s]
    std::vector<double> radius;          //!< [m]
    std::vector<double> mass;            //!< [kg] per metre of thickness; rho pi R^2 unless set otherwise
    std::vector<double> inertia;         //!< [kg m2]; m R^2/2 unless set otherwise
    std::vector<double> fx, fy, torque;  //!< of contacts and walls at the current positions [N], [N m]
    std::vector<double> external_fx, external_fy, external_torque;  //!< set by the caller, held over a step [N], [N m]
    std::vector<double> half_vx, half_vy, half_spin;                //!< velocity in the middle of the step; scratch

    std::size_t size() const { return x.size(); }
    //! Adds a disc of the given density [kg/m3] and returns its id.
    std::size_t add(Vec2 centre, double disc_radius, double density, Vec2 velocity = {}, double angular_velocity = 0.0);
};

//! A fixed wall: the half-plane behind the line through `point`, whose unit `normal` points to the grains.
struct Wall
{
    std::string name;
    Vec2 point;   //!< [m]
    Vec2 normal;  //!< unit vector
    NormalForce normal_force;
    TangentialForce tangential_force;
    double removed_at = std::numeric_limits<double>::infinity();  //!< [s]; a gate
};

//! Neighbour pairs, CSR by the lower id: the pairs of i are slots first[i]..first[i+1], with other[slot] > i ascending.
//! The order of summation is thus that of the touching pairs, whenever the list was built.
struct Pairs
{
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> other;
    std::vector<double> spring;            //!< tangential elongation zeta [m]; 0 where the pair does not touch
    std::vector<double> sqrt_mass;         //!< sqrt(m*) [sqrt(kg)]
    std::vector<double> lossy_n, lossy_t;  //!< forces less their elastic part [N]; for the energy ledger only
    std::vector<std::uint8_t> slides;      //!< 1 where the contact is at its friction limit; ledger only
};

//! The grains near one wall, ascending, with their history.
struct WallContacts
{
    bool active = true;  //!< false once the wall has been removed
    std::vector<std::uint32_t> grain;
    std::vector<double> spring;  //!< [m]
    std::vector<double> lossy_n, lossy_t;
    std::vector<std::uint8_t> slides;
};

//! The elongations of touching contacts, free of list layout: what has to be kept to continue a state.
struct SpringRecord
{
    std::uint32_t first = 0;   //!< grain
    std::uint32_t second = 0;  //!< grain > first, or wall index + number of grains
    double spring = 0.0;       //!< [m]
};

//! What the ledger sums up over time [J]. All others follow from the state (see energy.hpp).
struct Booked
{
    double normal_dashpot = 0.0;
    double tangential_dashpot = 0.0;
    double sliding = 0.0;
    double external_work = 0.0;  //!< done on the grains by the external forces
    double removed_walls = 0.0;  //!< elastic energy that vanished with walls
    double touch = 0.0;          //!< lost (> 0) or made (< 0) because contacts begin and end within a step
};

//! What changes during a run.
struct State
{
    double time = 0.0;  //!< [s]
    std::int64_t steps = 0;
    Grains grains;
    Pairs pairs;
    std::vector<WallContacts> wall_contacts;  //!< one per wall
    std::vector<double> built_x, built_y;     //!< centres when the lists were built [m]
    std::int64_t rebuilds = 0;
    Booked booked;
    struct Power  //!< of the forces that are not elastic, at the current time [W]; ledger only
    {
        double normal = 0.0, tangential = 0.0, sliding = 0.0;
    } power;
};

//! What a scene needs; chosen once per run.
struct Features
{
    bool friction = false;  //!< any friction coefficient > 0
    bool ledger = false;    //!< sums up dissipated energies and work
    bool operator==(Features const&) const = default;
};

//! What does not change during a run.
struct Setup
{
    Vec2 gravity;  //!< [m/s2]; with buoyancy already taken off
    NormalForce normal_force;
    TangentialForce tangential_force;
    std::vector<Wall> walls;
    double skin = 0.0;  //!< reach of the neighbour list beyond contact [m]
    Features features;
};

}  // namespace dem
