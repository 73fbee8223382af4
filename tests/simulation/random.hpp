#pragma once

#include <cstdint>

namespace simulation {

//! SplitMix64 (Steele, Lea, Flood 2014): the same numbers on every machine.
class Random
{
 public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::uint64_t next()
    {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }
    //! 0 to n-1; n > 0. The bias of the remainder does not matter here.
    std::int64_t below(std::int64_t n) { return static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(n)); }
    std::int64_t between(std::int64_t low, std::int64_t high) { return low + below(high - low + 1); }
    bool one_in(std::int64_t n) { return below(n) == 0; }

 private:
    std::uint64_t state_;
};

}  // namespace simulation
