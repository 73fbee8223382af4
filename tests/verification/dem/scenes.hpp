#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "participants/dem/setup.hpp"

//! Small scenes shared by the verification cases.
namespace scenes {

struct Contact
{
    double stiffness = 1e6;      //!< kn [N/m]
    double damping_ratio = 0.0;  //!< alpha_n [-]
    double tangential_ratio = 2.0 / 7.0;
    double tangential_damping = 0.0;  //!< alpha_t [-]
    double friction = 0.0;
    bool ledger = false;
};

inline dem::Setup setup(Contact const& c, dem::Vec2 gravity = {}, double skin = 1e-3)
{
    dem::Setup s;
    s.gravity = gravity;
    s.normal_force = dem::make_normal_force(c.stiffness, c.damping_ratio);
    if (c.friction > 0.0)
        s.tangential_force =
            dem::make_tangential_force(c.tangential_ratio * c.stiffness, c.tangential_damping, c.friction);
    s.skin = skin;
    s.features = {.friction = c.friction > 0.0, .ledger = c.ledger};
    return s;
}

//! A wall with the laws of the grains.
inline void add_wall(dem::Setup& s, dem::Vec2 point, dem::Vec2 normal)
{
    s.walls.push_back({.name = "wall " + std::to_string(s.walls.size()),
                       .point = point,
                       .normal = normal,
                       .normal_force = s.normal_force,
                       .tangential_force = s.tangential_force});
}

//! Adds a body of any mass and inertia factor I* (disc 1/2, sphere 2/5): the laws see only these numbers.
inline void add_body(dem::Grains& g, dem::Vec2 centre, double radius, double mass, double inertia_factor,
                     dem::Vec2 velocity = {}, double spin = 0.0)
{
    std::size_t const id = g.add(centre, radius, 1.0, velocity, spin);
    g.mass[id] = mass;
    g.inertia[id] = inertia_factor * mass * radius * radius;
}

//! The sphere of study C: D = 8 mm, 2650 kg/m3.
inline constexpr double sphere_radius = 4e-3;
inline constexpr double sphere_mass = 2650.0 * std::numbers::pi / 6.0 * 8e-3 * 8e-3 * 8e-3;

//! A column of discs of 1 to 1.8 mm as in the collapse scenes.
inline dem::Config column(int count, double aspect_ratio, double packing_friction = 0.1)
{
    std::string const text =
        "density: 2650\ndiameter: {min: 1.0e-3, max: 1.8e-3}\n"
        "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, tangential_damping: 0.2, friction_angle: 26}\n"
        "walls:\n  - {name: floor, point: [0, 0], normal: [0, 1]}\n  - {name: back, point: [0, 0], normal: [1, 0]}\n"
        "column: {count: " +
        std::to_string(count) + ", aspect_ratio: " + std::to_string(aspect_ratio) +
        ", packing_friction: " + std::to_string(packing_friction) + "}\n";
    return dem::read_config(sluice::read_yaml(text, "column.yaml"), {0.0, -9.81});
}

}  // namespace scenes
