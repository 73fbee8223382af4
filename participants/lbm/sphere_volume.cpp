#include "participants/lbm/sphere_volume.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

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
    //! `listed`: where the fractions go, one after another.
    CutCells(double radius, std::span<double> listed) : radius_square_(radius * radius), listed_(listed) {}
    //! A cell whose centre is (x, y, z) away from the sphere's, y and z at least 0.
    void add(double x, double y, double z) noexcept
    {
        if (count_ == most) find();
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
        assert(count_ <= listed_.size());
        std::copy_n(share_.data(), count_, listed_.data());
        listed_ = listed_.subspan(count_);
        count_ = 0;
    }

 private:
    static constexpr std::size_t most = 256;
    double radius_square_;
    std::span<double> listed_;
    std::size_t count_ = 0;
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

std::size_t most_listed_of_sphere(double radius) noexcept
{
    // rows that the sphere touches are fewer than cells that its shadow touches; each lists less than wide - narrow + 2
    // on both sides. Along diagonals of a quadrant's rows wide - narrow adds up to what the first row has, less than
    // 2 (pi radius^2/4 + 2 radius) in all of it; the centre's row reaches beyond where those beside it begin: once more
    constexpr double pi = std::numbers::pi, diagonal = std::numbers::sqrt2;
    double const shadow = pi * (radius + diagonal) * (radius + diagonal),
                 quadrant = 2 * (0.25 * pi * radius * radius + 2 * radius);
    return static_cast<std::size_t>(4 * shadow + 2 * 8 * quadrant) + 1;
}

void rasterise(std::array<double, 3> const& centre, double radius, SphereBox const& box, std::span<double> listed,
               std::span<RowCover> rows)
{
    CutCells cells(radius, listed);
    double const* at = listed.data();
    double const first = static_cast<double>(box.first[0]) + 0.5 - centre[0];
    auto const width = static_cast<std::int32_t>(box.size[0]);
    auto const whole = [](double x) { return static_cast<std::int32_t>(x); };
    for (std::ptrdiff_t k = 0; k < box.size[1] * box.size[2]; ++k) {
        double const y = std::abs(static_cast<double>(box.first[1] + k % box.size[1]) + 0.5 - centre[1]);
        double const z = std::abs(static_cast<double>(box.first[2] + k / box.size[1]) + 0.5 - centre[2]);
        double const wide = half_chord(radius, std::max(0.0, y - 0.5), std::max(0.0, z - 0.5)),
                     narrow = half_chord(radius, y + 0.5, z + 0.5);  // cells within are covered wholly
        RowCover& row = rows[static_cast<std::size_t>(k)];
        row = {};
        if (wide == 0) continue;
        std::int32_t const begin = std::max(0, whole(std::floor(-wide - first + 0.5))),
                           end = std::min(width, whole(std::ceil(wide - first + 0.5))),
                           inner = std::clamp(whole(std::ceil(-narrow - first + 0.5)), begin, end),
                           outer = std::clamp(whole(std::floor(narrow - first + 0.5)), inner, end);
        auto const cut = [&](std::int32_t from, std::int32_t to) {
            for (std::int32_t i = from; i < to; ++i) cells.add(first + i, y, z);
        };
        cut(begin, inner);
        cut(outer, end);
        row = {begin, end - begin, inner - begin, end - outer, at};
        at += row.left + row.right;
    }
    cells.find();
}

}  // namespace lbm
