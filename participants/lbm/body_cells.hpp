#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/lbm/coverage.hpp"
#include "participants/lbm/domain.hpp"

namespace lbm {

//! Cells whose centre is within a body, each the first body's that has it: of the layers that this process has, and of
//! one more on each side, which are its neighbours'. Lattice units.
template <int D>
class BodyCells
{
 public:
    static constexpr std::int32_t nobody = -1, vacated = -2;

    //! One of them, or what was one in the step before.
    struct Cell
    {
        Extent at;
        std::ptrdiff_t layer;       //!< across the last axis; beyond a periodic side it goes on as the body does
        std::array<double, D> arm;  //!< of its centre, from the body's
    };
    //! Side by side along x.
    struct Run
    {
        Cell first;
        std::ptrdiff_t count;
    };
    struct Changed
    {
        std::int32_t body;  //!< of those of the step in which it is the body's
        Cell cell;
    };

    BodyCells(Domain<D> const& domain, std::array<bool, 3> periodic);

    //! Where the bodies are. Cells that they have left are `vacated` until settle().
    void move(std::span<Body<D> const> bodies);
    void settle();
    //! The same, whatever was before.
    void restart(std::span<Body<D> const> bodies);

    //! A body's, from the lowest layer up.
    std::span<Run const> runs(std::size_t body) const noexcept
    {
        return {runs_.data() + first_[body], runs_.data() + first_[body + 1]};
    }
    std::vector<Changed> const& entered() const noexcept { return entered_; }  //!< of this process; were fluid before
    std::vector<Changed> const& left() const noexcept { return left_; }        //!< vacated, by the bodies before

    //! To the cell at +c_q; false: outside of the domain.
    bool step(Extent& at, std::size_t q) const noexcept
    {
        for (std::size_t k = 0; k < D; ++k) {
            at[k] += Lattice<D>::c[q][k];
            if (!bring_in(at, k)) return false;
        }
        return true;
    }
    //! A body, nobody or vacated, of a cell that is_known().
    std::int32_t owner(Extent const& at) const noexcept { return owner_[index(at)]; }
    bool is_known(Extent const& at) const noexcept { return place(at[D - 1]) < known_; }
    //! Whether a layer of the lattice is this process's.
    bool is_here(std::ptrdiff_t layer) const noexcept { return layer >= begin_ && layer < end_; }
    bool is_here(Extent const& at) const noexcept { return is_here(at[D - 1]); }
    //! The same of a layer as a body counts them (Cell::layer).
    bool has(std::ptrdiff_t layer) const noexcept
    {
        return is_here(periodic_[D - 1] ? wrap(layer, cells_[D - 1]) : layer);
    }
    //! Of a cell of this process, as Rows count; its neighbours' may be ghost cells.
    Extent place_of(Extent at) const noexcept
    {
        at[D - 1] -= begin_;
        return at;
    }
    std::size_t index(Extent const& at) const noexcept  //!< of a cell that is_known()
    {
        std::ptrdiff_t const row = D == 2 ? place(at[1]) : place(at[2]) * cells_[1] + at[1];
        return static_cast<std::size_t>(row * cells_[0] + at[0]);
    }
    //! Whether all cells up to two away from a run are known, and no side and no border is nearer.
    bool is_inner(Run const& run) const noexcept
    {
        Extent const& at = run.first.at;
        bool inner = at[0] >= 2 && at[0] + run.count + 2 <= cells_[0];
        for (std::size_t k = 1; k < D; ++k) inner = inner && at[k] >= 2 && at[k] + 2 < cells_[k];
        return inner && at[D - 1] >= begin_ + 2 && at[D - 1] + 2 < end_;
    }
    //! Owners of the cells at +c_q of one in an inner run are so far from its own.
    std::ptrdiff_t offset(std::size_t q) const noexcept { return offset_[q]; }
    std::int32_t const* owner_of(Extent const& at) const noexcept { return owner_.data() + index(at); }
    //! The layers that links to a body come from: begin and end.
    std::array<std::ptrdiff_t, 2> reach(Body<D> const& body) const noexcept;
    std::size_t count_here() const noexcept { return count_here_; }  //!< cells of this process that are in bodies
    //! Whether a cell of one of this process's rows is in a body.
    bool covers(std::ptrdiff_t row, std::ptrdiff_t x) const noexcept
    {
        return owner_[first_here_ + static_cast<std::size_t>(row * cells_[0] + x)] != nobody;
    }
    std::size_t bytes() const noexcept { return owner_.size() * sizeof(std::int32_t); }

    //! Calls each(cell) for those of a run.
    template <class Each>
    static void each_cell(Run const& run, Each&& each)
    {
        Cell cell = run.first;
        for (std::ptrdiff_t k = 0; k < run.count; ++k, ++cell.at[0], cell.arm[0] += 1) each(cell);
    }

 private:
    //! Of a layer among those that are known, which may go on from the highest one to the lowest.
    std::ptrdiff_t place(std::ptrdiff_t layer) const noexcept
    {
        return layer < lowest_ ? layer - lowest_ + cells_[D - 1] : layer - lowest_;
    }
    //! Into the domain across a periodic side; false: there is no such place.
    bool bring_in(Extent& at, std::size_t axis) const noexcept
    {
        if (at[axis] >= 0 && at[axis] < cells_[axis]) return true;
        if (!periodic_[axis]) return false;
        at[axis] = wrap(at[axis], cells_[axis]);
        return true;
    }
    void list(std::span<Body<D> const> bodies);
    void list_row(std::int32_t body, Body<D> const& b, Extent at);
    void own(std::int32_t body, Cell const& cell);

    Extent cells_;
    std::array<bool, 3> periodic_;
    std::ptrdiff_t begin_, end_;       //!< layers of this process
    std::ptrdiff_t lowest_, known_;    //!< the first layer that is known, and how many
    std::vector<std::int32_t> owner_;  //!< shape [layer that is known]([y])[x]
    std::array<std::ptrdiff_t, Lattice<D>::directions> offset_;
    std::size_t first_here_;  //!< in owner_, of this process's cells
    std::vector<Run> runs_, old_runs_;
    std::vector<std::size_t> first_{0}, old_first_{0};  //!< of each body's runs; one more
    std::vector<Changed> entered_, left_;
    std::size_t count_here_ = 0;
};

}  // namespace lbm
