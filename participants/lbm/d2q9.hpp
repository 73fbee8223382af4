#pragma once

#include <array>

namespace lbm {

inline constexpr int directions = 9;

//! D2Q9, numbered as Lallemand and Luo, Phys. Rev. E 61 (2000) 6546:
//!     6 2 5
//!     3 0 1      x to the right, y up; sound speed c_s = 1/sqrt(3) cells a step
//!     7 4 8
inline constexpr std::array<int, directions> cx = {0, 1, 0, -1, 0, 1, -1, -1, 1};
inline constexpr std::array<int, directions> cy = {0, 0, 1, 0, -1, 1, 1, -1, -1};
inline constexpr std::array<int, directions> opposite = {0, 3, 4, 1, 2, 7, 8, 5, 6};
inline constexpr std::array<double, directions> weight = {4.0 / 9,  1.0 / 9,  1.0 / 9,  1.0 / 9, 1.0 / 9,
                                                          1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36};

//! Equilibrium of direction q, shifted: f_eq - w_q [-]. `density_excess` = rho - 1, velocity in cells a step.
inline constexpr double equilibrium(int q, double density_excess, double ux, double uy) noexcept
{
    auto const k = static_cast<std::size_t>(q);
    double const cu = cx[k] * ux + cy[k] * uy;
    double const second = 3.0 * cu + 4.5 * cu * cu - 1.5 * (ux * ux + uy * uy);
    return weight[k] * (density_excess + (1.0 + density_excess) * second);
}

}  // namespace lbm
