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

double side_of(std::size_t grains)
{
    return 2.0 * mean_radius * std::cbrt(static_cast<double>(grains)) * 1.03;
}

dem::Grains<3> settled(std::size_t count)
{
    double const side = side_of(count);
    char const* const home = std::getenv("HOME");
    std::filesystem::path const file = std::filesystem::path(home ? home : "/tmp") / ".cache" / "sluice" /
                                       ("bench-column-" + std::to_string(count) + ".bin");
    std::string damage;
    dem::Grains<3> g;
    if (auto const kept = dem::load_packing<3>(file, damage)) {
        for (auto const& [centre, radius] : kept->place) g.add(centre, radius, density);
        return g;
    }
    std::printf("settling %zu grains (once)\n", count);
    std::fflush(stdout);
    dem::Random random(1);
    double const cell = 8.9e-3;
    auto const across = static_cast<std::size_t>(side / cell);
    double const pitch = side / static_cast<double>(across);
    for (std::size_t k = 0; k < count; ++k) {
        auto const at = [&](std::size_t n) {
            return (static_cast<double>(n) + 0.5) * pitch + random.uniform(-2e-5, 2e-5);
        };
        Vec3 const centre{at(k % across), at(k / across % across),
                          (static_cast<double>(k / across / across) + 0.5) * cell};
        g.add(centre, mean_radius * random.uniform(0.9, 1.1), density);
    }
    dem::Setup<3> s = liggghts::setup(side);
    s.law.normal.damping = s.law.tangential.damping = 5.0;  // [N s/m], about a third of the critical one
    s.law.tangential.friction = 0.2;
    for (auto& wall : s.walls) wall.law = s.law;
    s.loads = true;
    dem::Solver<3> solver(s, g);
    int const steps = 20000 + static_cast<int>(20.0 * std::cbrt(static_cast<double>(count)));
    for (int n = 0; n < steps; ++n) {
        if (n % 10 == 0)
            for (std::size_t i = 0; i < g.size(); ++i)  // as in a thick liquid: at rest sooner
                solver.grains().external[i].force =
                    (-20.0 * solver.grains().mass[i]) * solver.grains().motion[i].velocity;
        solver.step(2.0 * step);
    }
    dem::write_packing<3>({solver.grains().place, {}, 0.0}, file);
    dem::Grains<3> rest;
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
    for (int n = 0; n < warm_up; ++n) solver.step(step);
    double const start = clock();
    for (int n = 0; n < steps; ++n) solver.step(step);
    return clock() - start;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

}  // namespace dem_bench
