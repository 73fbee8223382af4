#include "participants/dem/packing_start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/base/error.hpp"
#include "participants/dem/grain_file.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/size_grids.hpp"

namespace dem {
namespace {

//! Whether a grain of this radius lies within a column's container.
template <int D>
bool fits(Setup<D> const& setup, Vec<D> centre, double radius)
{
    for (Wall<D> const& wall : setup.walls) {
        if (facing_at_start(wall, centre).distance < radius) return false;
    }
    return true;
}

[[noreturn]] void fail_for_room(std::size_t placed, std::int64_t count)
{
    throw sluice::Error("dem: the column has room for " + std::to_string(placed) + " of its " + std::to_string(count) +
                        " grains only (needed: for all; a wall may run through it). Try other walls or sizes.");
}

//! The box around a column's container, of any height.
struct Footprint
{
    double left, right, front, back;
    double area;  //!< of the container [m2]; in the plane its width [m]
};

template <int D>
Footprint footprint_of(Config const& config)
{
    ColumnConfig const& c = *config.column;
    double const width = column_width(config), pi = std::numbers::pi;
    if (D == 2) return {0.0, width, 0.0, 0.0, width};
    switch (c.container) {
        case Container::box:
            return {0.0, width, 0.0, c.depth, width * c.depth};
        case Container::quarter:
            return {0.0, width, 0.0, width, pi / 4.0 * width * width};
        case Container::cylinder:
            break;
    }
    return {-width, width, -width, width, pi * width * width};
}

template <int D>
Vec<D> point(double x, double y, double up)
{
    if constexpr (D == 2)
        return {x, up};
    else
        return {x, y, up};
}

}  // namespace

template <int D>
Grains<D> loose_grid(Config const& config, Setup<D> const& setup)
{
    ColumnConfig const& column = *config.column;
    Random random(column.seed);
    Footprint const f = footprint_of<D>(config);
    double const width = f.right - f.left, depth = f.back - f.front, pitch = 1.02 * config.diameter_max;
    auto const cells = [&](double length) {
        return std::max<std::int64_t>(1, static_cast<std::int64_t>(length / pitch));
    };
    std::int64_t const columns = cells(width), rows = D == 2 ? 1 : cells(depth);
    double const cell_x = width / static_cast<double>(columns), cell_y = depth / static_cast<double>(rows);
    Grains<D> grains;
    std::int64_t misses = 0;
    for (std::int64_t k = 0; static_cast<std::int64_t>(grains.size()) < column.count; ++k) {
        double const x0 = f.left + static_cast<double>(k % columns) * cell_x;
        double const y0 = f.front + static_cast<double>(k / columns % rows) * cell_y;
        double const up0 = static_cast<double>(k / columns / rows) * pitch;
        double const radius = 0.5 * config.sizes.draw(random);
        double const x = x0 + random.uniform(radius, cell_x - radius);
        double const y = D == 2 ? 0.0 : y0 + random.uniform(radius, cell_y - radius);
        Vec<D> const centre = point<D>(x, y, up0 + random.uniform(radius, pitch - radius));
        bool const inside = fits(setup, centre, radius);
        if (inside) grains.add(centre, radius, config.density);
        misses = inside ? 0 : misses + 1;
        if (misses > 100 * columns * rows) fail_for_room(grains.size(), column.count);
    }
    return grains;
}

template <int D>
Grains<D> scattered(Config const& config, Setup<D> const& setup, double fraction, double scale)
{
    auto const count = static_cast<std::size_t>(config.column->count);
    Random random(config.column->seed);
    std::vector<double> radii(count);
    double volume = 0.0;
    for (double& radius : radii) {
        radius = 0.5 * scale * config.sizes.draw(random);
        volume += volume_of<D>(radius);
    }
    std::sort(radii.begin(), radii.end(), std::greater<>());
    Footprint const f = footprint_of<D>(config);
    double const height = volume / (fraction * f.area);
    SizeGrids<D> placed(point<D>(f.left, f.front, 0.0), point<D>(f.right, f.back, height), radii);
    std::vector<GrainConfig> grains;
    for (double const radius : radii) {
        constexpr int most_tries = 100000;  // at the fractions used here ten are usual
        Vec<D> centre{};
        for (int tries = 0;; ++tries) {
            if (tries == most_tries) fail_for_room(grains.size(), config.column->count);
            double const x = random.uniform(f.left + radius, f.right - radius);
            double const y = D == 2 ? 0.0 : random.uniform(f.front + radius, f.back - radius);
            centre = point<D>(x, y, random.uniform(radius, std::max(radius, height - radius)));
            if (fits(setup, centre, radius) && placed.is_free(centre, radius)) break;
        }
        placed.add(centre, radius);
        GrainConfig grain{};
        grain.position = in_space(centre);
        grain.radius = radius;
        grains.push_back(grain);
    }
    sort_in_space(grains);
    Config listed = config;
    listed.grains = std::move(grains);
    return listed_grains<D>(listed);
}

template <int D>
Grains<D> lattice(Config const& config, Setup<D> const& setup)
{
    Random random(config.column->seed);
    Footprint const f = footprint_of<D>(config);
    double const d = config.diameter_max, slack = 1.0 - 1e-9;
    double const row = D == 2 ? 0.0 : d * std::sqrt(3.0) / 2.0;
    double const layer = D == 2 ? d * std::sqrt(3.0) / 2.0 : d * std::sqrt(2.0 / 3.0);
    auto const sites = [&](double length, double pitch) {
        return pitch > 0.0 ? static_cast<std::int64_t>(length / pitch) + 2 : std::int64_t{1};
    };
    std::int64_t const columns = sites(f.right - f.left, d), rows = sites(f.back - f.front, row);
    Grains<D> grains;
    auto const count = static_cast<std::size_t>(config.column->count);
    for (std::int64_t level = 0; grains.size() < count; ++level) {
        std::size_t const before = grains.size();
        for (std::int64_t k = 0; k < columns * rows && grains.size() < count; ++k) {
            std::int64_t const across = k / columns;
            double const shift = 0.5 * static_cast<double>((across + level) % 2);
            double const x = f.left + (0.5 + shift + static_cast<double>(k % columns)) * d;
            double const y =
                f.front + 0.5 * d + (static_cast<double>(across) + static_cast<double>(level % 2) / 3.0) * row;
            Vec<D> const centre = point<D>(x, y, 0.5 * d + static_cast<double>(level) * layer);
            if (fits(setup, centre, 0.5 * d * slack))
                grains.add(centre, 0.5 * config.sizes.draw(random), config.density);
        }
        if (grains.size() == before && level > 0) fail_for_room(before, config.column->count);
    }
    return grains;
}

template Grains<2> loose_grid<2>(Config const&, Setup<2> const&);
template Grains<3> loose_grid<3>(Config const&, Setup<3> const&);
template Grains<2> scattered<2>(Config const&, Setup<2> const&, double, double);
template Grains<3> scattered<3>(Config const&, Setup<3> const&, double, double);
template Grains<2> lattice<2>(Config const&, Setup<2> const&);
template Grains<3> lattice<3>(Config const&, Setup<3> const&);

}  // namespace dem
