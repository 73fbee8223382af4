#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>

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

template <int D = 2>
dem::Setup<D> setup(Contact const& c, dem::Vec<D> gravity = {}, double skin = 1e-3)
{
    dem::ContactConfig contact;
    contact.normal_stiffness = c.stiffness;
    contact.damping_ratio = c.damping_ratio;
    contact.tangential_stiffness = c.tangential_ratio * c.stiffness;
    contact.tangential_damping = c.tangential_damping;
    contact.friction = c.friction;
    dem::Setup<D> s;
    s.gravity = gravity;
    s.law = dem::contact_law(contact);
    s.skin = skin;
    s.features = {.friction = c.friction > 0.0, .ledger = c.ledger};
    return s;
}

//! A wall with the laws of the grains.
template <int D>
void add_wall(dem::Setup<D>& s, std::type_identity_t<dem::Vec<D>> point, std::type_identity_t<dem::Vec<D>> normal)
{
    s.walls.push_back({.name = "wall " + std::to_string(s.walls.size()),
                       .shape = dem::Plane<D>{point, normal},
                       .motion = {},
                       .law = s.law});
}

//! Adds a body of any mass and inertia factor I* (disc 1/2, sphere 2/5): the laws see only these numbers.
template <int D>
void add_body(dem::Grains<D>& g, std::type_identity_t<dem::Vec<D>> centre, double radius, double mass,
              double inertia_factor, dem::Motion<D> const& motion = {})
{
    std::size_t const id = g.add(centre, radius, 1.0, motion);
    g.mass[id] = mass;
    g.inertia[id] = inertia_factor * mass * radius * radius;
}

//! The sphere of study C: D = 8 mm, 2650 kg/m3.
inline constexpr double sphere_radius = 4e-3;
inline constexpr double sphere_mass = 2650.0 * std::numbers::pi / 6.0 * 8e-3 * 8e-3 * 8e-3;

//! A column of discs of 1 to 1.8 mm as in the collapse scenes.
inline std::string column_text(int count, double aspect_ratio, double packing_friction = 0.1)
{
    return "density: 2650\ndiameter: {min: 1.0e-3, max: 1.8e-3}\n"
           "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, tangential_damping: 0.2, friction_angle: 26}\n"
           "walls:\n  - {name: floor, point: [0, 0], normal: [0, 1]}\n  - {name: back, point: [0, 0], normal: [1, 0]}\n"
           "column: {count: " +
           std::to_string(count) + ", aspect_ratio: " + std::to_string(aspect_ratio) +
           ", packing_friction: " + std::to_string(packing_friction) + "}\n";
}

inline dem::Config column(int count, double aspect_ratio, double packing_friction = 0.1)
{
    auto const text = column_text(count, aspect_ratio, packing_friction);
    return dem::read_config(sluice::read_yaml(text, "column.yaml"), 2, {0.0, -9.81, 0.0});
}

}  // namespace scenes
