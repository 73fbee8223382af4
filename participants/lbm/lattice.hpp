#pragma once

#include <array>
#include <cstddef>

namespace lbm {

//! The velocities of a lattice in the plane (D2Q9) or in space (D3Q19), in cells a step; sound speed c_s = 1/sqrt(3).
template <int D>
struct Lattice;

//! D2Q9, numbered as Lallemand and Luo, Phys. Rev. E 61 (2000) 6546:
//!     6 2 5
//!     3 0 1      x to the right, y up
//!     7 4 8
template <>
struct Lattice<2>
{
    static constexpr std::size_t directions = 9;
    static constexpr std::array<std::array<int, 3>, directions> c = {
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}}};
    static constexpr std::array<std::size_t, directions> opposite = {0, 3, 4, 1, 2, 7, 8, 5, 6};
    static constexpr std::array<double, directions> weight = {4.0 / 9,  1.0 / 9,  1.0 / 9,  1.0 / 9, 1.0 / 9,
                                                              1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36};
};

//! D3Q19: after rest, pairs of opposite directions.
template <>
struct Lattice<3>
{
    static constexpr std::size_t directions = 19;
    static constexpr std::array<std::array<int, 3>, directions> c = {{{0, 0, 0},
                                                                      {1, 0, 0},
                                                                      {-1, 0, 0},
                                                                      {0, 1, 0},
                                                                      {0, -1, 0},
                                                                      {0, 0, 1},
                                                                      {0, 0, -1},
                                                                      {1, 1, 0},
                                                                      {-1, -1, 0},
                                                                      {1, -1, 0},
                                                                      {-1, 1, 0},
                                                                      {1, 0, 1},
                                                                      {-1, 0, -1},
                                                                      {1, 0, -1},
                                                                      {-1, 0, 1},
                                                                      {0, 1, 1},
                                                                      {0, -1, -1},
                                                                      {0, 1, -1},
                                                                      {0, -1, 1}}};
    static constexpr std::array<std::size_t, directions> opposite = {0, 2,  1,  4,  3,  6,  5,  8,  7, 10,
                                                                     9, 12, 11, 14, 13, 16, 15, 18, 17};
    static constexpr std::array<double, directions> weight = {
        1.0 / 3,  1.0 / 18, 1.0 / 18, 1.0 / 18, 1.0 / 18, 1.0 / 18, 1.0 / 18, 1.0 / 36, 1.0 / 36, 1.0 / 36,
        1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36};
};

//! How many directions move along x.
template <int D>
inline constexpr std::ptrdiff_t along_x = D == 2 ? 6 : 10;

//! The place of each of them among these, those up x first.
template <int D>
inline constexpr auto place_along_x = [] {
    std::array<std::ptrdiff_t, Lattice<D>::directions> places{};
    std::ptrdiff_t up = 0, down = along_x<D> / 2;
    for (std::size_t q = 0; q < places.size(); ++q)
        if (int const along = Lattice<D>::c[q][0]; along != 0) places[q] = along > 0 ? up++ : down++;
    return places;
}();

//! How a body turns: about the normal of the plane, or about any axis.
template <int D>
inline constexpr std::size_t spins = D == 2 ? 1 : 3;

template <std::size_t N>
constexpr double dot(std::array<int, 3> const& c, std::array<double, N> const& v) noexcept
{
    double sum = 0;
    for (std::size_t k = 0; k < N; ++k) sum += c[k] * v[k];
    return sum;
}

constexpr std::array<double, 3> cross(std::array<double, 3> const& a, std::array<double, 3> const& b) noexcept
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

//! Moment of a vector at the end of an arm.
template <int D>
constexpr std::array<double, spins<D>> moment_of(std::array<double, D> const& arm,
                                                 std::array<double, D> const& v) noexcept
{
    if constexpr (D == 2)
        return {arm[0] * v[1] - arm[1] * v[0]};
    else
        return cross(arm, v);
}

//! Equilibrium of direction q, shifted: f_eq - w_q [-]. `density_excess` = rho - 1, velocity in cells a step.
template <int D>
constexpr double equilibrium(std::size_t q, double density_excess, std::array<double, D> const& u) noexcept
{
    double square = 0;
    for (double const v : u) square += v * v;
    double const cu = dot(Lattice<D>::c[q], u);
    double const second = 3.0 * cu + 4.5 * cu * cu - 1.5 * square;
    return Lattice<D>::weight[q] * (density_excess + (1.0 + density_excess) * second);
}

}  // namespace lbm
