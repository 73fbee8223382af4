#pragma once

#include <algorithm>
#include <cmath>

#include "participants/lbm/config.hpp"

//! Fills a box of the lattice with solid.
template <int D>
void add_block(lbm::Config& c, std::array<double, 3> const& from, std::array<double, 3> const& to)
{
    lbm::Solid block;
    block.name = "block";
    block.shape = lbm::Solid::Shape::box;
    for (std::size_t k = 0; k < D; ++k) {
        block.centre[k] = 0.5 * (from[k] + to[k]);
        block.size[k] = to[k] - from[k];
    }
    c.solids.push_back(block);
}

//! A basin in the lowest corner of a box, the rest solid; each way the same share of the box. Returns the fluid's
//! share.
template <int D>
double add_basin(lbm::Config& c, double share)
{
    std::array<double, 3> low{}, basin{}, fluid{};
    double cells = 1, all = 1;
    for (std::size_t k = 0; k < D; ++k) {
        basin[k] = std::round(std::pow(share, 1.0 / D) * c.size[k]);
        cells *= basin[k];
        all *= c.size[k];
    }
    fluid = c.size;
    for (std::size_t k = 0; k < D; ++k) {  // beyond the basin along k, within it along those before
        low[k] = basin[k];
        add_block<D>(c, low, fluid);
        low[k] = 0;
        fluid[k] = basin[k];
    }
    return cells / all;
}

//! Fluid over the floor of a box in space, the rest solid. Returns the fluid's share.
inline double add_layer(lbm::Config& c, double share)
{
    double const depth = std::round(share * c.size[2]);
    add_block<3>(c, {0, 0, depth}, c.size);
    return depth / c.size[2];
}

//! A channel along x in the middle of a box, as wide as high. Returns the fluid's share.
inline double add_straight_duct(lbm::Config& c, double share)
{
    auto const [nx, ny, nz] = c.size;
    double const width = std::round(std::sqrt(share * ny * nz)), front = std::round(0.5 * (ny - width)),
                 below = std::round(0.5 * (nz - width));
    add_block<3>(c, {0, 0, 0}, {nx, ny, below});
    add_block<3>(c, {0, 0, below + width}, {nx, ny, nz});
    add_block<3>(c, {0, 0, below}, {nx, front, below + width});
    add_block<3>(c, {0, front + width, below}, {nx, ny, below + width});
    return width * width / (ny * nz);
}

//! A box of cells with a channel from its left side to its right one, once up and once down, cut out of blocks; in
//! space as high as wide.
template <int D>
struct BentChannel
{
    double nx, ny, nz;         //!< of the box [cells]
    double width;              //!< [cells]
    double corner, low, high;  //!< x of the upright part; y of both others

    //! As wide as makes it `share` of the box, or a little more. `within`: its walls across x and y lie so far within
    //! cells.
    BentChannel(lbm::Extent const& cells, double share, double within = 0)
        : nx(static_cast<double>(cells[0])),
          ny(static_cast<double>(cells[1])),
          nz(static_cast<double>(cells[2])),
          width(1 + within),
          corner(std::round(0.7 * nx) + within),
          low(std::round(0.2 * ny) + within),
          high(std::round(0.7 * ny) + within)
    {
        while (fluid() < share) ++width;
    }
    double fluid() const  //!< of the box [-]
    {
        return (nx + high - low) * width * (D == 2 ? 1 : width) / (nx * ny * nz);
    }
    void add_to(lbm::Config& c) const
    {
        double const front = D == 2 ? 0 : std::round(0.5 * (nz - width)), back = D == 2 ? 0 : front + width;
        add_block<D>(c, {0, high + width, front}, {nx, ny, back});
        add_block<D>(c, {0, 0, front}, {corner, high, back});
        add_block<D>(c, {corner + width, low + width, front}, {nx, high + width, back});
        add_block<D>(c, {corner, 0, front}, {nx, low, back});
        if constexpr (D == 3) {
            add_block<D>(c, {0, 0, 0}, {nx, ny, front});
            add_block<D>(c, {0, 0, back}, {nx, ny, nz});
        }
    }
};
