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

double collapse(double aspect_ratio)
{
    // r0 = 15 mean diameters at the packing fraction that widths are reckoned with
    double const grains = std::ceil(dem::assumed_packing_fraction(3) * 1.5 * aspect_ratio * std::pow(15.0, 3));
    auto const config = verification::config_of(
        "run_out_quarter.yaml", {"participants.grains.config.column.aspect_ratio=" + std::to_string(aspect_ratio),
                                 "participants.grains.config.column.count=" + std::to_string(std::lround(grains))});
    double const radius = dem::column_width(config);
    CHECK(radius >= 15 * 2.0e-3);
    auto solver = dem::make_solver<3>(config, dem::pour_packing<3>(config));
    auto const before = dem::measure(solver);
    // it stops at about 3 of them (the file); what still creeps then is single grains
    while (solver.time() < 4 * std::sqrt(before.height / 9.81)) solver.steps(step_factor * config.step, 100);
    return front_of_mass(solver.grains()) / radius - 1;
}

}  // namespace

//! Two hours: only `./dev verify` runs it.
TEST_CASE("D12: run-out of dry quarter columns of spheres, a = 0.5 to 7" * doctest::skip())
{
    std::map<double, double> const lube{{0.5, 0.62}, {0.93, 1.1532}, {1.25, 1.55},
                                        {3, 2.7713}, {5, 3.5777},    {7, 4.2332}};
    std::map<double, double> ours;
    verification::Stopwatch whole;
    for (auto const& [a, reference] : lube) {
        verification::Stopwatch watch;
        ours[a] = collapse(a);
        char name[64];
        std::snprintf(name, sizeof name, "a = %.2f: (r - r0)/r0", a);
        CHECK(verification::report(
            {"D12", name, ours[a], reference, std::abs(ours[a] / reference - 1), 0.25, watch.seconds()}));
    }
    double const low = verification::exponent(ours, 0.5, 1.25), high = verification::exponent(ours, 3, 7);
    CHECK(verification::report(
        {"D12", "exponent, a = 0.5 to 1.25 (0.85 to 1.15)", low, 1.0, std::abs(low - 1.0), 0.15, whole.seconds()}));
    CHECK(verification::report(
        {"D12", "exponent, a = 3 to 7 (0.38 to 0.62)", high, 0.5, std::abs(high - 0.5), 0.12, whole.seconds()}));
}
