#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "participants/dem/facing.hpp"

namespace dem {

//! A triangle in space, a segment in the plane. Both of its sides are walls; it has no inside.
template <int D>
struct Facet
{
    std::array<Vec<D>, D> corner;  //!< [m]
    Vec<D> normal;                 //!< unit vector across it, to either side

    //! From its nearest point: inside the facet along its normal, else on an edge or a corner.
    Facing<D> facing(Vec<D> centre) const noexcept
    {
        if (is_under(centre)) {
            double const height = dot(centre - corner[0], normal);
            return {std::abs(height), height < 0.0 ? -normal : normal};
        }
        if constexpr (D == 2) {
            return from_edge(0, centre);
        } else {
            Facing<D> nearest = from_edge(0, centre);
            for (std::size_t k = 1; k < 3; ++k) {
                Facing<D> const other = from_edge(k, centre);
                if (other.distance < nearest.distance) nearest = other;
            }
            return nearest;
        }
    }

 private:
    Vec<D> edge(std::size_t k) const noexcept { return corner[(k + 1) % D] - corner[k]; }

    //! Whether the foot of the perpendicular from a point lies in the facet.
    bool is_under(Vec<D> point) const noexcept
    {
        if constexpr (D == 2) {
            double const along = dot(point - corner[0], edge(0));
            return along >= 0.0 && along <= dot(edge(0), edge(0));
        } else {
            for (std::size_t k = 0; k < 3; ++k)
                if (dot(point - corner[k], cross(edge(k), normal)) > 0.0) return false;
            return true;
        }
    }

    Facing<D> from_edge(std::size_t k, Vec<D> centre) const noexcept
    {
        Vec<D> const along = edge(k), off = centre - corner[k];
        double const part = dot(off, along) / dot(along, along);
        Vec<D> const from = part <= 0.0 ? off : part >= 1.0 ? centre - corner[(k + 1) % D] : off - part * along;
        double const distance = norm(from);
        return {distance, distance > 0.0 ? (1.0 / distance) * from : normal};
    }
};

//! Length of a segment [m], twice the area of a triangle [m2], with its direction across the facet.
constexpr Vec2 across_facet(std::array<Vec2, 2> const& corner) noexcept
{
    return tangent_of(corner[1] - corner[0]);
}
constexpr Vec3 across_facet(std::array<Vec3, 3> const& corner) noexcept
{
    return cross(corner[1] - corner[0], corner[2] - corner[0]);
}

//! The facet of these corners; they must not lie on a line (in the plane: in a point).
template <std::size_t D>
Facet<static_cast<int>(D)> facet_of(std::array<Vec<static_cast<int>(D)>, D> const& corner) noexcept
{
    auto const normal = across_facet(corner);
    return {corner, (1.0 / norm(normal)) * normal};
}

}  // namespace dem
