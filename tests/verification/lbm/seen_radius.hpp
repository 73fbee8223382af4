#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace lattice_case {

//! Concentration and drag of an array; three of them, by concentration.
using DragTable = std::array<std::pair<double, double>, 3>;

//! Discs: Sangani and Acrivos, F/(mu U); spheres: Zick and Homsy, K; both recomputed to 7 digits.
inline constexpr DragTable disc_drag{{{0.1, 24.83167525}, {0.2, 51.52694896}, {0.3, 102.8813037}}},
    sphere_drag{{{0.125, 4.2915892}, {0.216, 7.4419536}, {0.343, 15.3994874}}};

//! The radius [cells] with which a body in a periodic box of `side` cells would have this drag: the table's power law
//! between two entries, which is off by a few per cent of what the radius differs from that of the middle one.
template <int D>
double seen_radius(double side, double drag)
{
    DragTable const& table = D == 2 ? disc_drag : sphere_drag;
    std::size_t const k = drag > table[1].second ? 1 : 0;
    auto const& [low, low_drag] = table[k];
    auto const& [high, high_drag] = table[k + 1];
    double const c = low * std::pow(high / low, std::log(drag / low_drag) / std::log(high_drag / low_drag));
    return side * (D == 2 ? std::sqrt(c / std::numbers::pi) : 0.5 * std::cbrt(6 * c / std::numbers::pi));
}

}  // namespace lattice_case
