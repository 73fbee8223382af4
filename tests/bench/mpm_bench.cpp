//! Speed of the continuum solver: million point-steps a second of a collapsing column, a = 1, Mohr-Coulomb unless said
//! otherwise, 4 points a cell; each way of working beside the plain one, one point at a time, in the same run. Prints a
//! table; `--json FILE` writes a list of {case, metric, value, unit, against, ratio}. `--small`: a smoke run.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
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
    std::printf("%-52s %8.3f million point-steps/s  %6.2f\n", name.c_str(), value, value / against);
    std::fflush(stdout);
    results.push_back({{"case", name},
                       {"metric", "speed"},
                       {"value", value},
                       {"unit", "million point-steps/s"},
                       {"against", "the same, one point at a time, one thread"},
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
    c.shared_volume = true;
    return c;
}

//! The same column, a tenth as many cells across and as deep: eight points a cell.
mpm::Config in_space(mpm::Config c, int across)
{
    c.dimension = 3;
    c.cell = 0.1 / across;
    c.size = {0.3, 0.1, 0.15};
    for (double& size : c.size) size = c.cell * std::ceil(size / c.cell - 1e-9);
    c.gravity = {0, 0, -9.81};
    c.bodies[0].high = {0.1, c.size[1], 0.1};
    c.walls[1].axis = 2;
    for (int side : {-1, 1}) c.walls.push_back({.axis = 1, .side = side, .place = side < 0 ? 0 : c.size[1]});
    return c;
}

//! Steps of a column that has begun to fall, best of three: one point at a time and as it is, by processor time; with
//! two threads, by the clock.
template <int D>
void measure(std::string const& name, mpm::Config const& c, int steps)
{
    auto fast = mpm::make_solver<D>(c);
    while (fast.time() < 0.02) fast.step(fast.longest_step());
    auto setup = fast.setup();
    setup.one_at_a_time = true;
    mpm::Solver<D> slow(setup, fast.state());
    auto two = fast;
    two.use_threads(2);
    auto const points = static_cast<double>(fast.state().points.size());
    double best[3] = {};
    for (int repeat = 0; repeat < 3; ++repeat)
        for (int way = 0; way < 3; ++way) {
            auto& solver = way == 0 ? slow : way == 1 ? fast : two;
            int const count = way == 0 ? std::max(1, steps / 10) : steps;
            auto const start = Clock::now();
            std::clock_t const used = std::clock();
            for (int k = 0; k < count; ++k) solver.step(solver.longest_step());
            double const wall = std::chrono::duration<double>(Clock::now() - start).count();
            double const seconds = way == 2 ? wall : static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
            best[way] = std::max(best[way], 1e-6 * count * points / seconds);
        }
    note(name + ", one at a time", best[0], best[0]);
    note(name, best[1], best[0]);
    note(name + ", two threads", best[2], best[0]);
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
    std::printf("%-52s %8s                        by one at a time\n", "", "");
    measure<2>("gimp, musl", c, steps);
    auto with = c;
    with.shared_volume = false;
    measure<2>("gimp, musl, shared_volume: false", with, steps);
    with.scheme = mpm::Scheme::usl;
    measure<2>("gimp, usl, shared_volume: false", with, steps);
    with.affine = false;
    measure<2>("gimp, usl, shared_volume and affine: false", with, steps);
    with = c;
    with.law = mpm::LinearElastic{{1e7, 0.3}};
    measure<2>("gimp, musl, linear elastic", with, steps);
    double const degree = std::numbers::pi / 180;
    with.law = mpm::DruckerPrager{{{1e7, 0.3}}, mpm::DruckerPragerSurface({1e7, 0.3}, {.friction_angle = 26 * degree})};
    measure<2>("gimp, musl, Drucker-Prager", with, steps);
    with.law = mpm::MuOfI{{{1e7, 0.3}}, 0.4, 0.65, 0.28, 1e-3, 2600};
    measure<2>("gimp, musl, mu(I)", with, steps);
    with = c;
    with.symmetry = mpm::Symmetry::axial;
    measure<2>("gimp, musl, rings", with, steps);
    with = c;
    with.walls.erase(with.walls.begin());
    for (int side : {-1, 1}) with.walls.push_back({0, side, side < 0 ? 0 : c.size[0], mpm::WallKind::joined});
    measure<2>("gimp, musl, periodic sides", with, steps);
    measure<3>("in space: gimp, musl", in_space(c, small ? 4 : 10), std::max(1, steps / 20));
    if (json) std::ofstream(json) << results.dump(1) << '\n';
}
