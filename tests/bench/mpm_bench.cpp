//! Speed of the continuum solver: million point-steps a second of a collapsing column, a = 1, Mohr-Coulomb, 4 points a
//! cell. Prints a table; `--json FILE` writes a list of {case, metric, value, unit, against, ratio}. `--small`: a smoke
//! run.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "participants/mpm/setup.hpp"

namespace {

using Clock = std::chrono::steady_clock;
nlohmann::json results = nlohmann::json::array();

void note(std::string const& name, double value, double against)
{
    std::printf("%-40s %8.3f million point-steps/s  %5.2f of gimp, musl\n", name.c_str(), value, value / against);
    std::fflush(stdout);
    results.push_back({{"case", name},
                       {"metric", "speed, 1 thread"},
                       {"value", value},
                       {"unit", "million point-steps/s"},
                       {"against", "gimp, musl"},
                       {"ratio", value / against}});
}

//! `across` points along the base.
mpm::Config column(int across)
{
    mpm::Elasticity const e{1e7, 0.3};
    mpm::Config c;
    c.cell = 0.2 / across;
    c.size = {0.3, 0.15, 0};
    c.size[0] = c.cell * std::ceil(0.3 / c.cell);
    c.size[1] = c.cell * std::ceil(0.15 / c.cell);
    c.gravity = {0, -9.81, 0};
    c.density = 1900;
    c.law = mpm::MohrCoulomb{e, mpm::MohrCoulombSurface(e, {.friction_angle = 26 * std::numbers::pi / 180})};
    c.bodies.push_back({.high = {0.1, 0.1, 0}});
    c.walls = {{.axis = 0, .side = -1}, {.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.4}};
    c.geostatic = mpm::GeostaticConfig{.surface = 0.1, .k0 = 0.5};
    return c;
}

//! Best of three: steps of a column that has begun to fall.
double speed(mpm::Config const& c, int steps)
{
    auto solver = mpm::make_solver<2>(c);
    while (solver.time() < 0.02) solver.step(solver.longest_step());
    double best = 0;
    for (int repeat = 0; repeat < 3; ++repeat) {
        auto const start = Clock::now();
        for (int k = 0; k < steps; ++k) solver.step(solver.longest_step());
        double const seconds = std::chrono::duration<double>(Clock::now() - start).count();
        best = std::max(best, steps * static_cast<double>(solver.state().points.size()) / seconds);
    }
    return best / 1e6;
}

}  // namespace

int main(int argc, char** argv)
{
    bool small = false;
    char const* json = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--small") == 0) small = true;
        if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) json = argv[++i];
    }
    mpm::Config const c = column(small ? 20 : 100);  // 400, 10 000 points
    int const steps = small ? 5 : 100;
    double const plain = speed(c, steps);
    note("gimp, musl", plain, plain);
    auto with = c;
    with.scheme = mpm::Scheme::usl;
    note("gimp, usl", speed(with, steps), plain);
    with.affine = false;
    note("gimp, usl, affine: false", speed(with, steps), plain);
    with = c;
    with.basis = mpm::BasisKind::spline;
    note("spline, musl", speed(with, steps), plain);
    with = c;
    with.law = mpm::LinearElastic{{1e7, 0.3}};
    note("gimp, musl, linear elastic", speed(with, steps), plain);
    if (json) std::ofstream(json) << results.dump(1) << '\n';
}
