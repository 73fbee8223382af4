#pragma once

#include <cstdint>
#include <vector>

namespace sluice {

//! The points of one edge at one time. Numbers interleaved per point: columns[c] has size points * components.
struct Frame
{
    std::int64_t index = 0;         //!< see schedule.hpp
    double time = 0;                //!< s
    std::vector<std::int64_t> ids;  //!< lasting ids, one a point
    std::vector<std::vector<double>> columns;

    std::int64_t points() const { return static_cast<std::int64_t>(ids.size()); }
};

}  // namespace sluice
