#pragma once

#include <array>

#include "participants/mpm/grid.hpp"

namespace mpm {

//! Weights and slopes of the nodes that one point reaches, axis by axis.
template <int D, class Basis>
struct Stencil
{
    std::array<int, D> first{};
    std::array<std::array<double, Basis::width>, D> weight{}, slope{};  //!< [-], [1/m]

    //! `place` in cells from node 0, `half_width` of the point along each axis in cells.
    Stencil(Vec<D> const& half_width, Vec<D> const& place, double cell)
    {
        for (std::size_t k = 0; k < D; ++k) {
            Basis const basis(half_width[static_cast<int>(k)]);
            double const x = place[static_cast<int>(k)];
            first[k] = basis.first(x);
            for (int j = 0; j < Basis::width; ++j) {
                double const d = x - (first[k] + j);
                weight[k][static_cast<std::size_t>(j)] = basis.value(d);
                slope[k][static_cast<std::size_t>(j)] = basis.slope(d) / cell;
            }
        }
    }

    //! each(node, weight, gradient of the weight)
    template <class Nodes, class Each>
    void each(Nodes& grid, Each&& each) const
    {
        constexpr std::size_t width = Basis::width;
        constexpr std::size_t count = D == 2 ? width * width : width * width * width;
        for (std::size_t c = 0; c < count; ++c) {
            std::array<std::size_t, 3> const j{c % width, c / width % width, c / width / width};
            std::array<int, D> index;
            double value = 1;
            Vec<D> gradient = Vec<D>::Ones();
            for (std::size_t k = 0; k < D; ++k) {
                index[k] = first[k] + static_cast<int>(j[k]);
                value *= weight[k][j[k]];
                for (std::size_t a = 0; a < D; ++a)
                    gradient[static_cast<int>(a)] *= a == k ? slope[k][j[k]] : weight[k][j[k]];
            }
            each(grid.reach(index), value, gradient);
        }
    }
};

}  // namespace mpm
