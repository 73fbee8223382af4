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

//! Work space of rasterise(), one for each thread: for each column of cells |x| of its edges, the arc's height there,
//! and the area in one row.
struct RasterScratch
{
    std::vector<double> inner, outer, top, bottom, area;
};

//! Exact area fraction eps of a disc in every cell of its box [-], to rounding: sum = pi radius^2.
//!
//! In a cell on one side of both centre lines the arc runs between heights and half widths clamped to the cell's edges:
//! below it lie a rectangle, a trapezium and a segment, all in closed form, and the same formula holds for cells wholly
//! inside and outside: no branch, so that cells go several at a time. The row and the column of the centre count
//! twice, once for each side. One root for each grid line and cell, no trigonometric function (from radius 4 on).
//! `fraction`: height rows of equal length >= width; what a row has beyond width is set to 0. `columns` (2 height
//! entries): begin and end of the covered cells of each row, in cells from x0.
void rasterise(double x, double y, double radius, DiscBox const& box, std::span<double> fraction,
               std::span<std::ptrdiff_t> columns, RasterScratch& scratch);

}  // namespace lbm
