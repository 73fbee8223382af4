#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "participants/dem/energy.hpp"
#include "participants/dem/measures.hpp"
#include "tests/verification/dem/run_out.hpp"
#include "tests/verification/mpm/collapse.hpp"

//! Study L: dry columns as grains and as a continuum side by side, by what each has in energy and where each ends.
//! Grains: configs/run_out.yaml, but poured as loose as they are in their critical state, a fraction of 0.79 (a
//! friction of 0.3 does it; participants/dem/README.md), for the continuum neither dilates nor contracts. Continuum:
//! the column of configs/mpm_column.yaml with the grains' critical friction angle, 22.3 degrees, and their frictions on
//! floor and back wall, 20 cells across. Half an hour: only `./dev verify` runs it.
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

//! Energies at a time; of a Course by the potential energy of the start.
struct Energies
{
    double kinetic, potential, dissipated, friction;  //!< friction: what of the dissipated is sliding and rolling
};

//! Run-outs are (L - L0)/L0.
struct Course
{
    double aspect_ratio = 0;           //!< as it stood
    double grain = 0;                  //!< mean diameter by the column's width
    std::vector<Energies> energies{};  //!< each tenth of sqrt(H0/g), from the start on
    double one_grain = 0;              //!< where it is one grain deep
    double main_mass = 0;              //!< as run_out_of() and measure() have it
    double foremost = 0;               //!< grain, point

    Energies const& at(int tenth) const { return energies.at(static_cast<std::size_t>(tenth)); }
    //! Dissipated by the time the potential energy has fallen to this.
    double dissipated_at(double potential) const
    {
        std::size_t k = 1;
        while (k + 1 < energies.size() && energies[k].potential > potential) ++k;
        Energies const &before = energies[k - 1], &after = energies[k];
        double const share = (before.potential - potential) / (before.potential - after.potential);
        return before.dissipated + share * (after.dissipated - before.dissipated);
    }
};

//! Until 7 sqrt(H0/g): tall columns flow for 6 of it.
template <class Advance, class Look>
std::vector<Energies> follow(double height, Advance&& advance_to, Look&& look)
{
    double const whole = look().potential, unit = 0.1 * std::sqrt(height / 9.81);
    std::vector<Energies> course;
    for (int tenth = 0; tenth <= 70; ++tenth) {
        advance_to(tenth * unit);
        Energies const e = look();
        course.push_back({e.kinetic / whole, e.potential / whole, e.dissipated / whole, e.friction / whole});
    }
    return course;
}

Course as_grains(double aspect_ratio, int seed)
{
    std::string const column = "participants.grains.config.column.";
    auto const config = config_of("run_out.yaml", {column + "aspect_ratio=" + std::to_string(aspect_ratio),
                                                   column + "seed=" + std::to_string(seed),
                                                   column + "packing_friction=0.3", column + "packing_fraction=0.775"});
    auto solver = dem::make_solver<2>(config, dem::pour_packing<2>(config), dem::Ledger::on);
    auto const start = dem::measure(solver);
    double const width = start.front, height = start.height;
    Course c{.aspect_ratio = height / width};
    auto const advance_to = [&](double time) {
        while (solver.time() < time) solver.step(config.step);
    };
    c.energies = follow(height, advance_to, [&] {
        auto const e = dem::energies(solver.setup(), solver.state());
        return Energies{e.kinetic(), e.potential, e.lost(), e.sliding + e.rolling};
    });
    auto const& grains = solver.state().grains;
    double solid = 0;
    for (auto const& place : grains.place) solid += dem::volume_of<2>(place.radius);
    double const share = width * height / solid / (width * width);
    std::vector<Piece> pieces;
    for (auto const& place : grains.place)
        pieces.push_back({place.centre.x / width, place.radius / width, share * dem::volume_of<2>(place.radius)});
    c.grain = dem::mean_diameter(grains) / width;
    c.one_grain = front_of(pieces, c.grain) - 1;
    auto const end = dem::measure(solver);
    c.main_mass = end.front / width - 1;
    c.foremost = end.foremost / width - 1;
    return c;
}

//! `grain`: mean diameter by the column's width.
Course as_continuum(double aspect_ratio, double grain)
{
    Column const column{.aspect_ratio = aspect_ratio, .cells_across = 20, .friction_angle = 22.3, .rough_back = true};
    constexpr double width = Column::width;
    auto solver = column.solver();
    Course c{.aspect_ratio = aspect_ratio, .grain = grain};
    auto const advance_to = [&](double time) {
        while (solver.time() < time) solver.step(solver.longest_step());
    };
    c.energies = follow(column.height(), advance_to, [&] {
        auto const e = solver.energies();
        return Energies{e.kinetic, e.potential, e.lost(), e.booked.plastic + e.booked.sliding};
    });
    std::vector<Piece> pieces;
    double const half = solver.setup().half_width * solver.setup().cell / width;
    for (auto const& p : solver.state().points)
        pieces.push_back({p.place[0] / width, half, p.volume / (width * width)});
    c.one_grain = front_of(pieces, grain) - 1;
    auto const end = column.run_out(solver);
    c.main_mass = end.front / width - 1;
    c.foremost = end.foremost / width - 1;
    return c;
}

//! Grains and continuum of one column.
struct Pair
{
    Course grains, matter;
};

//! Columns of three seeds; single run-outs of tall columns differ by 10 %.
std::vector<Pair> columns_of(double aspect_ratio)
{
    std::vector<Pair> columns;
    for (int seed : {1, 2, 3}) {
        Course const grains = as_grains(aspect_ratio, seed);
        columns.push_back({grains, as_continuum(grains.aspect_ratio, grains.grain)});
    }
    return columns;
}

template <class Of>
double mean_of(std::vector<Pair> const& columns, Of&& of)
{
    double sum = 0;
    for (Pair const& pair : columns) sum += of(pair);
    return sum / static_cast<double>(columns.size());
}

void print(std::string const& name, Course const& c)
{
    std::printf("      %s a = %.2f, run-out: main mass %.2f, one grain deep %.2f, foremost %.2f\n", name.c_str(),
                c.aspect_ratio, c.main_mass, c.one_grain, c.foremost);
    for (int const tenth : {4, 10, 15, 20, 30}) {
        Energies const& e = c.at(tenth);
        std::printf("        at %.1f: kinetic %.3f, potential %.3f, dissipated %.3f, by friction %.3f\n", 0.1 * tenth,
                    e.kinetic, e.potential, e.dissipated, e.friction);
    }
}

}  // namespace

//! Bands: D11's column of the MPM over that of the discrete elements (about 1 up to a = 2, 1.2 to 1.6 from 4 on), S19
//! (0.85 to 1.15 at a = 0.4; 1.3 to 1.7 at a = 6 by the study's own fronts: the farthest grain that touches the main
//! mass, the farthest point) and S21 (0.7 to 0.9 of what grains dissipate, a = 6: by the clock at sqrt(H0/g), and where
//! both have fallen as far; README, Measured).
TEST_CASE("M08: columns as a continuum and as grains in their critical state" * doctest::skip())
{
    for (double const a : {0.4, 4.0, 6.0}) {
        Stopwatch const watch;
        auto const columns = columns_of(a);
        for (Pair const& pair : columns) print("grains", pair.grains), print("continuum", pair.matter);
        auto const check = [&](char const* what, double meant, double mark, auto&& of) {
            double const seen = mean_of(columns, of);
            CHECK(report(
                {"M08", named("a = %g: ", a) + what, seen, meant, std::abs(seen - meant), mark, watch.seconds()}));
        };
        check("foremost point by foremost grain", a < 2 ? 1 : 1.4, a < 2 ? 0.15 : 0.2,
              [](Pair const& p) { return p.matter.foremost / p.grains.foremost; });
        if (a < 6) continue;
        check("foremost point by the grains' main mass", 1.5, 0.2,
              [](Pair const& p) { return p.matter.foremost / p.grains.main_mass; });
        check("dissipated at sqrt(H0/g), by that of grains", 0.8, 0.1,
              [](Pair const& p) { return p.matter.at(10).dissipated / p.grains.at(10).dissipated; });
        for (double const left : {0.42, 0.27, 0.18})
            check(named("dissipated by that of grains, potential %g", left).c_str(), 0.8, 0.1,
                  [&](Pair const& p) { return p.matter.dissipated_at(left) / p.grains.dissipated_at(left); });
        // study L: 60 of the 74 % that grains have lost at 3 sqrt(H0/g) are friction's (15 %)
        check("share of friction in what grains lose", 60.0 / 74, 0.15 * 60 / 74,
              [](Pair const& p) { return p.grains.at(30).friction / p.grains.at(30).dissipated; });
        // the thesis' continuum (file D11_column_collapse_2d.csv), 20 %
        check("one grain deep, by the thesis' run-out", 1, 0.2,
              [](Pair const& p) { return p.matter.one_grain / 12.09; });
    }
}
