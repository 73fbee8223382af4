#pragma once

#include <array>

#include "participants/mpm/axial.hpp"
#include "participants/mpm/grid.hpp"

namespace mpm {

//! Weights and slopes of the nodes that one point reaches, axis by axis.
template <int D, class Basis>
struct Stencil
{
    std::array<int, D> first{};
    std::array<std::array<double, Basis::width>, D> weight{}, slope{};  //!< [-], [1/m]
    std::array<double, Basis::width> around{};                          //!< hoop along x, of rings [1/m]

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

    //! Makes weights of the plane those of rings: `radius` and `half_width` in cells.
    void turn_around(double radius, double half_width, double place, double cell)
    {
        for (int j = 0; j < Basis::width; ++j) {
            auto const k = static_cast<std::size_t>(j);
            Moments const m = moments_of_hat(place - (first[0] + j), half_width);
            around[k] = weight[0][k] / (radius * cell);
            weight[0][k] += m.value / radius;
            slope[0][k] += m.slope / (radius * cell);
        }
    }
    //! each(node, hoop), of rings
    template <class Nodes, class Each>
    void each_hoop(Nodes& grid, Each&& each) const
    {
        constexpr std::size_t width = Basis::width;
        if constexpr (D == 2)
            for (std::size_t c = 0; c < width * width; ++c)
                each(grid.reach({first[0] + static_cast<int>(c % width), first[1] + static_cast<int>(c / width)}),
                     around[c % width] * weight[1][c / width]);
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
