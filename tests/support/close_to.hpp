#pragma once

#include <doctest/doctest.h>

//! CHECK(a == close_to(b).epsilon(1e-3)): |a - b| < 1e-3 of the larger of both. doctest's own Approx adds 1 to that, so
//! that any two small numbers are alike: energies of a grain are 1e-7 J. Where b is 0, compare |a| with a bound.
inline doctest::Approx close_to(double expected)
{
    return doctest::Approx(expected).scale(0.0);
}
