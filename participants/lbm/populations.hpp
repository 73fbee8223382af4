#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>

#include "coupler/base/team.hpp"
#include "participants/lbm/lattice.hpp"

namespace lbm {

//! For each direction the slot of cell x = 0 of one row.
template <int D>
using Slots = std::array<double*, Lattice<D>::directions>;

//! Cells along x, y, z; one along z in the plane.
using Extent = std::array<std::ptrdiff_t, 3>;

//! The populations f_q - w_q [-], one array for each direction, shape [q][z][y][x], x fastest, with one ghost cell all
//! round (in the plane none along z).
//!
//! Streaming moves no data. A cell's post-collision value stays in its slot and the array's origin moves by -c_q, so
//! that the neighbour at +c_q finds it where it looks for its own:
//!     slot of (x, y, z) at step t  =  start_q + (z plane + y stride + x) - t (cz_q plane + cy_q stride + cx_q)
//! Each array has slack at the end toward which the origin moves; when it is used up the array is moved back
//! (about 1 % of the time in the plane, 3 % in space). Every cell reads and writes its own slots only: no order, no
//! races, no second array.
template <int D>
class Populations
{
 public:
    Populations(Extent cells, sluice::Team& team);  //!< all slots 0: fluid of density 1 at rest

    std::ptrdiff_t nx() const noexcept { return cells_[0]; }
    std::ptrdiff_t ny() const noexcept { return cells_[1]; }
    std::ptrdiff_t nz() const noexcept { return cells_[2]; }
    //! Rows along x, numbered from the lowest y and z on, y fastest.
    std::ptrdiff_t rows() const noexcept { return cells_[1] * cells_[2]; }
    std::ptrdiff_t cells() const noexcept { return cells_[0] * rows(); }
    std::ptrdiff_t stride() const noexcept { return stride_; }  //!< from one row to the next along y
    std::ptrdiff_t y_of(std::ptrdiff_t row) const noexcept { return D == 2 ? row : row % cells_[1]; }
    std::ptrdiff_t z_of(std::ptrdiff_t row) const noexcept { return D == 2 ? 0 : row / cells_[1]; }

    //! Slot of direction q of cell (0, y, z); valid for -1 <= x <= nx and so on until the next stream().
    double* at(std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) noexcept
    {
        return origin_[q] + y * stride_ + z * plane_;
    }
    double const* at(std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        return origin_[q] + y * stride_ + z * plane_;
    }
    double* row(std::size_t q, std::ptrdiff_t r) noexcept { return at(q, y_of(r), z_of(r)); }
    double const* row(std::size_t q, std::ptrdiff_t r) const noexcept { return at(q, y_of(r), z_of(r)); }
    Slots<D> row(std::ptrdiff_t r) noexcept
    {
        Slots<D> slots;
        for (std::size_t q = 0; q < Lattice<D>::directions; ++q) slots[q] = row(q, r);
        return slots;
    }

    void stream(sluice::Team& team);  //!< one step: every population moves by c_q

    std::size_t bytes() const noexcept { return bytes_; }

 private:
    struct Free
    {
        void operator()(double* p) const noexcept { std::free(p); }
    };

    std::ptrdiff_t shift(std::size_t q) const noexcept
    {
        auto const& c = Lattice<D>::c[q];
        return c[0] + c[1] * stride_ + c[2] * plane_;
    }
    std::ptrdiff_t slack(std::size_t q) const noexcept;

    Extent cells_;
    std::ptrdiff_t stride_, plane_, body_;
    std::size_t bytes_ = 0;
    std::unique_ptr<double, Free> memory_;
    Slots<D> start_{};   //!< origin of each array when its slack is whole
    Slots<D> origin_{};  //!< slot of cell (0, 0, 0) now
};

}  // namespace lbm
