#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "participants/files/stl_file.hpp"

//! Closed surfaces of triangles, corners counter-clockwise as seen from outside.
namespace surfaces {

using Surface = std::vector<files::Triangle>;

inline void add_quad(Surface& to, files::Point const& a, files::Point const& b, files::Point const& c,
                     files::Point const& d)
{
    to.push_back({a, b, c});
    to.push_back({a, c, d});
}

inline Surface box(files::Point const& low, files::Point const& high)
{
    Surface s;
    auto const at = [&](int x, int y, int z) {
        return files::Point{x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]};
    };
    add_quad(s, at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
    add_quad(s, at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
    add_quad(s, at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    add_quad(s, at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
    add_quad(s, at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
    add_quad(s, at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
    return s;
}

//! Corners on a sphere: `half` bands from pole to pole, twice as many meridians; then scaled about the centre so that
//! the volume is the sphere's.
inline Surface sphere(files::Point const& centre, double radius, int half)
{
    double const pi = std::numbers::pi;
    auto const at = [&](int band, int meridian) {
        double const polar = pi * band / half, around = pi * (meridian % (2 * half)) / half;
        double const across = band == 0 || band == half ? 0.0 : std::sin(polar);
        return files::Point{across * std::cos(around), across * std::sin(around), std::cos(polar)};
    };
    Surface s;
    for (int m = 0; m < 2 * half; ++m)
        for (int b = 0; b < half; ++b) {
            if (b + 1 < half) s.push_back({at(b, m), at(b + 1, m), at(b + 1, m + 1)});
            if (b > 0) s.push_back({at(b, m), at(b + 1, m + 1), at(b, m + 1)});
        }
    double volume = 0;
    for (auto const& [a, b, c] : s)
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0])) /
                  6;
    double const scale = radius * std::cbrt(4.0 / 3.0 * pi / volume);
    for (auto& t : s)
        for (auto& corner : t)
            for (std::size_t k = 0; k < 3; ++k) corner[k] = centre[k] + scale * corner[k];
    return s;
}

inline Surface turned_inside_out(Surface s)
{
    for (auto& t : s) std::swap(t[1], t[2]);
    return s;
}

}  // namespace surfaces
