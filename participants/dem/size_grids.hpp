#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "participants/dem/vec.hpp"

namespace dem {

//! Grains that are placed one by one, never smaller ones before larger ones; asks whether there is room for another.
//! A grid for each factor of two in size, as in neighbours.hpp.
template <int D>
class SizeGrids
{
 public:
    //! `radii`: of all grains to come, descending.
    SizeGrids(Vec<D> low, Vec<D> high, std::vector<double> const& radii) : low_(low)
    {
        double const most = 8.0 * static_cast<double>(radii.size()) + 64.0;  // cells
        for (double const radius : radii) {
            if (!grids_.empty() && radius > 0.5 * grids_.back().largest) continue;
            Grid grid{.largest = radius, .cell = 2.0 * radius, .count = {1, 1, 1}, .head = {}};
            auto const cells = [&] {
                double product = 1.0;
                for (int k = 0; k < D; ++k) product *= component(high - low, k) / grid.cell + 1.0;
                return product;
            };
            while (cells() > most) grid.cell *= 1.5;
            std::size_t all = 1;
            for (std::size_t k = 0; k < D; ++k) {
                grid.count[k] = static_cast<std::ptrdiff_t>(component(high - low, static_cast<int>(k)) / grid.cell) + 1;
                all *= static_cast<std::size_t>(grid.count[k]);
            }
            grid.head.assign(all, none);
            grids_.push_back(std::move(grid));
        }
    }

    bool is_free(Vec<D> centre, double radius) const
    {
        return std::none_of(grids_.begin(), grids_.end(),
                            [&](Grid const& grid) { return touches(grid, centre, radius); });
    }

    void add(Vec<D> centre, double radius)
    {
        auto grid = grids_.begin();
        while (std::next(grid) != grids_.end() && radius <= std::next(grid)->largest) ++grid;
        auto const at = cell_of(*grid, centre);
        std::uint32_t& head = grid->head[index(*grid, at)];
        next_.push_back(head);
        head = static_cast<std::uint32_t>(centre_.size());
        centre_.push_back(centre);
        radius_.push_back(radius);
    }

 private:
    static constexpr std::uint32_t none = 0xffffffff;
    using Cell = std::array<std::ptrdiff_t, 3>;
    struct Grid
    {
        double largest, cell;             //!< radius, edge [m]
        Cell count;                       //!< of cells each way
        std::vector<std::uint32_t> head;  //!< first grain of each cell, x fastest
    };

    Cell cell_of(Grid const& grid, Vec<D> at) const
    {
        Cell cell{0, 0, 0};
        for (std::size_t k = 0; k < D; ++k) {
            double const n = std::floor(component(at - low_, static_cast<int>(k)) / grid.cell);
            cell[k] = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(n), 0, grid.count[k] - 1);
        }
        return cell;
    }
    static std::size_t index(Grid const& grid, Cell const& at)
    {
        std::ptrdiff_t sum = 0;
        for (std::size_t k = D; k-- > 0;) sum = sum * grid.count[k] + at[k];
        return static_cast<std::size_t>(sum);
    }
    bool touches(Grid const& grid, Vec<D> centre, double radius) const
    {
        Vec<D> edge;
        for (int k = 0; k < D; ++k) component<D>(edge, k) = radius + grid.largest;
        Cell const from = cell_of(grid, centre - edge), to = cell_of(grid, centre + edge);
        for (Cell at = from; at[2] <= to[2]; ++at[2])
            for (at[1] = from[1]; at[1] <= to[1]; ++at[1])
                for (at[0] = from[0]; at[0] <= to[0]; ++at[0])
                    for (std::uint32_t i = grid.head[index(grid, at)]; i != none; i = next_[i]) {
                        Vec<D> const apart = centre - centre_[i];
                        double const reach = radius + radius_[i];
                        if (dot(apart, apart) < reach * reach) return true;
                    }
        return false;
    }

    Vec<D> low_;
    std::vector<Grid> grids_;
    std::vector<Vec<D>> centre_;
    std::vector<double> radius_;
    std::vector<std::uint32_t> next_;  //!< grain of the same cell
};

}  // namespace dem
