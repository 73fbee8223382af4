#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "participants/lbm/populations.hpp"

namespace lbm {

inline constexpr double speed_limit = 0.4;   //!< cells a step: beyond, the equilibrium goes negative
inline constexpr double excess_limit = 0.5;  //!< |rho/rho_0 - 1|

//! Whether any of a row's nx cells is beyond the limits or not finite.
template <int D, class Stored>
bool has_blown_up(Slots<D, Stored> const& f, std::ptrdiff_t nx) noexcept;

//! The first such cell.
template <int D, class Stored>
std::optional<std::ptrdiff_t> first_blown_up(Slots<D, Stored> f, std::ptrdiff_t nx) noexcept
{
    for (std::ptrdiff_t x = 0; x < nx; ++x) {
        if (has_blown_up<D>(f, 1)) return x;
        for (Stored*& slot : f) ++slot;
    }
    return {};
}

//! Speed [cells a step] and density over rho_0 of a row's cell x as the limits are of: before forces and solids act.
template <int D, class Stored>
std::array<double, 2> speed_and_density(Slots<D, Stored> const& f, std::ptrdiff_t x)
{
    double density = 1, square = 0;
    std::array<double, D> j{};
    for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
        density += f[q][x];
        for (std::size_t k = 0; k < D; ++k) j[k] += Lattice<D>::c[q][k] * double{f[q][x]};
    }
    for (double const component : j) square += component * component;
    return {std::sqrt(square) / density, density};
}

}  // namespace lbm
