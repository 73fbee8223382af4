#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "participants/mpm/state.hpp"

namespace mpm {

//! The points of the plane as columns, in the order of the cells they are in: neighbours in memory meet the same nodes.
//! Each column is filled up to a whole number of packs; points that only fill it have no mass and no volume.
class PackedPoints
{
 public:
    enum Column : std::size_t
    {
        x,
        y,  // place [m]
        vx,
        vy,  // velocity [m/s]
        lxx,
        lxy,
        lyx,
        lyy,  // its gradient [1/s]
        mass,
        volume,  // [kg/m], at the start [m2]
        ratio,   // J [-]
        sxx,
        syy,
        szz,
        sxy,  // stress [Pa]
        fxx,
        fxy,
        fyx,
        fyy,     // deformation gradient [-]
        strain,  // plastic [-]
        gap,     // [-]
        columns_kept,
        cx = columns_kept,
        cy,  // place at the start of the step, in cells from node 0
        gxx,
        gxy,
        gyx,
        gyy,  // increment of the deformation gradient, less the identity [-]
        columns
    };

    void take(State<2> const& state);
    //! Back to where they came from. With `slopes`, or zero.
    void give(State<2>& state, bool slopes) const;
    //! Puts the points in the order of their keys; equal keys keep theirs.
    void sort(std::span<std::uint32_t const> keys, std::size_t key_count);
    //! Points that only fill a pack go where the last one is.
    void place_fillers();

    double* operator[](Column c) { return column_[c].data(); }
    double const* operator[](Column c) const { return column_[c].data(); }
    std::size_t size() const { return order_.size(); }
    std::vector<std::int32_t> const& order() const { return order_; }  //!< index in the state of each

 private:
    std::array<std::vector<double>, columns> column_;
    std::vector<std::int32_t> order_;
};

}  // namespace mpm
