#pragma once

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

}  // namespace lbm
