#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sluice {

//! Numbers that somebody else holds: `values` is valid as long as `owner` is.
template <class T>
struct Held
{
    std::span<T const> values;
    std::shared_ptr<void const> owner;

    //! A copy of `values` that holds itself.
    static Held copy_of(std::span<T const> values)
    {
        auto const copy = std::make_shared<std::vector<T>>(values.begin(), values.end());
        return {*copy, copy};
    }
    static Held of(std::vector<T> numbers)
    {
        auto const own = std::make_shared<std::vector<T>>(std::move(numbers));
        return {*own, own};
    }
};

//! The points of one edge at one time. Numbers interleaved per point: columns[c] has size points * components, or is
//! empty if the receiver said that it does not read this column.
struct Frame
{
    std::int64_t index = 0;       //!< see schedule.hpp
    std::int64_t ticks = 0;       //!< its time, see base/ticks.hpp
    std::uint32_t iteration = 0;  //!< of the window, in an implicit group; else 0
    Held<std::int64_t> ids;       //!< lasting ids, one a point
    std::vector<Held<double>> columns;
    std::vector<double> totals = {};  //!< sums over the points of what adds up; empty: not yet summed

    std::size_t points() const { return ids.values.size(); }
};

}  // namespace sluice
