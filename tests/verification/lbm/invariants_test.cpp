#include <doctest/doctest.h>

#include <numbers>
#include <random>
#include <string>
#include <tuple>

#include "tests/verification/lbm/lattice_case.hpp"

using namespace lattice_case;

namespace {

//! Fifty free discs, two and a half times as heavy as the fluid, that do not touch, in a box of 160 cells.
struct Swarm
{
    lbm::Solver<2> solver;
    Discs discs;
    std::vector<double> mass;

    static lbm::Config box(bool periodic, int threads, lbm::Precision precision, lbm::Surface surface)
    {
        lbm::Config c = config(160, 160, 0.8);
        c.surface = surface;
        c.precision = precision;
        make_periodic(c, periodic, periodic);
        c.threads = threads;
        return c;
    }

    Swarm(bool periodic, int threads, double drift, lbm::Precision precision = lbm::Precision::float64,
          lbm::Surface surface = lbm::Surface::covered)
        : solver(box(periodic, threads, precision, surface))
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> uniform(-1, 1);
        for (int k = 0; k < 50; ++k) {  // on a jittered grid of 22 cells
            double const r = 6 + uniform(random);
            discs.add(14 + 22 * (k % 7) + 2 * uniform(random), 11 + 20 * (k / 7) + 2 * uniform(random), r,
                      0.01 * uniform(random) + drift, 0.01 * uniform(random), 0.001 * uniform(random));
            mass.push_back(2.5 * std::numbers::pi * r * r);
        }
        if (drift != 0)
            solver.set_state([&](std::array<double, 2> const&) {
                return lbm::PointState<2>{.velocity = {drift, 0}, .pressure = 0, .gradient = {}};
            });
    }

    void step()
    {
        solver.set_bodies(discs.view());
        solver.step();
        auto const [force, torque] = solver.loads();
        for (std::size_t i = 0; i < mass.size(); ++i) {
            double const r = discs.radius[i];
            for (std::size_t k = 2 * i; k < 2 * i + 2; ++k) {
                discs.position[k] += discs.velocity[k];
                set_velocity_[k] = discs.velocity[k];
                discs.velocity[k] += force[k] / mass[i];
            }
            discs.spin[i] += torque[i] / (0.5 * mass[i] * r * r);
        }
    }

    //! Fluid outside the discs, discs, and the half of the last exchange that is under way (Solver::find_loads).
    std::array<double, 2> momentum()
    {
        auto sum = solver.momentum();
        for (std::size_t i = 0; i < mass.size(); ++i)
            for (std::size_t k : {0UL, 1UL})
                sum[k] += mass[i] * discs.velocity[2 * i + k] + 0.5 * solver.exchange().force[2 * i + k] -
                          mass[i] / 2.5 * set_velocity_[2 * i + k];
        return sum;
    }

    double scale() const  //!< sum of the discs' |m v|
    {
        double sum = 0;
        for (std::size_t i = 0; i < mass.size(); ++i)
            sum += mass[i] * std::hypot(discs.velocity[2 * i], discs.velocity[2 * i + 1]);
        return sum;
    }

 private:
    std::vector<double> set_velocity_ = std::vector<double>(100);
};

}  // namespace

namespace {

//! Largest change of momentum in a step, of 500, over the sum of the discs' |m v|.
double momentum_defect(lbm::Precision precision, lbm::Surface surface)
{
    Swarm swarm(true, 1, 0, precision, surface);
    swarm.step();
    auto last = swarm.momentum();
    double worst = 0;
    for (int k = 0; k < 500; ++k) {
        double const scale = swarm.scale();
        swarm.step();
        auto const now = swarm.momentum();
        worst = std::max({worst, std::abs(now[0] - last[0]) / scale, std::abs(now[1] - last[1]) / scale});
        last = now;
    }
    return worst;
}

double mass_change(lbm::Precision precision)
{
    Swarm swarm(false, 1, 0, precision);
    double const before = swarm.solver.mass();
    for (int k = 0; k < 2000; ++k) swarm.step();
    return relative(swarm.solver.mass(), before);
}

}  // namespace

TEST_CASE("C08: momentum of fluid and fifty discs, change per step")
{
    // marks: rounding of sums over all cells; that of a float, since fluid and discs have momentum of one size
    using lbm::Precision, lbm::Surface;
    for (auto const& [name, precision, surface, mark] :
         {std::tuple{"double", Precision::float64, Surface::covered, 1e-12},
          {"single", Precision::float32, Surface::covered, 0x1p-24},
          {"double", Precision::float64, Surface::forced, 1e-12},
          {"single", Precision::float32, Surface::forced, 0x1p-24}}) {
        verification::Stopwatch const watch;
        double const worst = momentum_defect(precision, surface);
        std::string const what = std::string(name) + ": momentum, largest change a step / sum |m v|";
        CHECK(verification::report({"C08", of_surface(surface, what), worst, 0, worst, mark, watch.seconds()}));
    }
}

TEST_CASE("C08: mass of fluid in a closed box with fifty moving discs, 2000 steps")
{
    // marks: rounding of the sum; of the nine floats of a cell, |f - w| < 0.01, by as much at every step at worst
    for (auto const& [name, precision, mark] : {std::tuple{"double", lbm::Precision::float64, 1e-12},
                                                {"single", lbm::Precision::float32, 2000 * 9 * 0.01 * 0x1p-24}}) {
        verification::Stopwatch const watch;
        double const error = mass_change(precision);
        CHECK(verification::report(
            {"C08", std::string(name) + ": mass, relative change", error, 0, error, mark, watch.seconds()}));
    }
}

TEST_CASE("C08: Galilean invariance: everything moves at 0.05 cells a step")
{
    for (auto const surface : all_surfaces) {
        verification::Stopwatch const watch;
        Swarm rest(true, 1, 0, lbm::Precision::float64, surface),
            moving(true, 1, 0.05, lbm::Precision::float64, surface);
        double difference = 0, size = 0;
        for (int k = 0; k < 1000; ++k) rest.step(), moving.step();
        auto const start = Swarm(true, 1, 0).discs.position;
        for (std::size_t k = 0; k < start.size(); ++k) {
            double const path = rest.discs.position[k] - start[k];
            double const other = moving.discs.position[k] - start[k] - (k % 2 == 0 ? 0.05 * 1000 : 0);
            difference += (path - other) * (path - other);
            size += path * path;
        }
        double const error = std::sqrt(difference / size);
        CHECK(verification::report({"C08", of_surface(surface, "paths over 1000 steps, RMS difference / RMS"), error, 0,
                                    error, 0.01, watch.seconds()}));
    }
}

TEST_CASE("C08: one, two and three threads, and a restart, give the same bits")
{
    verification::Stopwatch const watch;
    auto const kept = [](Swarm& swarm) {
        sluice::State state;
        swarm.solver.keep(state);
        return state;
    };
    auto const run = [&](int threads, bool restart, lbm::Precision precision, lbm::Surface surface) {
        Swarm swarm(false, threads, 0, precision, surface);
        for (int k = 0; k < 150; ++k) {
            if (restart && k == 77) {
                Swarm other(false, threads, 0, precision, surface);
                other.solver.restore(kept(swarm));
                for (; k < 150; ++k) {
                    if (k == 77) other.discs = swarm.discs;
                    other.step();
                }
                return kept(other);
            }
            swarm.step();
        }
        return kept(swarm);
    };
    double differences = 0;
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32})
        for (auto const surface : all_surfaces) {
            auto const one = run(1, false, precision, surface);
            for (int const threads : {2, 3}) differences += !(run(threads, false, precision, surface) == one);
            differences += !(run(1, true, precision, surface) == one);
        }
    CHECK(verification::report(
        {"C08", "runs that differ in any bit, of eighteen", differences, 0, differences, 0, watch.seconds()}));
}
