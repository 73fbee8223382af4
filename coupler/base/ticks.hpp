#pragma once

#include <cstdint>

namespace sluice {

//! Time of a coupled run as an integer, so that no ratio of steps leaves a remainder. One tick is this part of the
//! run's first window: 2^10 3^4 5^3 7 has the divisors that steps and windows use, among them 1 to 10, 100, 1000.
inline constexpr std::int64_t ticks_per_window = 72'576'000;

//! Ticks as seconds. The n-th window's end, for windows of equal length, is exactly the double nearest to n * length.
struct Timescale
{
    double window = 1;  //!< s, the first window's length

    double seconds(std::int64_t ticks) const
    {
        return window * (static_cast<double>(ticks) / static_cast<double>(ticks_per_window));
    }
    //! The whole number of ticks nearest to a time.
    std::int64_t ticks(double s) const
    {
        double const t = s / window * static_cast<double>(ticks_per_window);
        return static_cast<std::int64_t>(t + (t < 0 ? -0.5 : 0.5));
    }
};

}  // namespace sluice
