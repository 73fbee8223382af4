#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "participants/lbm/strip.hpp"

namespace lbm {

//! The cells [x0, x0 + width) x [y0, y0 + height), cell (i, j) being the square [i, i+1] x [j, j+1] (unit: cells).
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
    //! Of the columns or rows of cells |x| of their edges, and half the chord there. The one of the centre counts
    //! twice: its side beyond the centre at its place, the other side after all.
    struct Edges
    {
        std::vector<double> inner, outer, at_inner, at_outer;
    };
    Edges columns, rows;
    std::vector<double> area;  //!< in one row
};

//! Room for the fractions of one disc that rasterise() lists, RowCover::slack not counted.
std::size_t most_listed(double radius) noexcept;

//! Exact area fraction eps of a disc in every cell of its box [-], to rounding: sum = pi radius^2.
//!
//! In a cell on one side of both centre lines the arc runs between heights and half widths clamped to the cell's edges:
//! below it lie a rectangle, a trapezium and a segment, all in closed form, and the same formula holds for cells wholly
//! inside and outside: no branch, so that cells go several at a time. The row and the column of the centre count
//! twice, once for each side. One root for each grid line and cell, no trigonometric function (from radius 4 on).
//! `listed`: fractions of cells that are covered in part, most_listed() and RowCover::slack. `rows` (one entry a row):
//! what is covered of each, in cells from x0.
void rasterise(double x, double y, double radius, DiscBox const& box, std::span<double> listed,
               std::span<RowCover> rows, RasterScratch& scratch);

}  // namespace lbm
