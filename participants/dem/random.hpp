#pragma once

#include <cstdint>

namespace dem {

//! SplitMix64: the same numbers on every machine (the standard library's distributions are not).
//! Source: Steele, Lea, Flood, OOPSLA (2014).
class Random
{
 public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::uint64_t next() noexcept
    {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31);
    }
    //! Uniform in [0, 1), 53 bits.
    double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
    double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

 private:
    std::uint64_t state_;
};

}  // namespace dem
