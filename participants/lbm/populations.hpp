#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <type_traits>
#include <vector>

#include "coupler/base/team.hpp"
#include "participants/lbm/config.hpp"
#include "participants/lbm/lattice.hpp"
#include "participants/lbm/layout.hpp"

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

template <int D, class Stored>
class Rows;

//! The populations f_q - w_q [-], float or double, of all cells of a layout. Places are those in a box.
//!
//! Streaming moves no data. A cell's post-collision value stays in its slot and the array's origin moves by -c_q, so
//! that the neighbour at +c_q finds it where it looks for its own. Each direction of a box is an array of its own,
//! shape [z][y][x], x fastest, with a ghost cell on the side toward which it moves. Rows and planes are rings: what
//! left at one end is where the next one comes in. Along x rows are straight, with slack at the array's end; when it is
//! used up they are moved back (1/2 % of the time). Every cell reads and writes its own slots only: no order, no races,
//! no second array.
//!
//! What leaves a row at one of its ends lies in a ghost cell, far from what leaves the next row. It is noted once more,
//! row by row side by side: walls and joined sides across x take it from there. So ghost cells between rows are lost
//! when rows collide: those that do not fill registers do so as one, with what lies between them.
template <int D>
class Populations
{
 public:
    //! All slots 0: fluid of density 1 at rest. Keeps the layout's address.
    Populations(Layout const& layout, Precision precision, sluice::Team& team);

    Layout const& layout() const noexcept { return *layout_; }
    std::ptrdiff_t rows() const noexcept { return layout_->rows(); }
    std::ptrdiff_t cells() const noexcept { return layout_->stored(); }

    Precision precision() const noexcept { return precision_; }
    AnySlots<D> row(std::ptrdiff_t r) const noexcept
    {
        auto const [box, y, z] = place(r);
        auto const offset = offsets(box, y, z);
        AnySlots<D> slots;
        for (std::size_t q = 0; q < directions; ++q)
            slots[q] = memory_.get() + offset[q] * static_cast<std::ptrdiff_t>(bytes_of(precision_));
        return slots;
    }

    //! How many rows from r on, `most` at most, lie a stride apart in every direction's array.
    std::ptrdiff_t rows_in_line(std::ptrdiff_t r, std::ptrdiff_t most) const noexcept
    {
        auto const [box, y, z] = place(r);
        Arrays const& a = arrays_[box];
        std::ptrdiff_t count = std::min(most, layout_->boxes()[box].size[1] - y);
        for (std::size_t q = 0; q < directions; ++q)
            count = std::min(count, a.rows[q] - in_ring(y + a.y0[q], a.rows[q]));
        return count;
    }
    std::ptrdiff_t stride(std::ptrdiff_t r) const noexcept { return arrays_[place(r).box].stride; }  //!< that one

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

    std::size_t bytes() const noexcept
    {
        std::size_t all = bytes_;
        for (auto const& ends : ends_) all += ends.size();
        return all;
    }

 private:
    template <int E, class Stored>
    friend class Rows;
    static constexpr std::size_t directions = Lattice<D>::directions;

    struct Free
    {
        void operator()(std::byte* p) const noexcept { std::free(p); }
    };

    //! The arrays of one box, for each direction.
    struct Arrays
    {
        using Of = std::array<std::ptrdiff_t, directions>;
        Of begin;               //!< slot of x = 0 in the first row of the ring, when all slack is left
        std::ptrdiff_t stride;  //!< from row to row, of all directions
        Of plane;               //!< from plane to plane
        Of rows, planes;        //!< in the rings
        Of y0{}, z0{};          //!< places in the rings of y = 0, z = 0
    };
    struct Place
    {
        std::size_t box;
        std::ptrdiff_t y, z;
    };

    Place place(std::ptrdiff_t r) const noexcept
    {
        Row const& row = layout_->row(r);
        auto const box = static_cast<std::size_t>(row.box);
        Extent const& first = layout_->boxes()[box].first;
        return {box, row.y - first[1], row.z - first[2]};
    }
    static std::ptrdiff_t in_ring(std::ptrdiff_t i, std::ptrdiff_t n) noexcept
    {
        return i < 0 ? i + n : i >= n ? i - n : i;
    }
    static std::ptrdiff_t offset(Arrays const& a, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) noexcept
    {
        return a.begin[q] + in_ring(z + a.z0[q], a.planes[q]) * a.plane[q] + in_ring(y + a.y0[q], a.rows[q]) * a.stride;
    }
    //! Of direction q of cell (0, y, z) of a box, from the memory's begin [populations].
    std::ptrdiff_t offset(std::size_t box, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        return offset(arrays_[box], q, y, z) - Lattice<D>::c[q][0] * drift_;
    }
    typename Arrays::Of offsets(std::size_t box, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        Arrays const& a = arrays_[box];
        typename Arrays::Of all;
        for (std::size_t q = 0; q < directions; ++q) all[q] = offset(a, q, y, z);
        for (std::size_t q = 0; q < directions; ++q) all[q] -= Lattice<D>::c[q][0] * drift_;
        return all;
    }
    std::ptrdiff_t add_box(Extent const& size, std::ptrdiff_t begin);
    void move_back(Arrays const& arrays, std::size_t q);

    Layout const* layout_;
    Precision precision_;
    std::ptrdiff_t line_;  //!< populations in a cache line
    std::size_t bytes_ = 0;
    std::unique_ptr<std::byte, Free> memory_;
    std::vector<Arrays> arrays_;                  //!< for each box
    std::array<std::vector<std::byte>, 2> ends_;  //!< shape [row][direction that moves along x]: of the last step, and
                                                  //!< of this one
    std::ptrdiff_t drift_ = 0;                    //!< steps since rows were moved back
};

//! Populations as the type that they are stored as: float or double, or const of these.
template <int D, class Stored>
class Rows
{
 public:
    static constexpr bool constant = std::is_const_v<Stored>;
    using Of = std::conditional_t<constant, Populations<D> const, Populations<D>>;

    explicit Rows(Of& of) noexcept : of_(&of) { assert(sizeof(Stored) == bytes_of(of.precision())); }

    Layout const& layout() const noexcept { return of_->layout(); }
    std::ptrdiff_t rows() const noexcept { return of_->rows(); }
    std::ptrdiff_t nx(std::ptrdiff_t r) const noexcept { return layout().row(r).cells; }

    //! Slot of direction q of cell (0, y, z) of a box; valid for its cells, and for ghost cells beyond those sides that
    //! the direction moves toward, until the next stream().
    Stored* at(std::size_t box, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        return reinterpret_cast<Stored*>(of_->memory_.get()) + of_->offset(box, q, y, z);
    }
    //! The same of a row's first cell.
    Stored* row(std::size_t q, std::ptrdiff_t r) const noexcept
    {
        auto const [box, y, z] = of_->place(r);
        return at(box, q, y, z);
    }
    std::ptrdiff_t stride(std::ptrdiff_t r) const noexcept { return of_->stride(r); }
    Slots<D, Stored> row(std::ptrdiff_t r) const noexcept { return typed<D, Stored>(of_->row(r)); }

    //! What left row r in the last step at one of its ends, of a direction that moves along x; of the next row it is
    //! along_x<D> further.
    Stored const* end(std::size_t q, std::ptrdiff_t r) const noexcept
    {
        return reinterpret_cast<Stored const*>(of_->ends_[0].data()) + r * along_x<D> + place_along_x<D>[q];
    }
    //! Where what leaves row r at its ends is noted for the next step, shape [direction that moves along x], in the
    //! order of place_along_x.
    Stored* leaving(std::ptrdiff_t r) const noexcept
    {
        return reinterpret_cast<Stored*>(of_->ends_[1].data()) + r * along_x<D>;
    }
    //! Rows of one direction in a plane of a box, from one on upward.
    class Column
    {
     public:
        Column(Stored* first, std::ptrdiff_t stride, std::ptrdiff_t place, std::ptrdiff_t rows) noexcept
            : first_(first), stride_(stride), left_(rows - place), rows_(rows)
        {}
        Stored* first() const noexcept { return first_; }  //!< slot of the cell x = 0
        void up() noexcept
        {
            first_ += stride_;
            if (--left_ > 0) return;
            first_ -= rows_ * stride_;
            left_ = rows_;
        }

     private:
        Stored* first_;
        std::ptrdiff_t stride_, left_, rows_;  //!< left: to the ring's end
    };
    Column column(std::size_t box, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t z) const noexcept
    {
        auto const& a = of_->arrays_[box];
        return {at(box, q, y, z), a.stride, of_->in_ring(y + a.y0[q], a.rows[q]), a.rows[q]};
    }

    //! Notes what will leave rows that have collided.
    void note_ends(std::ptrdiff_t begin, std::ptrdiff_t end) const noexcept
    {
        for (std::ptrdiff_t next = begin; begin < end; begin = next) {
            auto const [box, y, z] = of_->place(begin);
            Extent const& size = layout().boxes()[box].size;
            next = std::min(end, begin + size[1] - y);
            for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
                if (Lattice<D>::c[q][0] == 0) continue;
                std::ptrdiff_t const x = Lattice<D>::c[q][0] > 0 ? size[0] - 1 : 0;
                Column from = column(box, q, y, z);
                for (std::ptrdiff_t r = begin; r < next; ++r, from.up())
                    leaving(r)[place_along_x<D>[q]] = from.first()[x];
            }
        }
    }

 private:
    Of* of_;
};

}  // namespace lbm
