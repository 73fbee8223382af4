#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "participants/lbm/strip.hpp"

namespace lbm {

//! The smallest box of cells that holds a sphere: lowest cell and number of cells along x, y, z.
struct SphereBox
{
    std::array<std::ptrdiff_t, 3> first, size;
};
SphereBox sphere_box(std::array<double, 3> const& centre, double radius) noexcept;

//! Volume fraction eps of a sphere in every cell of its box [-], off by 0.012 at most, 0.002 in the mean square of the
//! cells that its surface cuts, 2e-4 in the sum (radius 2.5 and more).
//!
//! The sphere is the same along all axes: in each cell that is taken for z along which the surface lies flattest, and
//! the height of the sphere over the cell's floor, between 0 and 1, is summed at 3 x 3 Gauss points. It changes with
//! the square root of the place only where the cell is not cut: no branch, so that cells go several at a time.
//! `listed`: fractions of cells that may be covered in part, most_listed() and RowCover::slack. `rows`, y fastest: what
//! is covered of each row along x, in cells from the box's first; of some nothing.
void rasterise(std::array<double, 3> const& centre, double radius, SphereBox const& box, std::span<double> listed,
               std::span<RowCover> rows);

//! Room for the fractions of one sphere that rasterise() lists, RowCover::slack not counted.
std::size_t most_listed_of_sphere(double radius) noexcept;

}  // namespace lbm
