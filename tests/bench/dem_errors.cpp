#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "participants/dem/measures.hpp"
#include "participants/dem/setup.hpp"
#include "tests/bench/dem_column.hpp"
#include "tests/verification/dem/oblique_impact.hpp"
#include "tests/verification/dem/run_out.hpp"

namespace dem_bench {
namespace {

constexpr double damping = 0.08, tangential_damping = 0.5;  // D03a

struct Point
{
    double steps, error, microseconds;  // a contact time; of v0; an impact
};

//! Errors and times of D03's ten angles with so many steps a contact time. LIGGGHTS' order has another limit (arms,
//! dashpots outside the Coulomb test): its error is that against itself at t_c/50 000.
std::vector<Point> impacts(dem::Scheme scheme)
{
    std::vector<Point> points;
    for (double const steps : {10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0}) {
        double worst = 0.0, seconds = 0.0;
        for (auto const& row : scenes::damped) {
            double const angle = row.angle * std::numbers::pi / 180.0;
            double const fine = std::numbers::pi * std::sqrt(scenes::sphere_mass / scenes::stiffness) / 50'000.0;
            auto const reference = scheme == dem::Scheme::predicted
                                       ? scenes::Rebound{row.vn, row.vt, row.spin}
                                       : scenes::impact(angle, 0.4, damping, tangential_damping, fine, 0.5, scheme);
            double const start = own_time();
            worst =
                std::max(worst, scenes::error_of(reference, angle, 0.4, damping, tangential_damping, steps, scheme));
            seconds += own_time() - start;
        }
        points.push_back({steps, worst, 1e6 * seconds / 80});
    }
    return points;
}

//! Steps a contact time at which the error comes to a mark, between the points by powers; 0: none of them does.
double steps_to(std::vector<Point> const& points, double mark)
{
    for (std::size_t k = 1; k < points.size(); ++k) {
        auto const &a = points[k - 1], &b = points[k];
        if (b.error > mark) continue;
        if (a.error <= mark) return a.steps;
        return a.steps * std::pow(b.steps / a.steps, std::log(a.error / mark) / std::log(a.error / b.error));
    }
    return 0.0;
}

}  // namespace

void impact_errors()
{
    auto const ours = impacts(dem::Scheme::predicted), theirs = impacts(dem::Scheme::liggghts);
    for (std::size_t k = 0; k < ours.size(); ++k) {
        std::printf("D03a, t_c/%-5g  error / v0 %.2e (%6.1f us an impact), in LIGGGHTS' order %.2e (%6.1f us)\n",
                    ours[k].steps, ours[k].error, ours[k].microseconds, theirs[k].error, theirs[k].microseconds);
        note("D03a, t_c/" + std::to_string(std::lround(ours[k].steps)), "error / v0", ours[k].error, "-",
             "LIGGGHTS' order", ours[k].error / theirs[k].error);
    }
    for (double const mark : {5e-3, 1e-3}) {
        double const own = steps_to(ours, mark), peer = steps_to(theirs, mark);
        std::printf("D03a, error %g: t_c/%.0f, in LIGGGHTS' order t_c/%.0f: %.1f times the steps\n", mark, own, peer,
                    peer / own);
        char name[64];
        std::snprintf(name, sizeof name, "D03a, to an error of %g", mark);
        note(name, "steps a contact time", own, "-", "LIGGGHTS' order", own / peer);
    }
}

void run_out_errors()
{
    auto const config = verification::config_of("run_out.yaml", {"participants.grains.config.column.aspect_ratio=2"});
    auto const packing = dem::pour_packing<2>(config);
    double finest = 0.0;
    for (double const steps : {100.0, 50.0, 25.0, 15.5}) {
        auto solver = dem::make_solver<2>(config, packing);
        auto const before = dem::measure(solver);
        double const step = config.contact_time / steps, start = own_time();
        while (solver.time() < 7 * std::sqrt(before.height / 9.81)) solver.step(step);
        double const seconds = own_time() - start, run_out = dem::measure(solver).front / before.front - 1;
        double const way = dem::centre_of_mass(solver.grains()).x / before.centre_of_mass.x - 1;
        if (finest == 0.0) finest = way;
        std::printf(
            "D11, a = 2, t_c/%-5g  run-out %.3f (thesis 3.79, experiments 3.47), way of the centre of mass %.4f "
            "(%.1f %% off the finest), %.0f s\n",
            steps, run_out, way, 100 * (way / finest - 1), seconds);
        note("D11, a = 2, t_c/" + std::to_string(std::lround(steps)), "time", seconds, "s", "the thesis' run-out",
             run_out / 3.789);
    }
}

}  // namespace dem_bench
