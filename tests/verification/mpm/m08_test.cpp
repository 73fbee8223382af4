#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/verification/mpm/collapse.hpp"

using namespace verification;

//! M08: run-out of dry columns, by that of discrete elements on the same floor, with the same friction angle
//! (participants/dem/README.md, D11). Bands of the ratio: file D11_column_collapse_2d.csv, 0.8 to 1.1 for a up to 2.
//! Minutes: only `./dev verify M08` runs it.
TEST_CASE("M08: run-out of columns as a continuum by that as grains" * doctest::skip())
{
    struct Band
    {
        double a, grains, ratio, mark;
    };
    for (auto const& [a, grains, ratio, mark] :
         {Band{0.4, 0.68, 0.95, 0.15}, {0.8, 1.43, 0.95, 0.15}, {1, 2.02, 0.95, 0.15}, {2, 3.80, 0.95, 0.15}}) {
        Stopwatch const watch;
        auto const c = collapse(a, 20);
        CHECK(report({"M08", named("a = %g: run-out by that of grains", a), c.run_out / grains, ratio,
                      std::abs(c.run_out / grains - ratio), mark, watch.seconds()}));
        check_ledger("M08", named("a = %g: ", a), c.ledger, watch.seconds());
    }
    // tall columns: a tongue goes ahead, and farther than grains, as in the file (1.18 at a = 4, 1.48 at 6, 1.39 at 8)
    Stopwatch const watch;
    double const tall = collapse(4, 20).foremost / 6.86;
    CHECK(report(
        {"M08", "a = 4: foremost point by that of grains", tall, 1.4, std::abs(tall - 1.4), 0.2, watch.seconds()}));
}

//! M08: the run-out does not depend on the cell beyond what the elements' own packings differ by (file: 0.84 to 1.18
//! between random and hexagonal at a = 0.8: 15 %), and pressures within a cell do not swing as they do where every
//! point keeps its own volume.
TEST_CASE("M08: run-out at a = 0.8 converges with the cell" * doctest::skip())
{
    Stopwatch const watch;
    auto const coarse = collapse(0.8, 10), middle = collapse(0.8, 20), fine = collapse(0.8, 40);
    CHECK(report({"M08", "a = 0.8: run-out with 10 by that with 40 cells", coarse.run_out / fine.run_out, 1,
                  std::abs(coarse.run_out / fine.run_out - 1), 0.15, watch.seconds()}));
    CHECK(report({"M08", "a = 0.8: run-out with 20 by that with 40 cells", middle.run_out / fine.run_out, 1,
                  std::abs(middle.run_out / fine.run_out - 1), 0.15, watch.seconds()}));
    auto const own = collapse(0.8, 20, false);
    CHECK(report({"M08", "pressures in a cell: swing, by the mean", middle.swing, 0, middle.swing, 0.6 * own.swing,
                  watch.seconds()}));
}
