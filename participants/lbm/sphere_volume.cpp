#include "participants/lbm/sphere_volume.hpp"

#include <algorithm>
#include <cmath>

namespace lbm {
namespace {

//! Of a cell whose centre is (x, y, z) away from the sphere's [-].
inline double covered(double x, double y, double z, double radius_square) noexcept
{
    constexpr std::array<double, 3> point = {-0.38729833462074170, 0.0, 0.38729833462074170},
                                    share = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double const low = std::min(x, y), high = std::max(x, y), height = std::max(high, z), b = std::min(low, z),
                 c = std::max(low, std::min(high, z));
    double sum = 0;
#pragma GCC unroll 3
    for (std::size_t i = 0; i < 3; ++i) {
        double const left = radius_square - (b + point[i]) * (b + point[i]);
#pragma GCC unroll 3
        for (std::size_t j = 0; j < 3; ++j) {
            double const half = std::sqrt(std::max(0.0, left - (c + point[j]) * (c + point[j])));
            sum += share[i] * share[j] * std::max(0.0, std::min(half, height + 0.5) - std::max(-half, height - 0.5));
        }
    }
    return sum;
}

//! Cells that a sphere's surface cuts, side by side for as many at a time as the machine computes with: in a row there
//! are but a few.
class CutCells
{
 public:
    CutCells(double radius, std::span<double> fraction) : radius_square_(radius * radius), fraction_(fraction) {}
    //! A cell whose centre is (x, y, z) away from the sphere's, y and z at least 0, and its place in `fraction`.
    void add(std::ptrdiff_t at, double x, double y, double z) noexcept
    {
        if (count_ == most) find();
        at_[count_] = static_cast<std::size_t>(at);
        x_[count_] = x, y_[count_] = y, z_[count_] = z;
        ++count_;
    }
    //! The fractions of all that were added.
    void find() noexcept
    {
        constexpr std::size_t lanes = 8;
        std::size_t const whole = (count_ + lanes - 1) / lanes * lanes;
#pragma omp simd
        for (std::size_t k = 0; k < whole; ++k) share_[k] = covered(std::abs(x_[k]), y_[k], z_[k], radius_square_);
        for (std::size_t k = 0; k < count_; ++k) fraction_[at_[k]] = share_[k];
        count_ = 0;
    }

 private:
    static constexpr std::size_t most = 256;
    double radius_square_;
    std::span<double> fraction_;
    std::size_t count_ = 0;
    std::array<std::size_t, most> at_;
    std::array<double, most> x_{}, y_{}, z_{}, share_;
};

//! Half the chord of the sphere at a distance from its centre.
double half_chord(double radius, double y, double z) noexcept
{
    return std::sqrt(std::max(0.0, radius * radius - y * y - z * z));
}

}  // namespace

SphereBox sphere_box(std::array<double, 3> const& centre, double radius) noexcept
{
    SphereBox box;
    for (std::size_t k = 0; k < 3; ++k) {
        box.first[k] = static_cast<std::ptrdiff_t>(std::floor(centre[k] - radius));
        box.size[k] = static_cast<std::ptrdiff_t>(std::floor(centre[k] + radius)) + 1 - box.first[k];
    }
    return box;
}

void rasterise(std::array<double, 3> const& centre, double radius, SphereBox const& box, std::span<double> fraction,
               std::span<std::ptrdiff_t> columns)
{
    CutCells cells(radius, fraction);
    std::ptrdiff_t const width = box.size[0], rows = box.size[1] * box.size[2],
                         length = static_cast<std::ptrdiff_t>(fraction.size()) / rows;
    double const first = static_cast<double>(box.first[0]) + 0.5 - centre[0];
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
        double const y = std::abs(static_cast<double>(box.first[1] + row % box.size[1]) + 0.5 - centre[1]);
        double const z = std::abs(static_cast<double>(box.first[2] + row / box.size[1]) + 0.5 - centre[2]);
        double* const line = fraction.data() + row * length;
        std::ptrdiff_t* const extent = columns.data() + 2 * row;
        std::fill_n(line, length, 0.0);
        double const wide = half_chord(radius, std::max(0.0, y - 0.5), std::max(0.0, z - 0.5)),
                     narrow = half_chord(radius, y + 0.5, z + 0.5);  // cells within are covered wholly
        extent[0] = extent[1] = 0;
        if (wide == 0) continue;
        extent[0] = std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(std::floor(-wide - first + 0.5)));
        extent[1] = std::min(width, static_cast<std::ptrdiff_t>(std::ceil(wide - first + 0.5)));
        auto const inner =
            std::clamp(static_cast<std::ptrdiff_t>(std::ceil(-narrow - first + 0.5)), extent[0], extent[1]);
        auto const outer = std::clamp(static_cast<std::ptrdiff_t>(std::floor(narrow - first + 0.5)), inner, extent[1]);
        auto const cut = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::ptrdiff_t k = begin; k < end; ++k)
                cells.add(row * length + k, first + static_cast<double>(k), y, z);
        };
        cut(extent[0], inner);
        std::fill(line + inner, line + outer, 1.0);
        cut(outer, extent[1]);
    }
    cells.find();
}

}  // namespace lbm
