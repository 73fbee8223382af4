#pragma once

#include <cmath>
#include <memory>
#include <variant>
#include <vector>

#include "participants/dem/facet_tree.hpp"
#include "participants/motion/prescribed_motion.hpp"

//! What walls look like and how they move. No physics.
namespace dem {

//! A half-space behind the plane (in the plane: line) through `point`, whose unit `normal` points to the grains.
template <int D>
struct Plane
{
    Vec<D> point;   //!< [m]
    Vec<D> normal;  //!< unit vector

    Facing<D> facing(Vec<D> centre) const noexcept { return {dot(centre - point, normal), normal}; }
};

//! A cylinder of unlimited length about `axis` (in the plane: a circle), grains inside or outside.
template <int D>
struct Cylinder
{
    Vec<D> point;         //!< of the axis [m]
    Vec<D> axis;          //!< unit vector; {} in the plane
    double radius = 0.0;  //!< [m]
    bool inside = true;   //!< the grains are inside

    Facing<D> facing(Vec<D> centre) const noexcept
    {
        Vec<D> const off = centre - point;
        Vec<D> const radial = off - dot(off, axis) * axis;
        double const length = norm(radial);
        Vec<D> const out = length > 0.0 ? (1.0 / length) * radial : any_radial();
        if (inside) return {radius - length, -out};
        return {length - radius, out};
    }

 private:
    Vec<D> any_radial() const noexcept  // on the axis every direction is as good as another
    {
        if constexpr (D == 2)
            return {1.0, 0.0};
        else
            return across(axis);
    }
};

//! A surface of triangles in space, of segments in the plane. It has two sides, and a grain may touch it in several
//! places: which, mesh_contacts.hpp says.
template <int D>
struct Mesh
{
    std::shared_ptr<FacetTree<D> const> facets;  //!< not null

    //! What its nearest point is.
    Facing<D> facing(Vec<D> centre) const noexcept { return facets->facing(centre); }
};
template <class AnyShape>
inline constexpr bool is_mesh = false;
template <int D>
inline constexpr bool is_mesh<Mesh<D>> = true;

template <int D>
using Shape = std::variant<Plane<D>, Cylinder<D>, Mesh<D>>;

template <int D>
using WallMotion = motion::PrescribedMotion<Vec<D>>;

}  // namespace dem
