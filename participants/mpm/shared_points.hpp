#pragma once

#include <cstdint>
#include <span>

#include "participants/mpm/packed_points.hpp"
#include "participants/mpm/shares.hpp"

//! Points that go from process to process. All processes make the same calls.
namespace mpm {

//! Who is to have something.
enum class Whom
{
    first,  //!< the first process
    all
};

//! Each to another place in the order of all, and to the process that has it. `to`: of all points.
template <int D>
void move_points(Shares const& shares, std::span<std::uint32_t const> to, PackedPoints<D>& points);

//! Writes the points of all processes, and their order, into the state of those that are to have them. With `slopes`,
//! or zero.
template <int D>
void gather_points(Shares const& shares, PackedPoints<D> const& points, bool slopes, Whom whom, State<D>& state);

//! Places and velocities alone, into the state of the first process.
template <int D>
void gather_motion(Shares const& shares, PackedPoints<D> const& points, State<D>& state);

}  // namespace mpm
