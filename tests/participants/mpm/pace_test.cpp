#include "participants/mpm/pace.hpp"

#include <doctest/doctest.h>

#include <algorithm>

namespace {

//! Some time of steps that take so long.
struct Run
{
    double time = 0, steps = 0, shared = 0;
};

Run run(mpm::Pace& pace, double alone, double together, double seconds)
{
    Run r;
    auto& [time, steps, shared] = r;
    while (time < seconds) {
        bool const with_help = pace.together();
        double const took = with_help ? together : alone;
        pace.took(took);
        time += took;
        steps += 1;
        shared += with_help;
    }
    return r;
}

//! The share of the steps that went together, of a second.
double share_together(mpm::Pace& pace, double alone, double together)
{
    Run const r = run(pace, alone, together, 1);
    return r.shared / r.steps;
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

TEST_CASE("pace: trials take less than a tenth of the time, of long steps too")
{
    for (double const together : {1.2, 6.0}) {
        CAPTURE(together);
        mpm::Pace pace;
        Run const r = run(pace, 2, together, 100);
        CHECK(r.time < 1.1 * r.steps * std::min(2.0, together));
    }
}
