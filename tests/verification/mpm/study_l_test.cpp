#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "participants/dem/energy.hpp"
#include "participants/dem/measures.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/verification/dem/run_out.hpp"
#include "tests/verification/mpm/bars.hpp"

//! Study L: dry columns as grains and as a continuum side by side, by what each has in energy and where each ends.
//! Grains: configs/run_out.yaml. Continuum: the column of configs/mpm_column.yaml with the grains' critical friction
//! angle, 22.3 degrees (participants/dem/README.md), 20 cells across. Minutes: only `./dev verify` runs it.
using namespace verification;

namespace {

//! A piece of matter: where it is along the floor, how wide, how much (with its pores, by the column's area).
struct Piece
{
    double x, half, area;
};

//! Where the depth, as a mean over a tenth of the column's width, falls below `depth`, coming from the back wall; all
//! by that width. The same for grains and points, and no question of what hangs together.
double front_of(std::vector<Piece> const& pieces, double depth)
{
    constexpr int in_window = 10;
    constexpr double strip = 0.1 / in_window;
    std::vector<double> area;
    for (Piece const& p : pieces)
        for (int part = 0; part < 8; ++part) {
            double const x = std::max(0.0, p.x + p.half * ((part + 0.5) / 4 - 1));
            auto const at = static_cast<std::size_t>(x / strip);
            if (at >= area.size()) area.resize(at + 1, 0.0);
            area[at] += p.area / 8;
        }
    double sum = 0;
    for (std::size_t k = 0; k < area.size() + in_window; ++k) {
        if (k < area.size()) sum += area[k];
        if (k >= in_window && k - in_window < area.size()) sum -= area[k - in_window];
        if (k >= in_window && sum < depth * strip * in_window)
            return strip * (static_cast<double>(k + 1) - in_window / 2.0);
    }
    return strip * static_cast<double>(area.size());
}

//! Energies by the potential energy of the start, times by sqrt(H0/g).
struct Course
{
    double grain = 0;                     //!< mean diameter by the column's width
    double kinetic = 0;                   //!< the largest
    double lost_at_1 = 0, lost_at_3 = 0;  //!< dissipated until then
    double rubbed_at_3 = 0;               //!< of it by friction, sliding and rolling
    double one_grain = 0, tail = 0;       //!< run-out at a depth of one grain, of 5 % of the root of the area
};

Course as_grains(double aspect_ratio)
{
    auto const config =
        config_of("run_out.yaml", {"participants.grains.config.column.aspect_ratio=" + std::to_string(aspect_ratio)});
    auto solver = dem::make_solver<2>(config, dem::pour_packing<2>(config), dem::Ledger::on);
    auto const start = dem::measure(solver);
    double const width = start.front, height = start.height, time_scale = std::sqrt(height / 9.81);
    double const whole = dem::energies(solver.setup(), solver.state()).potential;
    Course c;
    for (int k = 1; k <= 70; ++k) {
        while (solver.time() < 0.1 * k * time_scale) solver.step(config.step);
        auto const e = dem::energies(solver.setup(), solver.state());
        c.kinetic = std::max(c.kinetic, e.kinetic() / whole);
        if (k == 10) c.lost_at_1 = e.lost() / whole;
        if (k == 30) c.lost_at_3 = e.lost() / whole, c.rubbed_at_3 = (e.sliding + e.rolling) / whole;
    }
    auto const& grains = solver.state().grains;
    double solid = 0;
    for (auto const& place : grains.place) solid += dem::volume_of<2>(place.radius);
    double const share = width * height / solid / (width * width);
    std::vector<Piece> pieces;
    for (auto const& place : grains.place)
        pieces.push_back({place.centre.x / width, place.radius / width, share * dem::volume_of<2>(place.radius)});
    c.grain = dem::mean_diameter(grains) / width;
    c.one_grain = front_of(pieces, c.grain) - 1;
    c.tail = front_of(pieces, 0.05 * std::sqrt(height / width)) - 1;
    return c;
}

//! `grain`: mean diameter by the column's width.
Course as_continuum(double aspect_ratio, double grain)
{
    double const width = 0.1, height = aspect_ratio * width, time_scale = std::sqrt(height / 9.81);
    mpm::Elasticity const elastic{1.98e6, 0.23};
    mpm::MohrCoulombParameters const critical{.friction_angle = 22.3 * std::numbers::pi / 180};
    mpm::Config config;
    config.cell = width / 20;
    config.size = {width * (3 + std::ceil(3.2 * aspect_ratio)), height + 2 * config.cell, 0};
    config.gravity = {0, -9.81, 0};
    config.density = 1925;
    config.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, critical)};
    config.bodies.push_back({.high = {width, height, 0}});
    config.walls = {{.axis = 0, .side = -1}, {.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.466}};
    config.geostatic = mpm::GeostaticConfig{.surface = height, .k0 = 0.23 / 0.77};
    config.shared_volume = true;
    auto solver = mpm::make_solver<2>(config);
    double const whole = solver.energies().potential;
    Course c{.grain = grain};
    for (int k = 1; k <= 70; ++k) {
        while (solver.time() < 0.1 * k * time_scale) solver.step(solver.longest_step());
        auto const e = solver.energies();
        c.kinetic = std::max(c.kinetic, e.kinetic / whole);
        if (k == 10) c.lost_at_1 = e.lost() / whole;
        if (k == 30) c.lost_at_3 = e.lost() / whole, c.rubbed_at_3 = (e.booked.plastic + e.booked.sliding) / whole;
    }
    std::vector<Piece> pieces;
    double const half = solver.setup().half_width * solver.setup().cell / width;
    for (auto const& p : solver.state().points)
        pieces.push_back({p.place[0] / width, half, p.volume / (width * width)});
    c.one_grain = front_of(pieces, grain) - 1;
    c.tail = front_of(pieces, 0.05 * std::sqrt(aspect_ratio)) - 1;
    return c;
}

}  // namespace

TEST_CASE("M08: tall columns as a continuum and as grains, at like depth" * doctest::skip())
{
    // the file (D11_column_collapse_2d.csv): MPM of the thesis, mark 20 % as of its elements above a = 2
    for (auto const& [a, thesis] : {std::pair{4.0, 7.968}, {6.0, 12.09}}) {
        Stopwatch const watch;
        Course const grains = as_grains(a), matter = as_continuum(a, grains.grain);
        double const ratio = matter.one_grain / grains.one_grain;
        CHECK(ratio > 1);  // a sign only: the mark of study L, 1.3 to 1.7 at a = 6, is missed (README, Measured)
        CHECK(report({"M08", "a = " + std::to_string(int(a)) + ": run-out at one grain's depth, by the thesis' MPM",
                      matter.one_grain, thesis, std::abs(matter.one_grain / thesis - 1), 0.2, watch.seconds()}));
        std::printf(
            "      by grains' %.3f; at 5 %% of the root of the area: %.2f, grains %.2f; peak kinetic energy %.3f, "
            "grains %.3f\n",
            ratio, matter.tail, grains.tail, matter.kinetic, grains.kinetic);
        std::printf("      dissipated at 1, 3: %.3f, %.3f; grains %.3f, %.3f, by friction at 3 %.3f, grains %.3f\n",
                    matter.lost_at_1, matter.lost_at_3, grains.lost_at_1, grains.lost_at_3, matter.rubbed_at_3,
                    grains.rubbed_at_3);
        if (a < 6) continue;
        // study L: 60 of the 74 % that grains have lost at 3 sqrt(H0/g) are friction's (15 %)
        double const friction = grains.rubbed_at_3 / grains.lost_at_3;
        CHECK(report({"M08", "a = 6: share of friction in what grains lose", friction, 60.0 / 74,
                      std::abs(friction / (60.0 / 74) - 1), 0.15, watch.seconds()}));
        CHECK(matter.lost_at_1 < grains.lost_at_1);  // a sign only: the mark of study L, 0.7 to 0.9, is missed
    }
}
