#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lbm {

//! Cells along x, y, z; one along z in the plane.
using Extent = std::array<std::ptrdiff_t, 3>;

//! Place of a cell along a periodic axis of n cells.
constexpr std::ptrdiff_t wrap(std::ptrdiff_t i, std::ptrdiff_t n) noexcept
{
    return (i % n + n) % n;
}

//! Cells side by side: the lowest one, and how many along x, y, z.
struct Box
{
    Extent first{}, size{};

    std::ptrdiff_t cells() const noexcept { return size[0] * size[1] * size[2]; }
    bool operator==(Box const&) const = default;
};

//! Cells of one box that lie side by side along x.
struct Row
{
    std::int32_t box;
    std::int32_t first, cells;  //!< the lowest x, and how many
    std::int32_t y, z;
};

//! Which cells of a lattice are stored: those of boxes that do not overlap. A lattice without large solids is one box.
//! Their rows are numbered box after box, from the lowest y and z on, y fastest.
class Layout
{
 public:
    explicit Layout(Extent cells) : Layout(cells, {{{0, 0, 0}, cells}}) {}  //!< all of them
    Layout(Extent cells, std::vector<Box> boxes);

    Extent const& cells() const noexcept { return cells_; }          //!< of the lattice
    std::ptrdiff_t stored() const noexcept { return stored_; }       //!< cells
    std::ptrdiff_t most_in_row() const noexcept { return widest_; }  //!< cells of the longest row
    bool whole() const noexcept { return stored_ == cells_[0] * cells_[1] * cells_[2]; }
    std::vector<Box> const& boxes() const noexcept { return boxes_; }
    std::ptrdiff_t rows() const noexcept { return static_cast<std::ptrdiff_t>(rows_.size()); }
    Row const& row(std::ptrdiff_t r) const noexcept { return rows_[static_cast<std::size_t>(r)]; }
    std::ptrdiff_t first_row(std::size_t box) const noexcept { return first_rows_[box]; }
    //! Rows that lie in one row of the lattice, by x.
    std::span<std::uint32_t const> across(std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        auto const at = static_cast<std::size_t>(z * cells_[1] + y);
        return {by_place_.data() + place_start_[at], by_place_.data() + place_start_[at + 1]};
    }
    std::size_t most_across() const noexcept { return most_across_; }
    //! The box that holds a cell of the lattice; -1: it is not stored.
    std::int32_t box_of(Extent const& cell) const noexcept;

 private:
    Extent cells_;
    std::vector<Box> boxes_;
    std::vector<Row> rows_;
    std::vector<std::ptrdiff_t> first_rows_;             //!< of each box
    std::vector<std::uint32_t> by_place_, place_start_;  //!< rows by [z][y], then by x
    std::ptrdiff_t stored_ = 0, widest_ = 0;
    std::size_t most_across_ = 0;
};

}  // namespace lbm
