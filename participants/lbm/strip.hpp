#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <span>

#include "participants/lbm/lattice.hpp"

namespace lbm {

//! A disc or a sphere in lattice units: cell (0, 0) is the square [0, 1] x [0, 1].
template <int D>
struct Body
{
    std::array<double, D> centre;
    double radius;                        //!< hydrodynamic
    std::array<double, D> velocity;       //!< cells a step
    std::array<double, spins<D>> spin{};  //!< angular velocity (1/step)

    //! At the end of an arm from its centre.
    std::array<double, D> velocity_at(std::array<double, D> const& arm) const noexcept
    {
        std::array<double, D> u = velocity;
        if constexpr (D == 2) {
            u[0] -= spin[0] * arm[1];
            u[1] += spin[0] * arm[0];
        } else {
            auto const turned = cross(spin, arm);
            for (std::size_t k = 0; k < 3; ++k) u[k] += turned[k];
        }
        return u;
    }
};

constexpr std::ptrdiff_t strip_lanes = 8;  //!< cells that loops over a strip take at a time

//! Copies numbers in whole chunks; what lies up to a chunk beyond the last one is read and written, too.
template <class To>
inline void copy_chunks(double const* from, std::ptrdiff_t count, To* to) noexcept
{
    constexpr std::ptrdiff_t chunk = 4;
    for (std::ptrdiff_t k = 0; k < count; k += chunk)
        for (std::ptrdiff_t i = k; i < k + chunk; ++i) to[i] = static_cast<To>(from[i]);
}

//! Cells of a row of which a body covers something. Only the fractions of cells that may be covered in part are listed:
//! those of the first cells, and right after these those of the last ones. All cells between are covered wholly.
struct RowCover
{
    static constexpr std::ptrdiff_t slack = 4;  //!< numbers that may be read beyond a list

    std::int32_t begin = 0;     //!< first cell
    std::int32_t count = 0;     //!< cells
    std::int32_t left = 0;      //!< first cells that are listed
    std::int32_t right = 0;     //!< last cells that are listed
    double const* listed = {};  //!< solid fraction of each [-]

    std::ptrdiff_t last() const noexcept { return count - right; }  //!< the first of the last cells
    bool covers(std::ptrdiff_t cell) const noexcept { return cell >= begin && cell < begin + count; }
    //! Of cell k of these, [0, count).
    double fraction(std::ptrdiff_t k) const noexcept
    {
        return k < left ? listed[k] : k < last() ? 1.0 : listed[left + k - last()];
    }
    //! The cells [first, end) of these.
    RowCover part(std::ptrdiff_t first, std::ptrdiff_t end) const noexcept
    {
        RowCover p;
        std::ptrdiff_t const right_from = std::max(first, last());
        p.begin = begin + static_cast<std::int32_t>(first);
        p.count = static_cast<std::int32_t>(end - first);
        p.left = static_cast<std::int32_t>(std::max<std::ptrdiff_t>(std::min<std::ptrdiff_t>(left, end) - first, 0));
        p.right = static_cast<std::int32_t>(std::max<std::ptrdiff_t>(end - right_from, 0));
        p.listed = listed + (first < left ? first : left + right_from - last());
        return p;
    }
    //! Cells rounded up for loops that take strip_lanes at a time.
    int whole_lanes() const noexcept
    {
        auto const whole = static_cast<int>((count + strip_lanes - 1) / strip_lanes * strip_lanes);
        if (whole % strip_lanes != 0 || whole <= 0) __builtin_unreachable();  // spares the loops a remainder
        return whole;
    }
    //! Fractions of whole_lanes() cells, 0 beyond the last one; up to strip_lanes more are written.
    template <class Number>
    void write(Number* to) const noexcept
    {
        copy_chunks(listed, left, to);
        for (std::ptrdiff_t k = left; k < last(); k += strip_lanes) std::fill_n(to + k, strip_lanes, Number(1));
        copy_chunks(listed + left, right, to + last());
        std::fill_n(to + count, strip_lanes, Number(0));
    }
};

//! The cells of one row of a layout that one body covers.
template <int D>
struct Strip : RowCover
{
    std::int32_t body;          //!< index of the body; after the bodies come the patches
    std::uint32_t row;          //!< of the layout
    std::array<double, D> arm;  //!< from the body's centre to the centre of the first cell
    double drag;                //!< K of its surface, solid_weight.hpp

    //! The cells [first, end) of these.
    Strip part(std::ptrdiff_t first, std::ptrdiff_t end) const noexcept
    {
        Strip p{RowCover::part(first, end), body, row, arm, drag};
        p.arm[0] += static_cast<double>(first);
        return p;
    }
};

//! Velocity of a body at the centres of a strip's cells: from the first on it grows by `slope` with each.
template <int D>
struct StripVelocity
{
    std::array<double, D> first{}, slope{};
    StripVelocity() = default;  //!< at rest
    StripVelocity(Strip<D> const& s, std::span<Body<D> const> bodies)
    {
        if (s.body >= static_cast<std::ptrdiff_t>(bodies.size())) return;  // patches rest
        Body<D> const& b = bodies[static_cast<std::size_t>(s.body)];
        first = b.velocity_at(s.arm);
        if constexpr (D == 2) {
            slope[1] = b.spin[0];
        } else {
            slope[1] = b.spin[2];
            slope[2] = -b.spin[1];
        }
    }
    template <class Number>
    Number at(std::size_t axis, int cell) const
    {
        return static_cast<Number>(first[axis]) + static_cast<Number>(cell) * static_cast<Number>(slope[axis]);
    }
};

}  // namespace lbm
