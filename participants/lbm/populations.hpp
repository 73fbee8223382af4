#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <type_traits>

#include "coupler/base/team.hpp"
#include "participants/lbm/config.hpp"
#include "participants/lbm/lattice.hpp"

namespace lbm {

constexpr std::size_t bytes_of(Precision precision) noexcept
{
    return precision == Precision::float64 ? sizeof(double) : sizeof(float);
}

//! For each direction the slot of cell x = 0 of one row.
template <int D, class Stored>
using Slots = std::array<Stored*, Lattice<D>::directions>;
//! The same for who does not know how populations are stored.
template <int D>
using AnySlots = std::array<void*, Lattice<D>::directions>;

template <int D, class Stored>
Slots<D, Stored> typed(AnySlots<D> const& slots) noexcept
{
    Slots<D, Stored> all;
    for (std::size_t q = 0; q < all.size(); ++q) all[q] = static_cast<Stored*>(slots[q]);
    return all;
}

//! Cells along x, y, z; one along z in the plane.
using Extent = std::array<std::ptrdiff_t, 3>;

template <int D, class Stored>
class Rows;

//! The populations f_q - w_q [-], float or double, one array for each direction, shape [q][z][y][x], x fastest, with
//! one ghost cell all round (in the plane none along z).
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
    Populations(Extent cells, Precision precision, sluice::Team& team);  //!< all slots 0: fluid of density 1 at rest

    std::ptrdiff_t nx() const noexcept { return cells_[0]; }
    std::ptrdiff_t ny() const noexcept { return cells_[1]; }
    std::ptrdiff_t nz() const noexcept { return cells_[2]; }
    //! Rows along x, numbered from the lowest y and z on, y fastest.
    std::ptrdiff_t rows() const noexcept { return cells_[1] * cells_[2]; }
    std::ptrdiff_t cells() const noexcept { return cells_[0] * rows(); }
    std::ptrdiff_t stride() const noexcept { return stride_; }  //!< from one row to the next along y
    std::ptrdiff_t y_of(std::ptrdiff_t row) const noexcept { return D == 2 ? row : row % cells_[1]; }
    std::ptrdiff_t z_of(std::ptrdiff_t row) const noexcept { return D == 2 ? 0 : row / cells_[1]; }

    Precision precision() const noexcept { return precision_; }
    AnySlots<D> row(std::ptrdiff_t r) noexcept
    {
        AnySlots<D> slots;
        for (std::size_t q = 0; q < Lattice<D>::directions; ++q) slots[q] = slot(offset(q, y_of(r), z_of(r)));
        return slots;
    }

    //! Calls with Rows of the type that is stored.
    template <class Call>
    decltype(auto) visit(Call&& call)
    {
        return precision_ == Precision::float64 ? call(Rows<D, double>(*this)) : call(Rows<D, float>(*this));
    }
    template <class Call>
    decltype(auto) visit(Call&& call) const
    {
        return precision_ == Precision::float64 ? call(Rows<D, double const>(*this))
                                                : call(Rows<D, float const>(*this));
    }

    void stream(sluice::Team& team);  //!< one step: every population moves by c_q

    std::size_t bytes() const noexcept { return bytes_; }

 private:
    template <int E, class Stored>
    friend class Rows;

    struct Free
    {
        void operator()(std::byte* p) const noexcept { std::free(p); }
    };

    //! Of direction q of cell (0, y, z), from the memory's begin [populations].
    std::ptrdiff_t offset(std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        return origin_[q] + y * stride_ + z * plane_;
    }
    std::byte* slot(std::ptrdiff_t offset) const noexcept
    {
        return memory_.get() + offset * static_cast<std::ptrdiff_t>(bytes_of(precision_));
    }
    std::ptrdiff_t shift(std::size_t q) const noexcept
    {
        auto const& c = Lattice<D>::c[q];
        return c[0] + c[1] * stride_ + c[2] * plane_;
    }
    std::ptrdiff_t slack(std::size_t q) const noexcept;

    Extent cells_;
    Precision precision_;
    std::ptrdiff_t line_;  //!< populations in a cache line
    std::ptrdiff_t stride_, plane_, body_;
    std::size_t bytes_ = 0;
    std::unique_ptr<std::byte, Free> memory_;
    std::array<std::ptrdiff_t, Lattice<D>::directions> start_{};   //!< origin of each array when its slack is whole
    std::array<std::ptrdiff_t, Lattice<D>::directions> origin_{};  //!< slot of cell (0, 0, 0) now
};

//! Populations as the type that they are stored as: float or double, or const of these.
template <int D, class Stored>
class Rows
{
 public:
    static constexpr bool constant = std::is_const_v<Stored>;
    using Of = std::conditional_t<constant, Populations<D> const, Populations<D>>;

    explicit Rows(Of& of) noexcept : of_(&of) { assert(sizeof(Stored) == bytes_of(of.precision())); }

    std::ptrdiff_t nx() const noexcept { return of_->nx(); }
    std::ptrdiff_t ny() const noexcept { return of_->ny(); }
    std::ptrdiff_t nz() const noexcept { return of_->nz(); }
    std::ptrdiff_t rows() const noexcept { return of_->rows(); }
    std::ptrdiff_t stride() const noexcept { return of_->stride(); }
    std::ptrdiff_t y_of(std::ptrdiff_t row) const noexcept { return of_->y_of(row); }
    std::ptrdiff_t z_of(std::ptrdiff_t row) const noexcept { return of_->z_of(row); }

    //! Slot of direction q of cell (0, y, z); valid for -1 <= x <= nx and so on until the next stream().
    Stored* at(std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        return reinterpret_cast<Stored*>(of_->memory_.get()) + of_->offset(q, y, z);
    }
    Stored* row(std::size_t q, std::ptrdiff_t r) const noexcept { return at(q, y_of(r), z_of(r)); }
    Slots<D, Stored> row(std::ptrdiff_t r) const noexcept
    {
        Slots<D, Stored> slots;
        for (std::size_t q = 0; q < slots.size(); ++q) slots[q] = row(q, r);
        return slots;
    }

 private:
    Of* of_;
};

}  // namespace lbm
