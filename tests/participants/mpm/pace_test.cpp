#include "participants/mpm/pace.hpp"

#include <doctest/doctest.h>

namespace {

//! The share of the steps that went together, of a second of steps that take so long.
double share_together(mpm::Pace& pace, double alone, double together)
{
    double time = 0, steps = 0, shared = 0;
    while (time < 1) {
        bool const with_help = pace.together();
        double const took = with_help ? together : alone;
        pace.took(took);
        time += took;
        steps += 1;
        shared += with_help;
    }
    return shared / steps;
}

}  // namespace

TEST_CASE("pace: steps go together where that is faster, alone where it is not, and either is noticed when it changes")
{
    for (double const step : {1e-5, 1e-3, 0.02}) {
        CAPTURE(step);
        mpm::Pace pace;
        CHECK(share_together(pace, step, 0.6 * step) > 0.9);
        share_together(pace, step, 1.5 * step);
        CHECK(share_together(pace, step, 1.5 * step) < 0.1);
        share_together(pace, step, 0.6 * step);
        CHECK(share_together(pace, step, 0.6 * step) > 0.9);
    }
}
