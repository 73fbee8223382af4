#pragma once

#include <cstdint>
#include <variant>

#include "participants/dem/state.hpp"

namespace dem {

//! A listed contact that touches.
template <int D>
struct Touch
{
    std::uint32_t first;   //!< grain
    std::uint32_t second;  //!< grain > first, or wall index + number of grains
    std::size_t at;        //!< in the history of the pairs, or of the wall
    double overlap;        //!< > 0 [m]
    double reach;          //!< Ri + Rj; a wall: 2 Ri [m]
    Vec<D> normal;         //!< unit vector, to the first
};

//! Calls `visit(Touch)` for each pair that touches, and then for each grain on a wall.
template <int D, class Visit>
void each_touch(Setup<D> const& setup, State<D> const& state, Visit&& visit)
{
    Grains<D> const& g = state.grains;
    auto const count = static_cast<std::uint32_t>(g.size());
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::uint32_t const j = state.pairs.other[slot];
            Vec<D> const from_j = apart(g, state.pairs, state.cell, i, slot);
            double const reach = g.place[i].radius + g.place[j].radius, distance = norm(from_j);
            if (distance >= reach) continue;
            Vec<D> const normal = distance > 0.0 ? (1.0 / distance) * from_j : Vec<D>{1.0};
            visit(Touch<D>{i, j, slot, reach - distance, reach, normal});
        }
    for (std::uint32_t w = 0; w < setup.walls.size(); ++w)
        std::visit(
            [&](auto const& shape) {
                WallContacts<D> const& wall = state.walls[w];
                for (std::size_t k = 0; k < wall.grain.size(); ++k) {
                    auto const& [centre, radius] = g.place[wall.grain[k]];
                    auto const facing = facing_of(shape, wall, k, centre);
                    if (!is_contact(shape, wall, k, radius - facing.distance)) continue;
                    visit(Touch<D>{wall.grain[k], count + w, k, radius - facing.distance, 2.0 * radius, facing.normal});
                }
            },
            setup.walls[w].shape);
}

}  // namespace dem
