#include "participants/lbm/solids.hpp"

#include <algorithm>
#include <cmath>

#include "participants/lbm/disc_area.hpp"
#include "participants/lbm/mesh_solid.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/sphere_volume.hpp"

namespace lbm {
namespace {

//! Length that [low, high] and the cell [i, i + 1] share.
double shared(double low, double high, std::ptrdiff_t i)
{
    auto const at = static_cast<double>(i);
    return std::max(0.0, std::min(high, at + 1) - std::max(low, at));
}

//! Of all cells of rows, x fastest.
std::vector<double> fractions(std::span<RowCover const> rows, std::ptrdiff_t width)
{
    std::vector<double> all;
    all.reserve(rows.size() * static_cast<std::size_t>(width));
    for (RowCover const& row : rows)
        for (std::ptrdiff_t x = 0; x < width; ++x) all.push_back(row.covers(x) ? row.fraction(x - row.begin) : 0.0);
    return all;
}

//! Fractions of a disc in the plane, without padding; x fastest.
struct DiscCells
{
    DiscBox box;
    std::vector<double> fraction;

    DiscCells(double x, double y, double radius) : box(disc_box(x, y, radius))
    {
        RasterScratch scratch;
        std::vector<double> listed(most_listed(radius) + RowCover::slack);
        std::vector<RowCover> rows(static_cast<std::size_t>(box.height));
        rasterise(x, y, radius, box, listed, rows, scratch);
        fraction = fractions(rows, box.width);
    }
};

template <int D>
Patch<D> ball(std::array<double, 3> const& centre, double radius)
{
    Patch<D> patch;
    if constexpr (D == 2) {
        DiscCells disc(centre[0], centre[1], radius);
        patch.first = {disc.box.x0, disc.box.y0, 0};
        patch.size = {disc.box.width, disc.box.height, 1};
        patch.fraction = std::move(disc.fraction);
    } else {
        SphereBox const box = sphere_box(centre, radius);
        patch.first = box.first;
        patch.size = box.size;
        std::vector<double> listed(most_listed_of_sphere(radius) + RowCover::slack);
        std::vector<RowCover> rows(static_cast<std::size_t>(box.size[1] * box.size[2]));
        rasterise(centre, radius, box, listed, rows);
        patch.fraction = fractions(rows, box.size[0]);
    }
    patch.drag = drag_of_curvature<D>(1 / radius);
    return patch;
}

template <int D>
Patch<D> box(std::array<double, 3> const& centre, std::array<double, 3> const& size)
{
    Patch<D> patch;
    std::array<double, 3> low{0, 0, 0}, high{1, 1, 1};
    for (std::size_t k = 0; k < D; ++k) {
        low[k] = centre[k] - 0.5 * size[k];
        high[k] = centre[k] + 0.5 * size[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
        patch.first[k] = static_cast<std::ptrdiff_t>(std::floor(low[k]));
        patch.size[k] = static_cast<std::ptrdiff_t>(std::ceil(high[k])) - patch.first[k];
    }
    auto const share = [&](std::size_t k, std::ptrdiff_t i) { return shared(low[k], high[k], patch.first[k] + i); };
    for (std::ptrdiff_t z = 0; z < patch.size[2]; ++z)
        for (std::ptrdiff_t y = 0; y < patch.size[1]; ++y)
            for (std::ptrdiff_t x = 0; x < patch.size[0]; ++x)
                patch.fraction.push_back(share(0, x) * share(1, y) * share(2, z));
    patch.drag = flat_drag;
    return patch;
}

//! Through all cells along its axis.
Patch<3> cylinder(std::array<double, 3> const& centre, double radius, std::size_t axis, Extent const& cells)
{
    std::size_t const a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;  // the axes across, ascending
    DiscCells const disc(centre[a], centre[b], radius);
    Patch<3> patch;
    patch.first[a] = disc.box.x0, patch.first[b] = disc.box.y0;
    patch.size[a] = disc.box.width, patch.size[b] = disc.box.height, patch.size[axis] = cells[axis];
    for (std::ptrdiff_t z = 0; z < patch.size[2]; ++z)
        for (std::ptrdiff_t y = 0; y < patch.size[1]; ++y)
            for (std::ptrdiff_t x = 0; x < patch.size[0]; ++x) {
                Extent const at{x, y, z};
                patch.fraction.push_back(disc.fraction[static_cast<std::size_t>(at[b] * disc.box.width + at[a])]);
            }
    patch.drag = drag_of_curvature<2>(1 / radius);
    return patch;
}

std::vector<files::Triangle> in_cells(Solid const& solid, Config const& config)
{
    std::vector<files::Triangle> surface = solid.surface;
    for (files::Triangle& t : surface)
        for (files::Point& corner : t)
            for (std::size_t k = 0; k < 3; ++k) corner[k] = (corner[k] - config.origin[k]) / config.cell;
    return surface;
}

template <int D>
Patch<D> patch_of(Solid const& solid, Config const& config)
{
    std::array<double, 3> centre{}, size{};
    for (std::size_t k = 0; k < D; ++k) {
        centre[k] = (solid.centre[k] - config.origin[k]) / config.cell;
        size[k] = solid.size[k] / config.cell;
    }
    double const radius = solid.radius / config.cell;
    Patch<D> patch;
    if (solid.shape == Solid::Shape::box) patch = box<D>(centre, size);
    if (solid.shape == Solid::Shape::ball) patch = ball<D>(centre, radius);
    if constexpr (D == 3) {
        if (solid.shape == Solid::Shape::cylinder) patch = cylinder(centre, radius, solid.axis, config.cells());
        if (solid.shape == Solid::Shape::mesh) patch = mesh_patch(in_cells(solid, config), config.cells());
    }
    std::copy_n(centre.begin(), D, patch.centre.begin());
    constexpr double rounding = 1e-12;  // of a cell: of a face that lies between cells, and no solid
    std::ranges::replace_if(
        patch.fraction, [](double f) { return f < rounding; }, 0.0);
    return patch;
}

}  // namespace

template <int D>
std::vector<Patch<D>> patches_of(Config const& config)
{
    std::vector<Patch<D>> patches;
    for (Solid const& solid : config.solids) patches.push_back(patch_of<D>(solid, config));
    return patches;
}

template std::vector<Patch<2>> patches_of<2>(Config const&);
template std::vector<Patch<3>> patches_of<3>(Config const&);

}  // namespace lbm
