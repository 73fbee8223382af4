#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "participants/mpm/measures.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/verification/mpm/bars.hpp"
#include "tests/verification/mpm/ledger_drift.hpp"

using namespace verification;

namespace {

struct Collapse
{
    double run_out;   //!< (L - L0)/L0 at a depth of 5 % of the root of its area, once it has come to rest
    double foremost;  //!< the same of the foremost point
    double swing;     //!< by which the pressures within a cell differ from their mean, by the mean of all (rms)
    LedgerDrift::Result ledger;
};

double swing(mpm::Solver<2> const& solver)
{
    std::map<std::pair<int, int>, std::pair<double, int>> cells;
    auto const cell_of = [&](auto const& p) {
        return std::pair(int(p.place[0] / solver.setup().cell), int(p.place[1] / solver.setup().cell));
    };
    auto const pressure = [](auto const& p) { return -p.matter.stress.trace() / 3; };
    double all = 0, squares = 0;
    for (auto const& p : solver.state().points) {
        all += pressure(p);
        cells[cell_of(p)].first += pressure(p);
        ++cells[cell_of(p)].second;
    }
    for (auto const& p : solver.state().points)
        squares += std::pow(pressure(p) - cells[cell_of(p)].first / cells[cell_of(p)].second, 2);
    auto const count = static_cast<double>(solver.state().points.size());
    return std::sqrt(squares / count) / (all / count);
}

//! The column of configs/mpm_column.yaml, 0.1 m wide.
Collapse collapse(double aspect_ratio, int cells_across, bool shared_volume = true)
{
    double const width = 0.1, height = aspect_ratio * width;
    mpm::Elasticity const elastic{1.98e6, 0.23};
    mpm::MohrCoulombParameters const grains{.friction_angle = 23 * std::numbers::pi / 180};
    mpm::Config c;
    c.cell = width / cells_across;
    c.size = {width * (2 + std::ceil(3 * aspect_ratio)), c.cell * std::ceil(height / c.cell + 2), 0};
    c.gravity = {0, -9.81, 0};
    c.density = 1925;
    c.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, grains)};
    c.bodies.push_back({.high = {width, height, 0}});
    c.walls = {{.axis = 0, .side = -1}, {.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.466}};
    c.geostatic = mpm::GeostaticConfig{.surface = height, .k0 = 0.23 / 0.77};
    c.shared_volume = shared_volume;
    auto solver = mpm::make_solver<2>(c);
    LedgerDrift drift(solver);
    while (solver.time() < 7 * std::sqrt(height / 9.81)) {
        solver.step(solver.longest_step());
        drift.add(solver);
    }
    auto const r = mpm::run_out_of(solver.setup(), solver.state(), 0.05 * std::sqrt(width * height));
    return {r.front / width - 1, r.foremost / width - 1, swing(solver), drift.result(solver)};
}

}  // namespace

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
