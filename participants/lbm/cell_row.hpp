#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "participants/lbm/lanes.hpp"
#include "participants/lbm/populations.hpp"
#include "participants/lbm/relaxation.hpp"
#include "participants/lbm/solid_weight.hpp"

//! What the collisions of a row of cells share (collide_plane.hpp, collide_space.hpp).
namespace lbm {

//! What a run of the solver needs; chosen once (kernels.hpp).
struct Features
{
    bool les = false;
    bool force = false;
    bool grains = false;
    bool still = false;    //!< with grains: all of them rest (still_cells.hpp)
    bool split = false;    //!< in space: the second moments have rates of their own, as with les
    bool frame = false;    //!< force grows along the row, and turns with the velocity
    bool central = false;  //!< collides in central moments (collide_central.hpp)
    bool operator==(Features const&) const = default;
};

//! What the collision of one row needs to know of the solids, and what it tells of them; arrays over x, of the type
//! that populations are stored as.
template <class Stored>
struct SolidRow
{
    Stored const* fraction;  //!< sum of the bodies' solid fractions eps [-], may exceed 1 where bodies overlap
    Stored const* weight;    //!< B/sum(eps) [-]: solids push a cell by -2 B (j - rho u_s) a step
    Stored const* open;      //!< the fluid of the cell is 1/open times as viscous [-]
    Stored const* ease;      //!< in space: how B falls with the cell's velocity beside the solid (solid_weight.hpp)
    std::array<Stored const*, 3> momentum;  //!< sum of eps u_s (cells a step); of D entries
    Stored* force_rate;                     //!< out: 2 weight rho
    std::array<Stored*, 3> force;           //!< out: 2 weight j; a body's force is eps (force - force_rate u_s)
};
//! The same for who does not know that type. Refers to one, or to none.
template <template <class> class Row>
class AnyRow
{
 public:
    AnyRow() = default;
    template <class Stored>
    AnyRow(Row<Stored> const& row) noexcept : row_(&row)
    {}
    template <class Stored>
    Row<Stored> typed() const noexcept
    {
        return row_ ? *static_cast<Row<Stored> const*>(row_) : Row<Stored>{};
    }

 private:
    void const* row_ = nullptr;
};
using AnySolidRow = AnyRow<SolidRow>;

//! The same of one cell, or of several at once.
template <int D, class V>
struct SolidCell
{
    V fraction{}, weight{}, open{}, ease{};
    std::array<V, D> momentum{};
    V force_rate{};
    std::array<V, D> force{};

    SolidCell() = default;
    template <class Stored>
    [[gnu::always_inline]] SolidCell(SolidRow<Stored> const& row, std::ptrdiff_t x) noexcept
        : fraction(load<V>(row.fraction + x)), weight(load<V>(row.weight + x)), open(load<V>(row.open + x))
    {
        if constexpr (eased_by_inertia<D>) ease = load<V>(row.ease + x);
        for (std::size_t k = 0; k < D; ++k) momentum[k] = load<V>(row.momentum[k] + x);
    }
    template <class Stored>
    [[gnu::always_inline]] void tell(SolidRow<Stored> const& row, std::ptrdiff_t x) const noexcept
    {
        store(row.force_rate + x, force_rate);
        for (std::size_t k = 0; k < D; ++k) store(row.force[k] + x, force[k]);
    }
};

//! Something that is to be done while a kernel goes through rows.
struct OnTheWay
{
    //! When it is about to read these cells, or later ones [slots from the first row's cell x = 0 on].
    std::ptrdiff_t due = std::numeric_limits<std::ptrdiff_t>::max();
    void (*act)(OnTheWay&, std::ptrdiff_t at) = nullptr;  //!< does it, and says when next

    //! The kernel is about to read the cells from `at` on, and may have to write those of one register before.
    [[gnu::always_inline]] void reach(std::ptrdiff_t at)
    {
        if (at >= due) [[unlikely]]
            act(*this, at);
    }
};

//! The cells [begin, end) of a row, or of several rows that are alike, `stride` apart in memory. With solids, or in a
//! frame that turns, of one. Of several, what lies between one row's end and the next one's begin may change as well.
struct CellRows
{
    std::ptrdiff_t begin, end;
    std::ptrdiff_t count = 1, stride = 0;  //!< rows; slots
    OnTheWay* on_the_way = nullptr;

    //! Calls each(x) for registers of so many cells, row by row, x from the first row's cell x = 0 on.
    template <std::ptrdiff_t lanes, class Each>
    [[gnu::always_inline]] void each_register(Each&& each) const
    {
        OnTheWay nothing, &way = on_the_way ? *on_the_way : nothing;
        for (std::ptrdiff_t k = 0, row = 0; k < count; ++k, row += stride)
            for (std::ptrdiff_t x = begin; x < end; x += lanes) {
                way.reach(row + x);
                each(row + x);
            }
    }
};

//! The last cells of a row, fewer than are computed at once: copied to where there is room for all, and back.
template <int D, class Stored>
class RowEndCells
{
 public:
    static constexpr std::size_t directions = Lattice<D>::directions;

    RowEndCells(Slots<D, Stored> const& slots, std::ptrdiff_t begin, FirstLanes<Stored> const& here) noexcept
        : from_(slots), begin_(begin), here_(here)
    {
        for (std::size_t q = 0; q < directions; ++q) {
            store(cells_[q], here.load(slots[q] + begin));
            at_[q] = cells_[q];
        }
    }
    Slots<D, Stored> const& slots() const noexcept { return at_; }
    void put_back() const noexcept
    {
        for (std::size_t q = 0; q < directions; ++q) {
            here_.store(from_[q] + begin_, load<Lanes<Stored>>(cells_[q]));
            ask_ahead<D>(from_[q] + begin_);
        }
    }

 private:
    Slots<D, Stored> from_, at_{};
    std::ptrdiff_t begin_;
    FirstLanes<Stored> here_;
    alignas(register_bytes) Stored cells_[directions][Lanes<Stored>::count];
};

//! The same of what is known and told of solids.
template <int D, class Stored>
class RowEndSolids
{
 public:
    RowEndSolids(SolidRow<Stored> const& row, std::ptrdiff_t begin, FirstLanes<Stored> const& here) noexcept
        : from_(row), begin_(begin), here_(here)
    {
        auto const copy = [&](Stored const* from, Stored* to) { store(to, here.load(from + begin)); };
        copy(row.fraction, known_[0]);
        copy(row.weight, known_[1]);
        copy(row.open, known_[2]);
        copy(row.ease, known_[3]);
        at_ = {known_[0], known_[1], known_[2], known_[3], {}, told_[0], {}};
        for (std::size_t k = 0; k < D; ++k) {
            copy(row.momentum[k], known_[4 + k]);
            at_.momentum[k] = known_[4 + k];
            at_.force[k] = told_[1 + k];
        }
    }
    SolidRow<Stored> const& row() const noexcept { return at_; }
    void put_back() const noexcept
    {
        auto const copy = [&](Stored const* from, Stored* to) { here_.store(to + begin_, load<Lanes<Stored>>(from)); };
        copy(told_[0], from_.force_rate);
        for (std::size_t k = 0; k < D; ++k) copy(told_[1 + k], from_.force[k]);
    }

 private:
    static constexpr std::size_t lanes = Lanes<Stored>::count;

    SolidRow<Stored> from_, at_{};
    std::ptrdiff_t begin_;
    FirstLanes<Stored> here_;
    alignas(register_bytes) Stored known_[4 + D][lanes], told_[1 + D][lanes];
};

//! Gives cells to collide(slots, solids, cells, first), in whole registers: the last ones of a row as a copy, whose
//! first cell is the row's cell `first`.
template <int D, bool grains, class V, class Stored, class Collide>
[[gnu::always_inline]] inline void in_whole_registers(Slots<D, Stored> const& slots, SolidRow<Stored> const& solid,
                                                      CellRows rows, Collide collide)
{
    constexpr auto lanes = static_cast<std::ptrdiff_t>(V::count);
    assert(!grains || rows.count == 1);
    if (rows.count > 1 && (rows.end - rows.begin) % lanes != 0)  // cheaper than the last ones of each as a copy
        rows = {rows.begin, (rows.count - 1) * rows.stride + rows.end, 1, 0, rows.on_the_way};
    std::ptrdiff_t const end = rows.end, whole = rows.begin + (end - rows.begin) / lanes * lanes;
    rows.end = whole;
    if (whole > rows.begin) collide(slots, solid, rows, 0);
    if (whole == end) return;
    if (rows.on_the_way) rows.on_the_way->reach(whole);
    CellRows const last{0, lanes};
    FirstLanes<Stored> const here(end - whole);
    RowEndCells<D, Stored> cells(slots, whole, here);
    if constexpr (grains) {
        RowEndSolids<D, Stored> solids(solid, whole, here);
        collide(cells.slots(), solids.row(), last, whole);
        solids.put_back();
    } else {
        collide(cells.slots(), solid, last, whole);
    }
    cells.put_back();
}

//! Shares of momentum that go along an axis and along each of the four diagonals through it, 1/3 and 1/6, so rounded
//! that axis + 4 diagonal = 1: with 1/3 and 1/6 as floats a cell's momentum would grow by 3e-8 of what is exchanged.
template <class Number>
struct MomentumShares
{
    static constexpr double diagonal = static_cast<Number>(1.0 / 6), axis = 1 - 4 * diagonal;
    static_assert(static_cast<Number>(axis) == axis);
};

//! Rates [1/step] of one cell, or of several at once.
template <class Rate>
struct Rates
{
    Rate shear, energy, square, flux;
};

inline constexpr double eddy_free = 1e-6;  //!< cells covered by more have no eddy viscosity

//! Rate of an even moment where the fluid is 1/open times as viscous: (1/rate - 1/2) is 1/open times as large.
template <class V>
[[gnu::always_inline]] inline V stiffened(double rate, V open) noexcept
{
    return open / (0.5 * open + (1.0 / rate - 0.5));
}
//! Rate of an odd moment there: (1/rate - 1/2) is open times as large, so that their product, magic, is the same.
template <class V>
[[gnu::always_inline]] inline V loosened(double rate, V open) noexcept
{
    return 1.0 / (0.5 + (1.0 / rate - 0.5) * open);
}

//! All of them in a cell with solids.
template <class V>
[[gnu::always_inline]] inline Rates<V> rates_beside(Relaxation const& r, V open) noexcept
{
    return {stiffened(r.shear, open), stiffened(r.energy, open), stiffened(r.square, open), loosened(r.flux, open)};
}

//! B/eps with (1 + q/3)/(1 + q) of the drag (solid_weight.hpp): of B/(1 - B).
template <class V>
[[gnu::always_inline]] inline V eased(V weight, V fraction, V q) noexcept
{
    return weight * madd(1.0 / 3, q, V(1.0)) / (1.0 + q * madd(-2.0 / 3, weight * fraction, V(1.0)));
}

}  // namespace lbm
