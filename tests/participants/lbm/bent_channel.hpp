#pragma once

#include <array>
#include <vector>

#include "participants/lbm/config.hpp"

//! A solid at rest between two corners.
inline lbm::Solid block(std::array<double, 3> const& low, std::array<double, 3> const& high)
{
    lbm::Solid solid;
    solid.name = "block";
    solid.shape = lbm::Solid::Shape::box;
    for (std::size_t k = 0; k < 3; ++k) {
        solid.centre[k] = 0.5 * (low[k] + high[k]);
        solid.size[k] = high[k] - low[k];
    }
    return solid;
}

//! Leave an S of 10 cells across, from the left side to the right one, about a tenth of a box of 160 x 120.
inline std::vector<lbm::Solid> bent_channel_solids()
{
    return {block({0, 100.3, 0}, {160, 120, 0}), block({0, 0, 0}, {100, 90, 0}), block({110, 30, 0}, {160, 101, 0}),
            block({99, 0, 0}, {160, 20, 0})};
}
