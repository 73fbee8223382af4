#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/mpm/packed_tensor.hpp"
#include "participants/mpm/state.hpp"

namespace mpm {

//! Which column holds what; a vector or tensor is a run of columns, row by row, a stress as PackStress has it.
template <int D>
struct PackedColumns
{
    enum : std::size_t
    {
        place = 0,                                 // [m]
        velocity = place + D,                      // [m/s]
        slope = velocity + D,                      // its gradient [1/s]
        mass = slope + D * D,                      // [kg]; plane: per metre
        volume,                                    // at the start [m3]; plane: [m2]
        ratio,                                     // J [-]
        stress,                                    // [Pa]
        gradient = stress + PackStress<D>::count,  // deformation gradient [-]
        around = gradient + D * D,                 // of the plane, its part across: around the axis [-]
        strain,                                    // plastic [-]
        gap,                                       // [-]
        kept,
        cell = kept,            // place at the start of the step, in cells from node 0
        change = cell + D,      // increment of the deformation gradient, less the identity [-]
        hoop = change + D * D,  // the same around the axis, of rings [-]
        count
    };
};

//! The points as columns, in the order of the cells they are in: neighbours in memory meet the same nodes. Each column
//! is filled up to a whole number of packs; points that only fill it have no mass and no volume.
template <int D>
class PackedPoints
{
 public:
    using C = PackedColumns<D>;

    static constexpr std::size_t row = C::kept + 1;  //!< numbers of a point: where it is in the state, and what it has

    explicit PackedPoints(std::size_t count = 0) { resize(count); }
    //! Those from a place of the state's order to another.
    void take(State<D> const& state, std::size_t begin, std::size_t end);
    //! Back to where they came from; `begin`: place of the first in the order. With `slopes`, or zero.
    void give(State<D>& state, std::size_t begin, bool slopes) const;
    static constexpr std::uint32_t nowhere = UINT32_MAX;
    //! Each to another place; one that goes nowhere is lost.
    void move(std::span<std::uint32_t const> to);
    void add_row(std::size_t k, std::vector<double>& rows) const;
    void set_row(std::size_t k, double const* numbers);
    //! Points that only fill a pack go where the last one is.
    void place_fillers();

    double* operator[](std::size_t column) { return column_[column].data(); }
    double const* operator[](std::size_t column) const { return column_[column].data(); }
    std::size_t size() const { return order_.size(); }
    std::vector<std::int32_t> const& order() const { return order_; }  //!< index in the state of each

    //! Of the four points from k on.
    [[gnu::always_inline]] Pack at(std::size_t column, std::size_t k) const { return load(column_[column].data() + k); }
    [[gnu::always_inline]] void set(std::size_t column, std::size_t k, Pack value)
    {
        store(column_[column].data() + k, value);
    }
    [[gnu::always_inline]] PackVec<D> vector_at(std::size_t column, std::size_t k) const
    {
        PackVec<D> v;
        for (int a = 0; a < D; ++a) v[a] = at(column + static_cast<std::size_t>(a), k);
        return v;
    }
    [[gnu::always_inline]] PackMat<D> matrix_at(std::size_t column, std::size_t k) const
    {
        PackMat<D> m;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) m(a, b) = at(column + static_cast<std::size_t>(a * D + b), k);
        return m;
    }
    [[gnu::always_inline]] PackStress<D> stress_at(std::size_t k) const
    {
        PackStress<D> s;
        for (std::size_t i = 0; i < PackStress<D>::count; ++i) s.part[i] = at(C::stress + i, k);
        return s;
    }
    [[gnu::always_inline]] void set(std::size_t column, std::size_t k, PackVec<D> const& v)
    {
        for (int a = 0; a < D; ++a) set(column + static_cast<std::size_t>(a), k, v[a]);
    }
    [[gnu::always_inline]] void set(std::size_t column, std::size_t k, PackMat<D> const& m)
    {
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) set(column + static_cast<std::size_t>(a * D + b), k, m(a, b));
    }
    [[gnu::always_inline]] void set(std::size_t k, PackStress<D> const& s)
    {
        for (std::size_t i = 0; i < PackStress<D>::count; ++i) set(C::stress + i, k, s.part[i]);
    }

 private:
    void resize(std::size_t count);

    std::array<std::vector<double>, C::count> column_;
    std::vector<std::int32_t> order_;
};

}  // namespace mpm
