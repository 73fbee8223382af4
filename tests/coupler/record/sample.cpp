//! Writes a small run with closed-form values that readback.py knows: points whose number changes and is 0 once, a 2D
//! lattice, tables, archives, traces. Usage: record_sample FOLDER

#include <cstdio>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/collection.hpp"
#include "coupler/record/image_series.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/table.hpp"
#include "coupler/record/trace.hpp"

namespace {

using namespace sluice;

struct Grains
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, angular_velocity, radius;
};

//! Frame k has 5 k points (0 at k = 0); id 10 k + i, position (i, k/4), velocity (-k, i/8), spin -i, radius 1 + i.
Grains grains_of(std::size_t frame)
{
    Grains g;
    auto const k = static_cast<double>(frame);
    for (std::size_t n = 0; n < 5 * frame; ++n) {
        auto const i = static_cast<double>(n);
        g.id.push_back(static_cast<std::int64_t>(10 * frame + n));
        g.position.insert(g.position.end(), {i, k / 4});
        g.velocity.insert(g.velocity.end(), {-k, i / 8});
        g.angular_velocity.push_back(-i);
        g.radius.push_back(1 + i);
    }
    return g;
}

constexpr std::size_t nx = 7, ny = 4;

//! velocity (x + k, y), pressure x + nx y + k in cell (x, y) of frame k.
void water_of(std::size_t frame, std::vector<float>& velocity, std::vector<float>& pressure)
{
    velocity.clear();
    pressure.clear();
    for (std::size_t y = 0; y < ny; ++y)
        for (std::size_t x = 0; x < nx; ++x) {
            velocity.insert(velocity.end(), {static_cast<float>(x + frame), static_cast<float>(y)});
            pressure.push_back(static_cast<float>(x + nx * y + frame));
        }
}

void write_grains(std::filesystem::path const& folder, std::size_t frames)
{
    PointSeries series(folder, "grains");
    PointSeries single(folder, "grains_single", Precision::float32);
    ArchiveFact const facts[] = {{"scene_hash", std::string("0123abcd")}, {"version", std::string("0.1.0")}};
    Archive archive(folder / "grains.h5", facts);
    std::string const headers[] = {"time [s]", "run_out [m]"};
    Table table(folder / "grains.csv", headers);
    for (std::size_t k = 0; k < frames; ++k) {
        Grains const g = grains_of(k);
        double const time = 0.1 * static_cast<double>(k);
        PointColumn const columns[] = {{"position", "m", 2, g.position},
                                       {"velocity", "m/s", 2, g.velocity},
                                       {"angular_velocity", "rad/s", 1, g.angular_velocity},
                                       {"radius", "m", 1, g.radius}};
        series.append(time, g.id, columns);
        single.append(time, g.id, columns);
        std::size_t const n = g.id.size();
        ArchiveDataset const datasets[] = {{"id", "", std::span(g.id), {n}},
                                           {"position", "m", std::span(g.position), {n, 2}},
                                           {"velocity", "m/s", std::span(g.velocity), {n, 2}},
                                           {"angular_velocity", "rad/s", std::span(g.angular_velocity), {n}},
                                           {"radius", "m", std::span(g.radius), {n}}};
        archive.append(time, datasets);
        table.append(std::vector{time, time / 3});
    }
    archive.close();
}

void write_water(std::filesystem::path const& folder, std::size_t frames)
{
    ImageSeries series(folder, "water", {{-1, 0.5, 0}, {0.5, 0.25, 1}, {nx, ny, 0}});
    ArchiveFact const facts[] = {{"origin", std::vector{-1.0, 0.5}}, {"spacing", std::vector{0.5, 0.25}}};
    Archive archive(folder / "water.h5", facts);
    std::string const headers[] = {"time [s]", "max_speed [m/s]"};
    Table table(folder / "water.csv", headers);
    std::vector<float> velocity, pressure;
    for (std::size_t k = 0; k < frames; ++k) {
        water_of(k, velocity, pressure);
        double const time = 0.1 * static_cast<double>(k);
        CellColumn const columns[] = {{"velocity", "m/s", 2, velocity}, {"pressure", "Pa", 1, pressure}};
        series.append(time, columns);
        ArchiveDataset const datasets[] = {
            {"velocity", "m/s", std::span<float const>(velocity), {ny, nx, 2}, Pack::deflate},
            {"pressure", "Pa", std::span<float const>(pressure), {ny, nx}, Pack::deflate}};
        archive.append(time, datasets);
        table.append(std::vector{time, static_cast<double>(k)});
    }
    archive.close();
}

void write_run(std::filesystem::path const& folder)
{
    constexpr std::size_t frames = 4;
    write_grains(folder, frames);
    write_water(folder, frames);
    std::filesystem::path const parts[] = {folder / "grains.pvd", folder / "water.pvd"};
    merge_collections(parts, folder / "all.pvd");
    TablePart const tables[] = {{"grains", folder / "grains.csv"}, {"water", folder / "water.csv"}};
    merge_tables(tables, folder / "series.csv");
    ArchiveLink const links[] = {{"grains", "grains.h5"}, {"water", "water.h5"}};
    link_archives(folder / "archive.h5", links);
    Trace grains("grains"), water("water");
    for (std::uint64_t window = 0; window < 100; ++window) {
        auto const begin = static_cast<double>(window) * 1e-3;
        grains.add(window, Activity::compute, begin, begin + 0.6e-3);
        grains.add(window, Activity::wait, begin + 0.6e-3, begin + 1e-3);
        water.add(window, Activity::compute, begin, begin + 0.9e-3);
        water.add(window, Activity::exchange, begin + 0.9e-3, begin + 1e-3);
    }
    grains.write(folder / "grains.trace.json");
    water.write(folder / "water.trace.json");
    std::filesystem::path const traces[] = {folder / "grains.trace.json", folder / "water.trace.json"};
    merge_traces(traces, folder / "trace.json");
}

}  // namespace

int main(int argc, char** argv)
{
    try {
        write_run(argc > 1 ? argv[1] : "sample_run");
        return 0;
    } catch (Error const& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return static_cast<int>(error.exit());
    }
}
