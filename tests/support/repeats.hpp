#pragma once

#include <cstdlib>

namespace sluice::test {

//! How often a test of random moments or inputs tries: `normal` times, or that times SLUICE_REPEATS in a long run:
//! `SLUICE_REPEATS=10 ctest ...`.
inline int repeats(int normal)
{
    char const* const text = std::getenv("SLUICE_REPEATS");
    int const factor = text ? std::atoi(text) : 1;
    return factor > 1 ? normal * factor : normal;
}

}  // namespace sluice::test
