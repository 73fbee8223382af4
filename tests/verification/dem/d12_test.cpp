#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "participants/dem/front.hpp"
#include "participants/dem/measures.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/run_out.hpp"

//! D12: run-out of dry quarter columns of spheres, configs/run_out_quarter.yaml, against the laws of Lube et al. (2004)
//! (file D12_column_collapse_axisym.csv).
namespace {

//! Of t_c/50, the scenes' step: half as many steps, of which sweep D6 says what they change.
constexpr double step_factor = 2;

//! The front of the main mass by the sectors of the centrifuge study [m].
double front_of_mass(dem::Grains<3> const& grains)
{
    dem::Grains<3> linked;
    auto const main = dem::main_mass(grains);
    for (std::size_t i = 0; i < grains.size(); ++i)
        if (main[i]) linked.add(grains.place[i].centre, grains.place[i].radius, 1.0);
    dem::Sectors const sectors{.angle = std::numbers::pi / 2};
    return dem::front_of(dem::reach_of(linked, sectors), sectors.percentile);
}

//! How far a column runs out, of its radius, which is so many mean diameters or a little more.
double collapse(double aspect_ratio, double diameters)
{
    // at the packing fraction that widths are reckoned with
    double const grains = std::ceil(dem::assumed_packing_fraction(3) * 1.5 * aspect_ratio * std::pow(diameters, 3));
    auto const config = verification::config_of(
        "run_out_quarter.yaml", {"participants.grains.config.column.aspect_ratio=" + std::to_string(aspect_ratio),
                                 "participants.grains.config.column.count=" + std::to_string(std::lround(grains))});
    double const radius = dem::column_width(config);
    CHECK(radius >= diameters * 2.0e-3);
    auto solver = dem::make_solver<3>(config, dem::pour_packing<3>(config));
    auto const before = dem::measure(solver);
    // it stops at about 3 of them (the file); what still creeps then is single grains
    while (solver.time() < 4 * std::sqrt(before.height / 9.81)) solver.steps(step_factor * config.step, 100);
    return front_of_mass(solver.grains()) / radius - 1;
}

//! Of columns that have run, by ratio.
std::map<double, double> run_outs;

void check_ratio(double aspect_ratio, double lube, double diameters)
{
    verification::Stopwatch watch;
    double const ours = run_outs[aspect_ratio] = collapse(aspect_ratio, diameters);
    char name[64];
    std::snprintf(name, sizeof name, "a = %.2f, r0 = %g d: (r - r0)/r0", aspect_ratio, diameters);
    CHECK(verification::report({"D12", name, ours, lube, std::abs(ours / lube - 1), 0.25, watch.seconds()}));
}

void check_exponent(double from, double to, double expected, double mark)
{
    char name[96];
    std::snprintf(name, sizeof name, "exponent, a = %g to %g", from, to);
    double const ours = verification::exponent(run_outs, from, to);
    CHECK(verification::report({"D12", name, ours, expected, std::abs(ours - expected), mark, 0.0}));
}

}  // namespace

//! Hours in all: only `./dev verify` runs it; a subcase runs by itself with build/tests/verify_dem -ns -tc="D12*"
//! -sc="a = 3". The file asks for a radius of 15 diameters or more.
TEST_CASE("D12: run-out of dry quarter columns of spheres" * doctest::skip())
{
    struct Row
    {
        char const* name;
        double aspect_ratio, lube, diameters;
    };
    for (Row const& row :
         {Row{"a = 0.5", 0.5, 0.62, 30}, Row{"a = 0.93", 0.93, 1.1532, 15}, Row{"a = 1.25", 1.25, 1.55, 15},
          Row{"a = 3", 3, 2.7713, 15}, Row{"a = 5", 5, 3.5777, 15}, Row{"a = 7", 7, 4.2332, 15}})
        SUBCASE(row.name) check_ratio(row.aspect_ratio, row.lube, row.diameters);
    SUBCASE("exponents")
    {
        REQUIRE_MESSAGE(run_outs.size() == 6, "needs the ratios in the same run: ./dev verify D12");
        check_exponent(0.5, 1.25, 1.0, 0.15);
        check_exponent(3, 7, 0.5, 0.12);
    }
}
