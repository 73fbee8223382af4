#include "participants/lbm/disc_area.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace lbm {
namespace {

//! One quadrant, mirrored so that it is x > 0, y > 0 from the disc's centre. Cell i covers [i - x, i + 1 - x].
struct Quadrant
{
    double x, y, radius;  //!< mirrored centre
    int sign_x, sign_y;   //!< of the mirror
    DiscBox box;
    double* fraction;
    std::ptrdiff_t* columns;

    std::ptrdiff_t column(std::ptrdiff_t i) const { return (sign_x > 0 ? i : -i - 1) - box.x0; }
    std::ptrdiff_t row(std::ptrdiff_t j) const { return (sign_y > 0 ? j : -j - 1) - box.y0; }

    void walk(RasterScratch& scratch) const;
    void open_row(std::ptrdiff_t i, std::ptrdiff_t j) const;
    void close_row(std::ptrdiff_t i, std::ptrdiff_t j, double height) const;
};

//! The arc enters row j in cell i, its outermost: note the row's extent.
void Quadrant::open_row(std::ptrdiff_t i, std::ptrdiff_t j) const
{
    std::ptrdiff_t* const extent = columns + 2 * row(j);
    extent[0] = std::min(extent[0], column(i));
    extent[1] = std::max(extent[1], column(i) + 1);
}

//! Fills the cells between the arc's last cell i and the centre line: all of them are covered over `height`.
void Quadrant::close_row(std::ptrdiff_t i, std::ptrdiff_t j, double height) const
{
    double* const line = fraction + row(j) * box.width;
    auto const centre = static_cast<std::ptrdiff_t>(std::floor(x));
    if (i <= centre) return;
    std::ptrdiff_t const first = sign_x > 0 ? column(centre + 1) : column(i - 1);
    for (std::ptrdiff_t k = first; k < first + (i - 1 - centre); ++k) line[k] += height;
    line[column(centre)] += height * (static_cast<double>(centre + 1) - x);
}

void Quadrant::walk(RasterScratch& scratch) const
{
    auto const first_i = static_cast<std::ptrdiff_t>(std::ceil(x + radius)) - 1;
    auto const first_j = static_cast<std::ptrdiff_t>(std::floor(y));
    auto const columns_crossed = first_i - static_cast<std::ptrdiff_t>(std::floor(x));
    auto const rows_crossed = static_cast<std::ptrdiff_t>(std::ceil(y + radius)) - 1 - first_j;
    double const inverse_diameter = 0.5 / radius;
    for (std::ptrdiff_t k = 0; k < columns_crossed; ++k) {
        double const at = static_cast<double>(first_i - k) - x;
        scratch.at_column[static_cast<std::size_t>(k)] = std::sqrt((radius - at) * (radius + at));
    }
    for (std::ptrdiff_t k = 0; k < rows_crossed; ++k) {
        double const at = static_cast<double>(first_j + 1 + k) - y;
        scratch.at_row[static_cast<std::size_t>(k)] = std::sqrt((radius - at) * (radius + at));
    }
    double px = radius, py = 0, height = 0;  // the arc so far; height of it in this row
    std::ptrdiff_t ci = 0, cj = 0;           // grid lines crossed
    open_row(first_i, first_j);
    for (bool done = false; !done;) {
        std::ptrdiff_t const i = first_i - ci, j = first_j + cj;
        double const left = ci < columns_crossed ? static_cast<double>(i) - x : 0.0;
        double const next_column = ci < columns_crossed ? scratch.at_column[static_cast<std::size_t>(ci)] : radius;
        double const next_row = cj < rows_crossed ? static_cast<double>(j + 1) - y : radius;
        bool const up = cj < rows_crossed && next_row < next_column;
        done = !up && ci == columns_crossed;
        double const qx = up ? scratch.at_row[static_cast<std::size_t>(cj)] : left;
        double const qy = up ? next_row : next_column;
        double const dx = px - qx, dy = qy - py;
        double const chord = std::sqrt(dx * dx + dy * dy);
        double const width = static_cast<double>(i + 1) - x - left;
        fraction[row(j) * box.width + column(i)] +=
            height * width + dy * (0.5 * (px + qx) - left) + segment_area(chord * inverse_diameter, radius);
        height += dy;
        if (up || done) {
            close_row(i, j, height);
            height = 0;
        }
        if (up) {
            ++cj;
            open_row(i, j + 1);
        } else {
            ++ci;
        }
        px = qx;
        py = qy;
    }
}

}  // namespace

DiscBox disc_box(double x, double y, double radius) noexcept
{
    auto const floor = [](double v) { return static_cast<std::ptrdiff_t>(std::floor(v)); };
    std::ptrdiff_t const x0 = floor(x - radius), y0 = floor(y - radius);
    return {x0, y0, floor(x + radius) + 1 - x0, floor(y + radius) + 1 - y0};
}

double segment_area(double q, double radius) noexcept
{
    double const q2 = q * q;
    if (q < 0.1)  // (theta - sin theta)/2 with theta = 2 asin q, to 1e-12 of it
        return radius * radius * q * q2 *
               (2.0 / 3 + q2 * (1.0 / 5 + q2 * (3.0 / 28 + q2 * (5.0 / 72 + q2 * (35.0 / 704)))));
    double const half_angle = std::asin(std::min(q, 1.0));
    return radius * radius * (half_angle - q * std::sqrt(std::max(0.0, 1.0 - q2)));
}

void rasterise(double x, double y, double radius, DiscBox const& box, std::span<double> fraction,
               std::span<std::ptrdiff_t> columns, RasterScratch& scratch)
{
    assert(radius > 0 && std::isfinite(x) && std::isfinite(y));
    std::fill(fraction.begin(), fraction.end(), 0.0);
    for (std::size_t j = 0; j < columns.size(); j += 2) {
        columns[j] = box.width;
        columns[j + 1] = 0;
    }
    auto const lines = static_cast<std::size_t>(radius) + 3;
    if (scratch.at_column.size() < lines) scratch.at_column.resize(lines), scratch.at_row.resize(lines);
    for (int const sign_x : {1, -1}) {
        for (int const sign_y : {1, -1})
            Quadrant{sign_x * x, sign_y * y, radius, sign_x, sign_y, box, fraction.data(), columns.data()}.walk(
                scratch);
    }
}

}  // namespace lbm
