#pragma once

#include <cmath>

//! Basis functions along one axis, as policies. Coordinates in cells from the grid's node 0. Each has
//!
//!     width        nodes that a point reaches
//!     first(x)     the lowest of them
//!     value(d)     at d = x - node
//!     slope(d)     its derivative [1/cell]
//!
//! and sums to 1 over the nodes, everywhere. In several dimensions: the product.
namespace mpm {

//! Hat functions: points are points. Forces jump when one crosses a cell's side.
struct Linear
{
    static constexpr int width = 2;
    explicit Linear(double /*half_width*/) {}
    int first(double x) const { return static_cast<int>(std::floor(x)); }
    double value(double d) const { return std::abs(d) < 1 ? 1 - std::abs(d) : 0; }
    double slope(double d) const { return d >= 0 && d < 1 ? -1 : d < 0 && d >= -1 ? 1 : 0; }
};

//! Hat functions averaged over the width of the point, which stays as it was at the start (uGIMP). Source: Bardenhagen
//! and Kober, CMES 5 (2004) 477. half_width [cells], 0 to 1/2: three nodes then suffice.
struct Gimp
{
    static constexpr int width = 3;
    explicit Gimp(double half_width) : half_width(half_width) {}
    int first(double x) const { return static_cast<int>(std::floor(x - 0.5)); }
    double value(double d) const
    {
        double const l = half_width, a = std::abs(d);
        if (a < l) return 1 - (a * a + l * l) / (2 * l);
        if (a < 1 - l) return 1 - a;
        return a < 1 + l ? (1 + l - a) * (1 + l - a) / (4 * l) : 0;
    }
    double slope(double d) const
    {
        double const l = half_width, a = std::abs(d);
        if (a < l) return -d / l;
        double const steep = a < 1 - l ? 1 : a < 1 + l ? (1 + l - a) / (2 * l) : 0;
        return d < 0 ? steep : -steep;
    }
    double half_width;
};

//! Quadratic B-splines. Source: Steffen, Kirby and Berzins, Int. J. Numer. Meth. Eng. 76 (2008) 922.
struct Spline
{
    static constexpr int width = 3;
    explicit Spline(double /*half_width*/) {}
    int first(double x) const { return static_cast<int>(std::floor(x - 0.5)); }
    double value(double d) const
    {
        double const a = std::abs(d);
        if (a < 0.5) return 0.75 - a * a;
        return a < 1.5 ? 0.5 * (1.5 - a) * (1.5 - a) : 0;
    }
    double slope(double d) const
    {
        double const a = std::abs(d);
        if (a < 0.5) return -2 * d;
        double const steep = a < 1.5 ? 1.5 - a : 0;
        return d < 0 ? steep : -steep;
    }
};

//! No product of the axes (parallelepiped.hpp).
struct Cpdi
{};

enum class BasisKind
{
    gimp,
    linear,
    spline,
    cpdi
};

//! Rings of nodes around the domain that points may reach. Of a parallelepiped: its edges end within one cell along
//! each of `dimension` axes, its middle within half of one.
constexpr int rings_of_nodes(BasisKind basis, int dimension)
{
    return basis == BasisKind::cpdi ? dimension + 1 : 1;
}

}  // namespace mpm
