#pragma once

#include "participants/dem/packing.hpp"
#include "participants/dem/solver.hpp"

//! How the grains of a column lie before they settle. All throw sluice::Error (config) if they find no room.
namespace dem {

//! Whether a column is poured from scattered grains. From a grid otherwise: for wide laws it would be far too high, and
//! spheres of nearly one size would fall as the stacks in which they hang, and stay so.
inline bool is_scattered(Config const& config)
{
    bool const alike = config.diameter_max < 1.2 * config.diameter_min;
    return !config.sizes.is_uniform_number() || (config.dimension == 3 && alike);
}

//! On a grid of cells of one largest diameter, each at a random place in its cell; lowest rows first. Cells that are
//! not wholly within the container stay empty.
template <int D>
Grains<D> loose_grid(Config const& config, Setup<D> const& setup);

//! Of scattered grains; well below what random placing can reach: 0.547 and 0.384.
constexpr double scattered_fraction(int dimension)
{
    return dimension == 2 ? 0.40 : 0.25;
}

//! At random places without overlap, the largest first, in a container as high as this packing fraction makes it.
//! `scale`: of their radii. Sorted in space.
template <int D>
Grains<D> scattered(Config const& config, Setup<D> const& setup, double fraction, double scale = 1.0);

//! On rows of triangles, layers as close as they can be, of the largest diameter; lowest first.
template <int D>
Grains<D> lattice(Config const& config, Setup<D> const& setup);

//! Scattered, then grown to their size while they push each other apart, without weight and friction, under a lid at
//! the column's height. Where they jam before they are grown, for walls keep them apart, the lid gives way.
template <int D>
Grains<D> grown(Config const& config, Setup<D> const& setup, Progress const& progress);

//! `rate` [1/s]: a step with an external force -rate m v on every grain.
template <int D>
void step_with_drag(Solver<D>& solver, double dt, double rate)
{
    Grains<D>& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i)
        g.external[i] = {(-rate * g.mass[i]) * g.motion[i].velocity, (-rate * g.inertia[i]) * g.motion[i].spin};
    solver.step(dt);
}

}  // namespace dem
