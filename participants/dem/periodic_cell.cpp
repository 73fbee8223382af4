#include "participants/dem/periodic_cell.hpp"

#include <algorithm>
#include <cmath>

namespace dem {

template <int D>
Cell<D> cell_at_start(Periodic<D> const& periodic) noexcept
{
    Cell<D> cell;
    cell.extent = periodic.extent;
    Shear const& shear = periodic.shear;
    if (periodic.is_sheared()) cell.slide = shear.rate * component(cell.extent, shear.across);
    place_images(periodic, cell);
    return cell;
}

template <int D>
void place_images(Periodic<D> const& periodic, Cell<D>& cell) noexcept
{
    std::array<Vec<D>, D> edge, rate;
    for (int k = 0; k < D; ++k) {
        edge[static_cast<std::size_t>(k)] = edge_of(periodic, cell, k);
        rate[static_cast<std::size_t>(k)] = edge_rate_of(periodic, cell, k);
    }
    for (std::size_t image = 0; image < image_count<D>; ++image) {
        Image<D>& at = cell.images[image];
        at.shift = at.velocity = {};
        for (int k = 0; k < D; ++k) {
            double const n = image_number(image, k);
            at.shift += n * edge[static_cast<std::size_t>(k)];
            at.velocity += n * rate[static_cast<std::size_t>(k)];
        }
    }
}

template <int D>
void set_as_built(Periodic<D> const& periodic, Cell<D>& cell) noexcept
{
    if (!periodic.is_sheared()) return;
    cell.offset = cell.built_offset;
    component<D>(cell.extent, periodic.shear.across) = cell.built_height;
    place_images(periodic, cell);
}

template <int D>
void advance_cell(Periodic<D> const& periodic, Cell<D>& cell, double dt, double stress) noexcept
{
    if (!periodic.is_sheared()) return;
    Shear const& shear = periodic.shear;
    double& height = component<D>(cell.extent, shear.across);
    cell.growth = shear.pressure > 0.0
                      ? std::clamp(stress - shear.pressure, -shear.pressure, shear.pressure) / shear.impedance
                      : 0.0;
    cell.slide = shear.rate * (height + 0.5 * dt * cell.growth);
    height += dt * cell.growth;
    cell.offset += dt * cell.slide;
    cell.strain += dt * shear.rate;
    place_images(periodic, cell);
}

template <int D>
double pulling_power(Periodic<D> const& periodic, Cell<D> const& cell) noexcept
{
    if (!periodic.is_sheared()) return 0.0;
    int const across = periodic.shear.across;
    return dot(cell.pull[static_cast<std::size_t>(across)], edge_rate_of(periodic, cell, across));
}

template <int D>
double moved_since_built(Periodic<D> const& periodic, Cell<D> const& cell) noexcept
{
    if (!periodic.is_sheared()) return 0.0;
    return std::hypot(cell.offset - cell.built_offset,
                      component(cell.extent, periodic.shear.across) - cell.built_height);
}

template <int D>
void gather_pull(Cell<D>& cell) noexcept
{
    for (int k = 0; k < D; ++k) {
        Vec<D> sum;
        for (std::size_t image = 0; image < image_count<D>; ++image)
            sum += static_cast<double>(image_number(image, k)) * cell.images[image].through;
        cell.pull[static_cast<std::size_t>(k)] = sum;
    }
}

template Cell<2> cell_at_start<2>(Periodic<2> const&) noexcept;
template Cell<3> cell_at_start<3>(Periodic<3> const&) noexcept;
template void place_images<2>(Periodic<2> const&, Cell<2>&) noexcept;
template void place_images<3>(Periodic<3> const&, Cell<3>&) noexcept;
template void set_as_built<2>(Periodic<2> const&, Cell<2>&) noexcept;
template void set_as_built<3>(Periodic<3> const&, Cell<3>&) noexcept;
template void advance_cell<2>(Periodic<2> const&, Cell<2>&, double, double) noexcept;
template void advance_cell<3>(Periodic<3> const&, Cell<3>&, double, double) noexcept;
template double pulling_power<2>(Periodic<2> const&, Cell<2> const&) noexcept;
template double pulling_power<3>(Periodic<3> const&, Cell<3> const&) noexcept;
template double moved_since_built<2>(Periodic<2> const&, Cell<2> const&) noexcept;
template double moved_since_built<3>(Periodic<3> const&, Cell<3> const&) noexcept;
template void gather_pull<2>(Cell<2>&) noexcept;
template void gather_pull<3>(Cell<3>&) noexcept;

}  // namespace dem
