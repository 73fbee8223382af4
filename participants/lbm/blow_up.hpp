#pragma once

#include "participants/lbm/populations.hpp"

namespace lbm {

inline constexpr double speed_limit = 0.4;   //!< cells a step: beyond, the equilibrium goes negative
inline constexpr double excess_limit = 0.5;  //!< |rho/rho_0 - 1|

//! Whether any of a row's nx cells is beyond the limits or not finite.
template <int D>
bool has_blown_up(Slots<D> const& f, std::ptrdiff_t nx) noexcept;

}  // namespace lbm
