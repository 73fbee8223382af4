#pragma once

#include <cstddef>

namespace sluice {

//! What a scene calls the sides of a box: the lower and the upper one along x, then y, then z. In the plane y is up, in
//! space z.
constexpr char const* side_name(int dimension, std::size_t side) noexcept
{
    constexpr char const* plane[] = {"left", "right", "bottom", "top", "", ""};
    constexpr char const* space[] = {"left", "right", "front", "back", "bottom", "top"};
    return (dimension == 2 ? plane : space)[side];
}

}  // namespace sluice
