#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <variant>
#include <vector>

#include "participants/dem/facet_tree.hpp"

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

//! A velocity at a time.
template <int D>
struct Knot
{
    double time = 0.0;  //!< [s]
    Vec<D> velocity;    //!< [m/s]
};

//! A wall's displacement over time:  from `begin` to `end` at `velocity`, and `amplitude` sin(2 pi f (t - begin)); and
//! by a velocity that goes straight from knot to knot, none before the first and behind the last.
template <int D>
struct WallMotion
{
    Vec<D> velocity;                                       //!< [m/s]
    Vec<D> amplitude;                                      //!< [m]
    double frequency = 0.0;                                //!< [Hz]
    double begin = 0.0;                                    //!< [s]
    double end = std::numeric_limits<double>::infinity();  //!< [s]; the wall then stays where it is

    std::vector<Knot<D>> knots;  //!< times ascending

    bool moves() const noexcept
    {
        return dot(velocity, velocity) > 0.0 || dot(amplitude, amplitude) > 0.0 || !knots.empty();
    }

    Vec<D> shift(double time) const noexcept
    {
        double const since = std::min(std::max(time, begin), end) - begin;
        Vec<D> sum = since * velocity + std::sin(2.0 * std::numbers::pi * frequency * since) * amplitude;
        for (std::size_t k = 1; k < knots.size() && knots[k - 1].time < time; ++k) {
            double const until = std::min(time, knots[k].time);
            sum += 0.5 * (until - knots[k - 1].time) * (knots[k - 1].velocity + between(k, until));
        }
        return sum;
    }
    Vec<D> speed(double time) const noexcept
    {
        Vec<D> sum{};
        if (time >= begin && time <= end) {
            double const turns = 2.0 * std::numbers::pi * frequency;
            sum = velocity + turns * std::cos(turns * (time - begin)) * amplitude;
        }
        for (std::size_t k = 1; k < knots.size(); ++k)
            if (time >= knots[k - 1].time && time < knots[k].time) return sum + between(k, time);
        return sum;
    }

 private:
    //! The velocity at a time between knots k - 1 and k.
    Vec<D> between(std::size_t k, double time) const noexcept
    {
        Knot<D> const &a = knots[k - 1], &b = knots[k];
        return a.velocity + (time - a.time) / (b.time - a.time) * (b.velocity - a.velocity);
    }
};

}  // namespace dem
