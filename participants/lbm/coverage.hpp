#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coupler/base/team.hpp"
#include "participants/lbm/disc_area.hpp"

namespace lbm {

//! A disc in lattice units: cell (0, 0) is the square [0, 1] x [0, 1].
struct Disc
{
    double x, y;    //!< centre
    double radius;  //!< hydrodynamic
    double ux, uy;  //!< velocity (cells a step)
    double spin;    //!< angular velocity (1/step)
};

constexpr std::ptrdiff_t strip_lanes = 4;  //!< cells that loops over a strip take at a time

//! The cells of one row that one body covers. The fractions may be read up to a multiple of strip_lanes; what lies
//! there is 0, unless the strip ends with the row.
struct Strip
{
    std::ptrdiff_t body;   //!< index of the disc; obstacle: the number of discs
    std::ptrdiff_t y;      //!< row of the lattice
    std::ptrdiff_t begin;  //!< first cell
    std::ptrdiff_t count;
    double const* fraction;  //!< area fraction of each cell [-]
    double arm_x, arm_y;     //!< from the body's centre to the centre of the first cell
};

//! Which body covers how much of which cell; discs that did not move keep their strips.
class Coverage
{
 public:
    Coverage(std::ptrdiff_t nx, std::ptrdiff_t ny, bool periodic_x, bool periodic_y);

    //! Solids at rest that are no discs: area fraction of every cell, shape [y][x].
    void set_obstacle(std::vector<double> fraction);
    //! Returns how many discs' fractions it computed anew.
    std::ptrdiff_t update(std::span<Disc const> discs, sluice::Team& team);

    //! Indices into strips() of the strips in row y, by body.
    std::span<std::uint32_t const> row(std::ptrdiff_t y) const noexcept;
    std::span<Strip const> strips() const noexcept { return strips_; }
    //! Begin and end in strips() of body i's strips, from the lowest row up.
    std::array<std::size_t, 2> of_body(std::size_t i) const noexcept { return {first_[i], first_[i] + count_[i]}; }

 private:
    struct Shape
    {
        double x, y, radius;
        bool operator==(Shape const&) const = default;
    };

    void lay_out(std::span<Disc const> discs);
    void cover(std::size_t i, Disc const& disc);
    std::size_t add_strips(std::size_t at, Strip strip);
    void sort_by_row();

    std::ptrdiff_t nx_, ny_;
    bool periodic_x_, periodic_y_;
    std::vector<Shape> shape_;                       //!< of the discs at the last update
    std::vector<std::size_t> box_start_;             //!< in fraction_, for each disc
    std::vector<std::size_t> first_, count_, room_;  //!< of each body's strips
    std::vector<double> fraction_, obstacle_;
    std::vector<Strip> strips_;
    std::vector<std::uint32_t> by_row_, row_start_;
};

}  // namespace lbm
