#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "participants/mpm/setup.hpp"
#include "tests/support/verification.hpp"

//! What the cases of the continuum share.
namespace verification {

//! A bar along `axis` in a channel one cell wide, with rollers on all four sides: plane strain, hence one-dimensional
//! for any Poisson's ratio. `room`: domain beyond the bar's end, in cells.
inline mpm::Config bar(double length, int cells, int points, int axis = 0, int room = 4)
{
    mpm::Config c;
    auto const along = static_cast<std::size_t>(axis), across = 1 - along;
    c.cell = length / cells;
    c.points = points;
    c.flip = 1;
    c.size[along] = length + room * c.cell;
    c.size[across] = c.cell;
    mpm::BodyConfig body;
    body.high[along] = length;
    body.high[across] = c.cell;
    c.bodies.push_back(body);
    for (int k : {0, 1})
        for (int side : {-1, 1})
            c.walls.push_back({.axis = k, .side = side, .place = side < 0 ? 0 : c.size[static_cast<std::size_t>(k)]});
    return c;
}

//! The mean of f over the points, by mass.
template <class Of>
double mean(mpm::State<2> const& state, Of&& of)
{
    double sum = 0, mass = 0;
    for (auto const& p : state.points) {
        sum += p.mass * of(p);
        mass += p.mass;
    }
    return sum / mass;
}

inline std::string named(char const* pattern, double a, double b = 0)
{
    char text[100];
    std::snprintf(text, sizeof text, pattern, a, b);
    return text;
}

inline char const* name_of(mpm::BasisKind basis)
{
    char const* const names[] = {"gimp", "linear", "spline", "cpdi"};
    return names[static_cast<int>(basis)];
}

}  // namespace verification
