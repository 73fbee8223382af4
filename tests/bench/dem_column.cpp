#include "tests/bench/dem_column.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "participants/dem/packing_file.hpp"
#include "participants/dem/random.hpp"
#include "tests/support/liggghts_column.hpp"

namespace dem_bench {

using dem::Vec3;
using liggghts::density, liggghts::step;

void note(std::string const& name, char const* metric, double value, char const* unit, char const* against,
          double ratio)
{
    results.push_back(
        {{"case", name}, {"metric", metric}, {"value", value}, {"unit", unit}, {"against", against}, {"ratio", ratio}});
}

namespace {

constexpr double pitch = 2.0 * 1.1 * mean_radius * 1.001;  // of the largest spheres, which just do not touch [m]
constexpr double margin = 1.1 * mean_radius + 1e-4;        // of the outermost centres from the walls [m]

//! Cells of the lattice along a side of a column about as high as wide.
std::size_t cells_across(std::size_t grains)
{
    return static_cast<std::size_t>(std::lround(std::cbrt(static_cast<double>(grains) / 4.0)));
}

//! Face-centred cubic, filled from the bottom up, a little off its places and in slow random motion: as it falls
//! together it loses its order.
dem::Grains<3> lattice(std::size_t count)
{
    constexpr double off = 1e-5, slow = 0.05;  // m, m/s
    double const cell = std::sqrt(2.0) * pitch;
    std::size_t const across = cells_across(count);
    dem::Random random(1);
    auto const about = [&](double scale) { return random.uniform(-scale, scale); };
    dem::Grains<3> g;
    for (std::size_t layer = 0;; ++layer)  // of half a cell
        for (std::size_t k = 0; k < 2 * across * across; ++k) {
            if (g.size() == count) return g;
            std::size_t const row = k / across;
            double const x = static_cast<double>(k % across) + 0.5 * static_cast<double>((row + layer) % 2),
                         y = 0.5 * static_cast<double>(row), z = 0.5 * static_cast<double>(layer);
            Vec3 const centre{margin + cell * x + about(off), margin + cell * y + about(off),
                              margin + cell * z + about(off)};
            g.add(centre, mean_radius * random.uniform(0.9, 1.1), density,
                  {{about(slow), about(slow), about(slow)}, {}});
        }
}

}  // namespace

double side_of(std::size_t grains)
{
    return (static_cast<double>(cells_across(grains)) - 0.5) * std::sqrt(2.0) * pitch + 2.0 * margin;
}

dem::Grains<3> settled(std::size_t count)
{
    char const* const home = std::getenv("HOME");
    std::filesystem::path const file = std::filesystem::path(home ? home : "/tmp") / ".cache" / "sluice" /
                                       ("bench-fcc-" + std::to_string(count) + ".bin");
    std::string damage;
    dem::Grains<3> rest;
    if (auto const kept = dem::load_packing<3>(file, damage)) {
        for (auto const& [centre, radius] : kept->place) rest.add(centre, radius, density);
        return rest;
    }
    std::printf("settling %zu grains (once)\n", count);
    std::fflush(stdout);
    dem::Setup<3> setup = liggghts::setup(side_of(count));
    setup.loads = true;
    dem::Solver<3> solver(setup, lattice(count));
    constexpr int steps = 30'000;  // 0.3 s
    constexpr double drag = 10.0;  // 1/s: in 0.3 s at rest
    for (int n = 0; n < steps; ++n) {
        if (n % 10 == 0)
            for (std::size_t i = 0; i < count; ++i)
                solver.grains().external[i].force =
                    (-drag * solver.grains().mass[i]) * solver.grains().motion[i].velocity;
        solver.step(2.0 * step);
    }
    dem::write_packing<3>({solver.grains().place, {}, 0.0}, file);
    for (auto const& [centre, radius] : solver.grains().place) rest.add(centre, radius, density);
    return rest;
}

dem::ContactConfig laws(dem::Rolling rolling)
{
    dem::ContactConfig law;
    law.normal_stiffness = liggghts::kn;
    law.tangential_stiffness = liggghts::kt;
    law.damping_ratio = law.tangential_damping = 0.1;
    law.friction = liggghts::mu;
    if (rolling == dem::Rolling::none) return law;
    law.rolling = rolling;
    law.rolling_friction = liggghts::mu_r;
    law.rolling_stiffness = 1.0;
    law.rolling_damping = 0.3;
    return law;
}

double processor_time(int who)
{
    rusage usage{};
    getrusage(who, &usage);
    auto const seconds = [](timeval t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double own_time()
{
    return processor_time(RUSAGE_SELF);
}
double wall_time()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double run_ours(dem::Solver<3> solver, int steps, double (*clock)())
{
    solver.steps(step, warm_up);
    double const start = clock();
    solver.steps(step, steps);
    return clock() - start;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

}  // namespace dem_bench
