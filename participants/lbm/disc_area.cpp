#include "participants/lbm/disc_area.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace lbm {
namespace {

constexpr double series_radius = 4;           //!< from here on a series gives the segments to rounding
constexpr std::ptrdiff_t long_interior = 16;  //!< cells; wholly covered cells beyond that are filled, not computed
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

//! A piece of a row of cells on one side of the centre: |y| from low to high, the arc at half widths wide and narrow.
struct Band
{
    double low, high, wide, narrow;
    Band(double from, double to, double radius)
        : low(from), high(to), wide(half_chord(radius, from)), narrow(half_chord(radius, to))
    {}
    static double half_chord(double radius, double at)
    {
        return std::sqrt(std::max(0.0, (radius - at) * (radius + at)));
    }
};

//! Adds the area of the disc in the band, for the columns [begin, end).
template <bool Series>
void add_band(Band const& band, double radius, RasterScratch& s, std::ptrdiff_t begin, std::ptrdiff_t end)
{
    double const *const inner = s.inner.data(), *const outer = s.outer.data(), *const top = s.top.data(),
                        *const bottom = s.bottom.data();
    double* const area = s.area.data();
    double const radius_square = radius * radius, inverse_square = 0.25 / radius_square;
    double const low = band.low, high = band.high, wide = band.wide, narrow = band.narrow;
#pragma omp simd
    for (std::ptrdiff_t k = begin; k < end; ++k) {
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
    std::ptrdiff_t const stride = static_cast<std::ptrdiff_t>(fraction.size()) / box.height;
    auto const centre_column = static_cast<std::ptrdiff_t>(std::floor(x)) - box.x0;
    std::ptrdiff_t const parts = (box.width + 1 + lanes - 1) / lanes * lanes;
    for (auto* v : {&scratch.inner, &scratch.outer, &scratch.top, &scratch.bottom, &scratch.area})
        if (v->size() < static_cast<std::size_t>(parts)) v->resize(static_cast<std::size_t>(parts));
    auto const set_column = [&](std::ptrdiff_t k, double inner, double outer) {
        auto const at = static_cast<std::size_t>(k);
        scratch.inner[at] = inner;
        scratch.outer[at] = outer;
        scratch.top[at] = Band::half_chord(radius, inner);
        scratch.bottom[at] = Band::half_chord(radius, outer);
    };
    for (std::ptrdiff_t k = 0; k < box.width; ++k) {
        double const at = static_cast<double>(box.x0 + k) - x;
        set_column(k, k > centre_column ? at : std::max(0.0, -(at + 1)), std::abs(k < centre_column ? at : at + 1));
    }
    set_column(box.width, 0.0, x - static_cast<double>(box.x0 + centre_column));  // the centre cell's left part
    for (std::ptrdiff_t k = box.width + 1; k < parts; ++k) set_column(k, radius, radius);

    double* const area = scratch.area.data();
    double const slack = 1e-9 * (1 + radius);  // far more than rounding: no covered cell lies beyond
    auto const add = [&](Band const& band) {
        auto const run = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            return radius < series_radius ? add_band<false>(band, radius, scratch, begin, end)
                                          : add_band<true>(band, radius, scratch, begin, end);
        };
        if (2 * band.narrow < static_cast<double>(long_interior)) return run(0, parts);
        auto const first = static_cast<std::ptrdiff_t>(std::ceil(x - band.narrow + slack)) - box.x0;
        auto const last = static_cast<std::ptrdiff_t>(std::floor(x + band.narrow - slack)) - box.x0;
        run(0, first);
        for (std::ptrdiff_t k = first; k < last; ++k) area[k] += band.high - band.low;
        area[centre_column] -= (band.high - band.low) * scratch.outer[static_cast<std::size_t>(box.width)];
        run(last, parts);
    };
    for (std::ptrdiff_t j = 0; j < box.height; ++j) {
        double const from = static_cast<double>(box.y0 + j) - y, to = from + 1;
        double const nearest = from > 0 ? from : std::max(0.0, -to);
        std::fill_n(area, parts, 0.0);
        add({nearest, std::abs(from > 0 ? to : to > 0 ? to : from), radius});
        if (from < 0 && to > 0) add({0.0, -from, radius});
        area[centre_column] += area[box.width];
        double* const line = fraction.data() + j * stride;
        std::copy_n(area, box.width, line);
        std::fill_n(line + box.width, stride - box.width, 0.0);
        double const half = Band::half_chord(radius, nearest) + slack;
        std::ptrdiff_t* const extent = columns.data() + 2 * j;
        extent[0] = std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(x - half)) - box.x0, 0);
        extent[1] = std::min(static_cast<std::ptrdiff_t>(std::ceil(x + half)) - box.x0, box.width);
    }
}

}  // namespace lbm
