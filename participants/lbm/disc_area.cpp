#include "participants/lbm/disc_area.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace lbm {
namespace {

constexpr double series_radius = 4;  //!< from here on a series gives the segments to rounding
constexpr std::ptrdiff_t lanes = 4;

//! segment_area() for chords of at most sqrt(2) cells of a disc of at least series_radius: off by 2e-15 at most.
inline double short_segment(double chord_square, double inverse_square, double radius_square) noexcept
{
    double const q2 = chord_square * inverse_square;
    double const series =
        2.0 / 3 +
        q2 * (1.0 / 5 +
              q2 * (3.0 / 28 +
                    q2 * (5.0 / 72 + q2 * (35.0 / 704 + q2 * (63.0 / 1664 + q2 * (77.0 / 2560 + q2 * 0.02464384))))));
    return radius_square * q2 * std::sqrt(q2) * series;
}

//! The larger one; loops over std::max of what is computed fetch its address.
double larger(double a, double b) noexcept
{
    return a > b ? a : b;
}

double half_chord(double radius, double at) noexcept
{
    return std::sqrt(larger((radius - at) * (radius + at), 0.0));
}

std::ptrdiff_t whole_chunks(std::ptrdiff_t count) noexcept
{
    return (count + lanes - 1) / lanes * lanes;
}

//! Of `count` columns or rows from `first` on, the centre's being number `middle` of them; returns how many entries
//! there are. The last ones lie outside of the disc.
std::ptrdiff_t find_edges(double centre, std::ptrdiff_t first, std::ptrdiff_t count, double radius,
                          RasterScratch::Edges& edges)
{
    std::ptrdiff_t const entries = whole_chunks(count + 1) + lanes;
    for (auto* v : {&edges.inner, &edges.outer, &edges.at_inner, &edges.at_outer})
        if (v->size() < static_cast<std::size_t>(entries)) v->resize(static_cast<std::size_t>(entries));
    double *const inner = edges.inner.data(), *const outer = edges.outer.data(),
                  *const at_inner = edges.at_inner.data(), *const at_outer = edges.at_outer.data();
    auto const from = static_cast<double>(first);
#pragma omp simd
    for (int k = 0; k < static_cast<int>(entries); ++k) {
        double const at = (from + k) - centre;
        inner[k] = larger(larger(at, -(at + 1)), 0.0);
        outer[k] = larger(-at, at + 1);
    }
    auto const middle = static_cast<std::ptrdiff_t>(std::floor(centre)) - first;
    double const before = centre - static_cast<double>(first + middle);
    outer[middle] = 1 - before;
    inner[count] = 0;
    outer[count] = before;
#pragma omp simd
    for (int k = 0; k < static_cast<int>(entries); ++k) {
        at_inner[k] = half_chord(radius, inner[k]);
        at_outer[k] = half_chord(radius, outer[k]);
    }
    return entries;
}

//! A piece of a row of cells on one side of the centre: |y| from low to high, the arc at half widths wide and narrow.
struct Band
{
    double low, high, wide, narrow;
    Band(RasterScratch::Edges const& rows, std::ptrdiff_t j)
        : low(rows.inner[static_cast<std::size_t>(j)]),
          high(rows.outer[static_cast<std::size_t>(j)]),
          wide(rows.at_inner[static_cast<std::size_t>(j)]),
          narrow(rows.at_outer[static_cast<std::size_t>(j)])
    {}
};

//! Adds the area of the disc in the band, for the columns [begin, begin + count), rounded up to whole lanes.
template <bool Series>
void add_band(Band const& band, double radius, RasterScratch& s, std::ptrdiff_t begin, std::ptrdiff_t count)
{
    double const *const inner = s.columns.inner.data() + begin, *const outer = s.columns.outer.data() + begin,
                        *const top = s.columns.at_inner.data() + begin,
                        *const bottom = s.columns.at_outer.data() + begin;
    double* const area = s.area.data() + begin;
    double const radius_square = radius * radius, inverse_square = 0.25 / radius_square;
    double const low = band.low, high = band.high, wide = band.wide, narrow = band.narrow;
    std::ptrdiff_t const whole = whole_chunks(count);
    if (whole % lanes != 0) __builtin_unreachable();  // spares the loop a remainder
#pragma omp simd
    for (std::ptrdiff_t k = 0; k < whole; ++k) {
        double const y1 = std::min(std::max(bottom[k], low), high), y2 = std::min(std::max(top[k], low), high);
        double const x1 = std::min(std::max(wide, inner[k]), outer[k]);
        double const x2 = std::min(std::max(narrow, inner[k]), outer[k]);
        double const dx = x1 - x2, dy = y2 - y1, chord_square = dx * dx + dy * dy;
        double segment;
        if constexpr (Series)
            segment = short_segment(chord_square, inverse_square, radius_square);
        else
            segment = segment_area(0.5 * std::sqrt(chord_square) / radius, radius);
        area[k] += (outer[k] - inner[k]) * (y1 - low) + dy * (0.5 * (x1 + x2) - inner[k]) + segment;
    }
}

//! Which cells of a row are covered where the half width is `wide` at most, and wholly where it is `narrow` at least.
RowCover find_cover(double x, DiscBox const& box, double wide, double narrow, double radius) noexcept
{
    double const slack = 1e-9 * (1 + radius);  // far more than rounding: no covered cell lies beyond
    auto const from_box = [&](double at) {
        return static_cast<std::int32_t>(static_cast<std::ptrdiff_t>(at) - box.x0);
    };
    auto const width = static_cast<std::int32_t>(box.width);
    std::int32_t const begin = std::max(from_box(std::floor(x - wide - slack)), 0),
                       end = std::min(from_box(std::ceil(x + wide + slack)), width);
    std::int32_t inner = from_box(std::ceil(x - narrow + slack)), outer = from_box(std::floor(x + narrow - slack));
    if (inner >= outer) inner = outer = end;
    return {begin, end - begin, inner - begin, end - outer, nullptr};
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

std::size_t most_listed(double radius) noexcept
{
    // by row less than wide - narrow + 2 on each side; wide - narrow adds up to the radius above the centre, and below
    return static_cast<std::size_t>(4 * radius + 4 * (2 * radius + 2)) + 1;
}

void rasterise(double x, double y, double radius, DiscBox const& box, std::span<double> listed,
               std::span<RowCover> rows, RasterScratch& scratch)
{
    assert(radius > 0 && std::isfinite(x) && std::isfinite(y));
    std::ptrdiff_t const parts = find_edges(x, box.x0, box.width, radius, scratch.columns);
    find_edges(y, box.y0, box.height, radius, scratch.rows);
    if (scratch.area.size() < static_cast<std::size_t>(parts)) scratch.area.resize(static_cast<std::size_t>(parts));
    auto const centre_column = static_cast<std::ptrdiff_t>(std::floor(x)) - box.x0,
               centre_row = static_cast<std::ptrdiff_t>(std::floor(y)) - box.y0;
    double* const area = scratch.area.data();
    double* to = listed.data();
    for (std::ptrdiff_t j = 0; j < box.height; ++j) {
        Band const band(scratch.rows, j), before(scratch.rows, box.height);
        bool const both = j == centre_row;
        RowCover& row = rows[static_cast<std::size_t>(j)];
        row = find_cover(x, box, band.wide, both ? std::min(band.narrow, before.narrow) : band.narrow, radius);
        auto const add = [&](std::ptrdiff_t begin, std::ptrdiff_t count) {
            auto const one = [&](Band const& b) {
                return radius < series_radius ? add_band<false>(b, radius, scratch, begin, count)
                                              : add_band<true>(b, radius, scratch, begin, count);
            };
            one(band);
            if (both) one(before);
        };
        std::fill_n(area, parts, 0.0);
        std::ptrdiff_t const inner = row.begin + row.left, outer = row.begin + row.last();
        if (row.begin + whole_chunks(row.left) <= outer && inner <= centre_column && centre_column < outer) {
            add(row.begin, row.left);
            add(outer, row.right);
        } else {
            add(0, box.width + 1);
            area[centre_column] += area[box.width];
        }
        row.listed = to;
        copy_chunks(area + row.begin, row.left, to);
        copy_chunks(area + outer, row.right, to + row.left);
        to += row.left + row.right;
        assert(to <= listed.data() + listed.size() - RowCover::slack);
    }
}

}  // namespace lbm
