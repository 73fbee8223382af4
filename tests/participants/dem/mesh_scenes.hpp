#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/participants/dem/scenes.hpp"

//! Surfaces of triangles and a sphere on them.
namespace unit {

using dem::Vec3;
using Triangles = std::vector<std::array<Vec3, 3>>;

inline dem::Shape<3> mesh_of(Triangles const& triangles)
{
    std::vector<dem::Facet<3>> facets;
    for (auto const& corner : triangles) facets.push_back(dem::facet_of(corner));
    return dem::Mesh<3>{std::make_shared<dem::FacetTree<3> const>(std::move(facets))};
}
inline dem::Shape<2> mesh_of(std::vector<std::array<dem::Vec2, 2>> const& segments)
{
    std::vector<dem::Facet<2>> facets;
    for (auto const& corner : segments) facets.push_back(dem::facet_of(corner));
    return dem::Mesh<2>{std::make_shared<dem::FacetTree<2> const>(std::move(facets))};
}

//! A quadrilateral cut along its diagonal from a to c.
inline void add_quad(Triangles& to, Vec3 a, Vec3 b, Vec3 c, Vec3 d)
{
    to.push_back({a, b, c});
    to.push_back({a, c, d});
}

//! Where a direction of the plane (x, y) and the height z are in a scene that is turned as a whole.
struct Axes
{
    Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

    Vec3 operator()(double a, double b, double c) const { return a * x + b * y + c * z; }
};
inline Axes turned()
{
    Vec3 const z = (1.0 / std::sqrt(14.0)) * Vec3{1.0, -2.0, 3.0};
    Vec3 const x = dem::across(z);
    return {x, dem::cross(z, x), z};
}

//! A floor of `cells` x `cells` squares cut into triangles, from -half to half; `height(x, y)` [m] of its corners.
template <class Height>
Triangles sheet(int cells, double half, Axes const& axes, Height&& height)
{
    Triangles floor;
    std::vector<Vec3> corners;
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j) {
            double const x = half * (2.0 * i / cells - 1.0), y = half * (2.0 * j / cells - 1.0);
            corners.push_back(axes(x, y, height(x, y)));
        }
    auto const at = [&](int i, int j) { return corners[static_cast<std::size_t>(i * (cells + 1) + j)]; };
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
            if ((i + j) % 2 == 0)
                add_quad(floor, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            else
                add_quad(floor, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), at(i, j));
    return floor;
}
inline Triangles flat(int cells, double half, Axes const& axes = {})
{
    return sheet(cells, half, axes, [](double, double) { return 0.0; });
}

//! Spheres of 5 mm: t_c = 8.3e-4 s, a static overlap of 1.4e-6 m.
inline constexpr double sphere_radius = 5e-3, sphere_stiffness = 1e4, sphere_step = 1.5e-5;

inline dem::ContactConfig sphere_contact(double friction, dem::Rolling rolling = dem::Rolling::none)
{
    dem::ContactConfig c = rolling_contact(friction, rolling);
    c.normal_stiffness = sphere_stiffness;
    c.tangential_stiffness = sphere_stiffness * 2.0 / 7.0;
    return c;
}

inline dem::Setup<3> sphere_setup(dem::ContactConfig const& contact, Axes const& axes = {})
{
    dem::Setup<3> s;
    s.gravity = axes(0.0, 0.0, -9.81);
    s.law = dem::contact_law(contact);
    s.skin = 2e-3;
    s.features = {.elasticity = contact.elasticity, .friction = contact.friction > 0.0, .rolling = contact.rolling};
    return s;
}

inline void add_wall(dem::Setup<3>& s, dem::Shape<3> shape, std::string const& name = "mesh")
{
    s.walls.push_back({.name = name, .shape = std::move(shape), .motion = {}, .law = s.law});
}

inline dem::Grains<3> sphere(Vec3 centre, Vec3 velocity = {}, Vec3 spin = {})
{
    dem::Grains<3> g;
    dem::Motion<3> motion{};
    motion.velocity = velocity, motion.spin = spin;
    g.add(centre, sphere_radius, density, motion);
    return g;
}

//! Brings spheres to rest by a drag: a share of the critical one of a sphere on one contact.
inline void settle(dem::Solver<3>& solver, int steps, double share)
{
    for (int n = 0; n < steps; ++n) {
        auto& g = solver.grains();
        for (std::size_t i = 0; i < g.size(); ++i) {
            double const drag = share * 2.0 * std::sqrt(sphere_stiffness * g.mass[i]);
            g.external[i].force = -drag * g.motion[i].velocity;
        }
        solver.step(sphere_step);
    }
}

}  // namespace unit
