//! Speed of the fluid solver beside what the machine's memory allows. Prints a table; `--json FILE` writes a list of
//! {case, metric, value, unit, against, ratio}. `--small`: a smoke run.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "participants/lbm/solver.hpp"
#include "tests/bench/bent_channel.hpp"
#include "tests/participants/lbm/plain_lattice.hpp"

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Size
{
    std::ptrdiff_t nx, ny;
    int discs, steps;
};

nlohmann::json results = nlohmann::json::array();

//! ratio = value / what it stands against.
void note(char const* name, std::string const& metric, double value, char const* unit, char const* against,
          double ratio)
{
    std::printf("%-34s %-24s %10.4g %-8s %5.1f %% of %s\n", name, metric.c_str(), value, unit, 100 * ratio, against);
    std::fflush(stdout);
    results.push_back(
        {{"case", name}, {"metric", metric}, {"value", value}, {"unit", unit}, {"against", against}, {"ratio", ratio}});
}

//! Every population read and written once.
template <int D>
constexpr double bytes_per_update(lbm::Precision precision)
{
    return 2.0 * lbm::Lattice<D>::directions * static_cast<double>(lbm::bytes_of(precision));
}

constexpr lbm::Precision precisions[] = {lbm::Precision::float64, lbm::Precision::float32};
char const* name_of(lbm::Precision precision)
{
    return precision == lbm::Precision::float64 ? "double" : "single";
}
std::string metric(int threads, lbm::Precision precision)
{
    return std::string("speed, ") + (threads == 1 ? "1 thread, " : "2 threads, ") + name_of(precision);
}

//! Best rate of a[i] = s a[i] over nine arrays far larger than the caches [B/s]: what an in-place step can reach.
template <int D>
double in_place_bandwidth(int threads, lbm::Extent const& cells)
{
    sluice::Team team(threads);
    lbm::Layout const layout(cells);
    lbm::Populations<D> populations(layout, lbm::Precision::float64, team);  // the solver's own arrays: huge pages
    lbm::Rows<D, double> const memory(populations);
    std::ptrdiff_t const piece = cells[2] * cells[1] * cells[0];
    double const bytes = static_cast<double>(lbm::Lattice<D>::directions) * static_cast<double>(piece) * sizeof(double);
    double best = 0;
    for (int repeat = 0; repeat < 6; ++repeat) {
        auto const start = Clock::now();
        team.share(piece, 1 << 14, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::size_t q = 0; q < lbm::Lattice<D>::directions; ++q) {
                double* const a = memory.row(q, 0);
                for (std::ptrdiff_t i = begin; i < end; ++i) a[i] = a[i] * 1.0000001;
            }
        });
        best = std::max(best, 2.0 * bytes / seconds_since(start));
    }
    return best;
}

lbm::Config config(Size const& size, int threads, double smagorinsky,
                   lbm::Precision precision = lbm::Precision::float64)
{
    lbm::Config c;
    c.precision = precision;
    c.cell = c.step = c.density = 1;
    c.size = {static_cast<double>(size.nx), static_cast<double>(size.ny)};
    c.viscosity = 0.01;
    c.smagorinsky = smagorinsky;
    c.hydrodynamic_radius = 0.85;
    c.threads = threads;
    return c;
}

//! A packed column at the left wall; its discs fall and spin slowly. r = 0.85 R, R is half the pitch at most.
struct Column
{
    std::vector<double> position, velocity, spin, radius;

    //! 2.4 times as high as wide, R as large as the lattice allows: 2028 discs in 3500 x 1700 cells have R = 12.2 cells
    //! on average.
    explicit Column(Size const& size)
    {
        int const across = std::max(1, static_cast<int>(std::sqrt(size.discs / 2.4)));
        int const up = (size.discs + across - 1) / across;
        fill(size.discs, across, 0.98 * static_cast<double>(size.ny) / (up + 1), 0.03);
    }
    //! R = pitch (1/2 - spread) to pitch/2.
    Column(int discs, int across, double pitch, double spread) { fill(discs, across, pitch, spread); }

    void fill(int discs, int across, double pitch, double spread)
    {
        for (int i = 0; i < discs; ++i) {
            position.push_back(pitch * (0.6 + i % across));
            position.push_back(pitch * (0.6 + i / across));
            velocity.push_back(1e-3 * std::sin(i));
            velocity.push_back(-1e-3);
            spin.push_back(1e-4 * std::cos(i));
            radius.push_back(0.5 * pitch * (1 - spread + spread * std::sin(7.0 * i)));
        }
    }
    void move()
    {
        for (std::size_t k = 0; k < position.size(); ++k) position[k] += velocity[k];
    }
    lbm::BodiesView view() const { return {position, velocity, spin, radius}; }
};

//! Updates of a cell a second, the best of four blocks of steps; `prepare()` before each step.
template <class AnySolver, class Prepare>
double best_rate(AnySolver& solver, double cells, int steps, Prepare&& prepare)
{
    double best = 0;
    for (int block = 0; block < 4; ++block) {
        auto const start = Clock::now();
        for (int k = 0; k < steps; ++k) {
            prepare();
            solver.step();
        }
        best = std::max(best, steps * cells / seconds_since(start));
    }
    return best;
}

//! Updates of a cell a second, whole steps: area fractions, boundaries, collision, streaming, force sums. No column: no
//! discs.
double rate(lbm::Config const& c, Size const& size, char const* name = nullptr, Column column = {0, 1, 1, 0})
{
    bool const grains = name != nullptr;
    lbm::Solver<2> solver(c);
    double const best = best_rate(solver, static_cast<double>(size.nx * size.ny), size.steps, [&] {
        if (!grains) return;
        column.move();
        solver.set_bodies(column.view());
    });
    if (grains)
        note(name, "cells near grains", 100 * solver.share().covered_cells, "%", "all cells",
             solver.share().covered_cells);
    return best;
}

lbm::Config box(lbm::Extent const& cells, lbm::Precision precision)
{
    lbm::Config c;
    c.precision = precision;
    c.dimension = 3;
    c.cell = c.step = c.density = 1;
    std::copy(cells.begin(), cells.end(), c.size.begin());
    c.viscosity = 0.01;
    c.collision = lbm::Operator::trt;
    return c;
}

//! The same in space: a box of cells, with `spheres` each way or none.
double rate_in_space(lbm::Extent const& cells, int threads, lbm::Precision precision, lbm::Operator collision,
                     double smagorinsky, int spheres, lbm::Surface surface)
{
    lbm::Config c = box(cells, precision);
    c.surface = surface;
    c.collision = collision;
    c.smagorinsky = smagorinsky;
    c.threads = threads;
    lbm::Solver<3> solver(c);
    std::vector<double> position, velocity, spin, radius;
    double const pitch = static_cast<double>(std::min({cells[0], cells[1], cells[2]})) / (spheres + 1);
    for (int i = 0; i < spheres * spheres * spheres; ++i) {
        for (int const k : {i % spheres, i / spheres % spheres, i / spheres / spheres})
            position.push_back(pitch * (k + 1) + 0.3 * std::sin(7.0 * i + k));
        velocity.insert(velocity.end(), {1e-3 * std::sin(i), 1e-3 * std::cos(i), -1e-3});
        spin.insert(spin.end(), {1e-4, 1e-4 * std::cos(i), 0});
        radius.push_back(0.45 * pitch);
    }
    return best_rate(solver, static_cast<double>(cells[0] * cells[1] * cells[2]), 10, [&] {
        for (std::size_t i = 0; i < position.size(); ++i) position[i] += velocity[i];
        solver.set_bodies({position, velocity, spin, radius});
    });
}

//! Time and memory of a box of solid with a tenth of fluid in it, by those of the box full of fluid; in turn, medians
//! of the ratios. Between rows of the table, and when these tell the loads on solids at each step.
template <int D>
void show_tenth(char const* name, lbm::Config const& box, lbm::Config const& with_solids, double fluid, int steps)
{
    constexpr std::size_t blocks = 7;
    lbm::Solver<D> full(box), cut(with_solids);
    auto const seconds = [](auto& solver, int count, lbm::SolidLoads on_solids) {
        auto const start = Clock::now();
        for (int k = 0; k < count; ++k) solver.step(on_solids);
        return seconds_since(start) / count;
    };
    std::vector<double> without, with;  // loads
    for (std::size_t block = 0; block < blocks; ++block) {
        double const whole = seconds(full, steps, lbm::SolidLoads::left_out);
        without.push_back(seconds(cut, 10 * steps, lbm::SolidLoads::left_out) / whole);
        with.push_back(seconds(cut, 10 * steps, lbm::SolidLoads::found) / whole);
    }
    auto const precision = std::string(", ") + name_of(box.precision);
    auto const show = [&](char const* what, double share) {
        note(name, what + precision, share, "", "the fluid's share", share / fluid);
    };
    auto const median = [](std::vector<double>& ratios) {
        std::ranges::nth_element(ratios, ratios.begin() + blocks / 2);
        return ratios[blocks / 2];
    };
    show("time, by full box", median(without));
    show("time with loads, by full box", median(with));
    show("memory, by full box", static_cast<double>(cut.bytes()) / static_cast<double>(full.bytes()));
}

constexpr double tenth = 0.1;

void show_tenth_in_plane(Size const& size, lbm::Precision precision)
{
    lbm::Config const box = config(size, 1, 0.1, precision);
    lbm::Config bent = box;
    BentChannel<2> const channel(bent.cells(), tenth);
    channel.add_to(bent);
    show_tenth<2>("tenth of fluid, bent channel", box, bent, channel.fluid(), size.steps / 5);
}

//! The last one's walls lie within cells.
void show_tenths_in_space(std::ptrdiff_t side, lbm::Precision precision)
{
    lbm::Config const full = box({side, side, side}, precision);
    auto const show = [&](char const* name, auto&& add_solids) {
        lbm::Config scene = full;
        double const fluid = add_solids(scene);
        show_tenth<3>(name, full, scene, fluid, 2);
    };
    auto const add_bent = [](lbm::Config& c, double within) {
        BentChannel<3> const channel(c.cells(), tenth, within);
        channel.add_to(c);
        return channel.fluid();
    };
    show("D3Q19 tenth of fluid, layer", [](lbm::Config& c) { return add_layer(c, tenth); });
    show("D3Q19 tenth of fluid, along x", [](lbm::Config& c) { return add_straight_duct(c, tenth); });
    show("D3Q19 tenth of fluid, bent duct", [&](lbm::Config& c) { return add_bent(c, 0); });
    show("D3Q19 tenth of fluid, basin", [](lbm::Config& c) { return add_basin<3>(c, tenth); });
    show("D3Q19 tenth of fluid, cut cells", [&](lbm::Config& c) { return add_bent(c, 0.3); });
}

//! The oracle of the tests: two grids, one cell at a time, moments by matrix.
double plain_rate(lbm::Config const& c, Size const& size)
{
    PlainLattice plain(c);
    auto const start = Clock::now();
    plain.step({});
    return static_cast<double>(size.nx * size.ny) / seconds_since(start);
}

}  // namespace

int main(int argc, char** argv)
{
    Size size{3500, 1700, 2028, 25}, immersed{1800, 600, 1000, 60};  // the second as configs/immersed_column.yaml
    lbm::Extent space{192, 160, 160}, cube{128, 128, 128};           // 750, 320 MB
    std::ptrdiff_t side = 256;                                       // of the box with a tenth of fluid
    char const* json = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--small") == 0)
            size = {350, 170, 40, 10}, immersed.steps = 2, side = 48, space = cube = {24, 24, 24};
        if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) json = argv[++i];
    }
    double roof[3] = {};  // [B/s]
    for (int threads : {1, 2}) {
        roof[threads] = in_place_bandwidth<2>(threads, {size.nx, size.ny, 1});
        note("memory, in-place update", threads == 1 ? "rate, 1 thread" : "rate, 2 threads", roof[threads] / 1e9,
             "GB/s", "itself", 1);
    }
    for (int threads : {1, 2})
        for (auto const precision : precisions) {
            auto const show = [&](char const* name, double updates) {
                note(name, metric(threads, precision), updates / 1e6, "MLUPS", "roofline",
                     updates * bytes_per_update<2>(precision) / roof[threads]);
            };
            auto const of = [&](Size const& s, double les) { return config(s, threads, les, precision); };
            show("MRT", rate(of(size, 0), size));
            show("MRT + LES", rate(of(size, 0.1), size));
            auto central = of(size, 0);
            central.collision = lbm::Operator::central;
            show("central moments", rate(central, size));
            char const* const tall = "MRT + LES + discs, whole step";
            show(tall, rate(of(size, 0.1), size, tall, Column(size)));
            char const* const cut = "MRT + LES + discs, interpolated, whole step";
            auto links = of(size, 0.1);
            links.surface = lbm::Surface::interpolated;
            show(cut, rate(links, size, cut, Column(size)));
            char const* const packed = "immersed column, 1000 discs";
            show(packed, rate(of(immersed, 0.1), immersed, packed, Column(immersed.discs, 35, 14.6, 0.1)));
        }
    for (int threads : {1, 2}) {
        double const limit = in_place_bandwidth<3>(threads, space);
        note("D3Q19 memory, in-place update", threads == 1 ? "rate, 1 thread" : "rate, 2 threads", limit / 1e9, "GB/s",
             "itself", 1);
        for (auto const precision : precisions) {
            auto const show = [&](char const* name, lbm::Extent const& cells, lbm::Operator collision, double les,
                                  int spheres, lbm::Surface surface = lbm::Surface::covered) {
                double const updates = rate_in_space(cells, threads, precision, collision, les, spheres, surface);
                note(name, metric(threads, precision), updates / 1e6, "MLUPS", "roofline",
                     updates * bytes_per_update<3>(precision) / limit);
            };
            show("D3Q19 TRT, 192 x 160 x 160", space, lbm::Operator::trt, 0, 0);
            show("D3Q19 TRT, 128 cells each way", cube, lbm::Operator::trt, 0, 0);
            show("D3Q19 MRT, 192 x 160 x 160", space, lbm::Operator::mrt, 0, 0);
            show("D3Q19 MRT + LES, 192 x 160 x 160", space, lbm::Operator::mrt, 0.1, 0);
            show("D3Q19 central moments, 192 x 160 x 160", space, lbm::Operator::central, 0, 0);
            show("D3Q19 TRT + spheres, whole step", cube, lbm::Operator::trt, 0, 8);
            show("D3Q19 TRT + spheres, interpolated, whole step", cube, lbm::Operator::trt, 0, 8,
                 lbm::Surface::interpolated);
        }
    }
    for (auto const precision : precisions) {
        show_tenth_in_plane(size, precision);
        show_tenths_in_space(side, precision);
    }
    double const plain = plain_rate(config(size, 1, 0.1), size);
    note("plain two-grid lattice, MRT + LES", metric(1, precisions[0]), plain / 1e6, "MLUPS", "roofline",
         plain * bytes_per_update<2>(precisions[0]) / roof[1]);
    if (json) std::ofstream(json) << results.dump(1) << '\n';
}
