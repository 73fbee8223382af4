#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lbm {

//! Where the area fractions of one disc go: cells [x0, x0 + width) x [y0, y0 + height), row by row, cell (i, j) being
//! the square [i, i+1] x [j, j+1] (unit: cells).
struct DiscBox
{
    std::ptrdiff_t x0, y0, width, height;
};

//! The smallest box of cells that holds the disc.
DiscBox disc_box(double x, double y, double radius) noexcept;

//! Area of a circle's segment over a chord [cells^2]; q = chord/(2 radius) in [0, 1].
double segment_area(double q, double radius) noexcept;

//! Work space of rasterise(), one for each thread.
struct RasterScratch
{
    std::vector<double> at_column, at_row;
};

//! Exact area fraction eps of a disc in every cell of its box [-], to rounding: sum = pi radius^2.
//!
//! Each quadrant is walked along the arc. The arc enters a cell through one grid line and leaves through another; under
//! such a piece lie a trapezium and a segment, whose areas are in closed form. One square root for each grid line, no
//! trigonometric function. `fraction` has width * height entries. `columns` (2 height entries): begin and end of the
//! covered cells of each row, in cells from x0.
void rasterise(double x, double y, double radius, DiscBox const& box, std::span<double> fraction,
               std::span<std::ptrdiff_t> columns, RasterScratch& scratch);

}  // namespace lbm
