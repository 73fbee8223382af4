#include "tests/verification/mpm/manufactured.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/verification/mpm/bars.hpp"

//! M09: the method of manufactured solutions.
using namespace verification;
using namespace verification::manufactured;

TEST_CASE("M09: the body forces are those of the file")
{
    struct Row
    {
        double X, Y, t, neo_x, neo_y, true_x, true_y;
    };
    for (Row const& r : {Row{0.1, 0.3, 0.004, 150.3758168, -1943.263163, 109.0418331, -2602.466227},
                         Row{0.25, 0.25, 0.004, 585.710095, -1973.936308, 295.1025844, -2204.078602},
                         Row{0.5, 0.8, 0.004, 1315.660876, -269.1795105, 2388.175596, -554.48769},
                         Row{0.9, 0.6, 0.004, 1125.070001, -1429.037541, 930.4067909, -463.8991651}}) {
        CHECK((body_force(mpm::NeoHookean{elastic}, {r.X, r.Y}, r.t) - mpm::Vec<2>(r.neo_x, r.neo_y)).norm() < 1e-5);
        CHECK((body_force(true_strain(), {r.X, r.Y}, r.t) - mpm::Vec<2>(r.true_x, r.true_y)).norm() < 1e-5);
    }
}

//! Marks of the file: RMS 0.02 A at 32 cells; of order 1.6 from 16 to 32. With points as wide as at the start it
//! is 1.2: pressed together they overlap, at the sides they reach the nodes behind.
TEST_CASE("M09: manufactured solution")
{
    struct Case
    {
        char const* name;
        mpm::Law law;
        mpm::Scheme scheme;
        bool affine;
    };
    mpm::Law const neo = mpm::NeoHookean{elastic};
    using enum mpm::Scheme;
    for (Case const& k : {Case{"neo-Hookean, musl", neo, musl, true}, Case{"rates, musl", true_strain(), musl, true},
                          Case{"rates, musl, not affine", true_strain(), musl, false}}) {
        Stopwatch const watch;
        auto const rms = [&](int cells, mpm::Width width) {
            return rms_deviation(k.law, cells, k.scheme, k.affine, width);
        };
        double const coarse = rms(16, mpm::Width::stretch), fine = rms(32, mpm::Width::stretch);
        double const fixed = rms(32, mpm::Width::fixed), order = std::log2(coarse / fine);
        std::string const name = k.name;
        CHECK(report({"M09", name + ", width: stretch: rms at 32 [A]", fine, 0, fine, 0.02, watch.seconds()}));
        CHECK(report({"M09", name + ", width: stretch: order (1.6 or more)", order, 2, std::max(0.0, 2 - order), 0.4,
                      watch.seconds()}));
        CHECK(report({"M09", name + ": rms at 32 [A]", fixed, 0, fixed, 0.02, watch.seconds()}));
    }
}

//! Mark of the file: 1.3.
TEST_CASE("M09: manufactured solution, 64 cells" * doctest::skip())
{
    Stopwatch const watch;
    auto const rms = [&](int cells) {
        return rms_deviation(true_strain(), cells, mpm::Scheme::musl, true, mpm::Width::stretch);
    };
    double const fine = rms(64), order = std::log2(rms(32) / fine);
    CHECK(report({"M09", "rates, musl, width: stretch: rms at 64 [A]", fine, 0, fine, 0.02, watch.seconds()}));
    CHECK(report({"M09", "rates, musl, width: stretch: order 32 to 64 (1.3 or more)", order, 2,
                  std::max(0.0, 2 - order), 0.7, watch.seconds()}));
}
