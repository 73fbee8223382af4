#include "participants/dem/periodic_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/dem/neighbours.hpp"

namespace dem {
namespace {

//! The images of grains that come near the cell, behind the grains themselves, and whose they are.
template <int D>
struct Copies
{
    Grains<D> all;  //!< places only
    std::vector<std::uint32_t> of, image;
};

template <int D>
Copies<D> copies_near(Setup<D> const& setup, State<D> const& state, double largest_radius)
{
    Periodic<D> const& periodic = setup.periodic;
    Cell<D> const& cell = state.cell;
    Copies<D> copies;
    copies.all.place = state.grains.place;
    for (std::uint32_t image = 0; image < image_count<D>; ++image) {
        if (image == home<D> || !has_image(periodic, image)) continue;
        for (std::uint32_t i = 0; i < state.grains.size(); ++i) {
            Place<D> place = state.grains.place[i];
            place.centre += cell.images[image].shift;
            double const margin = place.radius + largest_radius + setup.skin;
            bool near = true;
            for (int k = 0; k < D; ++k) {
                double const x = component(place.centre - periodic.low, k);
                near = near && (!periodic.axis[static_cast<std::size_t>(k)] ||
                                (x >= -margin && x <= component(cell.extent, k) + margin));
            }
            if (!near) continue;
            copies.all.place.push_back(place);
            copies.of.push_back(i);
            copies.image.push_back(image);
        }
    }
    return copies;
}

template <int D>
void check_size(Setup<D> const& setup, State<D> const& state, double largest_radius)
{
    for (int k = 0; k < D; ++k)
        sluice::require(!setup.periodic.axis[static_cast<std::size_t>(k)] ||
                            component(state.cell.extent, k) >= shortest_edge(2.0 * largest_radius, setup.skin),
                        [&] {
                            return sluice::Error(
                                "dem: the periodic cell is " + std::to_string(component(state.cell.extent, k)) +
                                    " m along " + "xyz"[k] + " at t = " + std::to_string(state.time) +
                                    " s (must be at least twice the largest diameter and the reach of the list, " +
                                    std::to_string(shortest_edge(2.0 * largest_radius, setup.skin)) +
                                    " m). Try more grains.",
                                sluice::Exit::numerical);
                        });
}

}  // namespace

template <int D>
void put_back(Periodic<D> const& periodic, State<D>& state)
{
    Cell<D>& cell = state.cell;
    Shear const& shear = periodic.shear;
    if (periodic.is_sheared()) {  // the nearest of the images above
        double const length = component(cell.extent, shear.along);
        cell.offset -= length * std::round(cell.offset / length);
        cell.built_offset = cell.offset;
        cell.built_height = component(cell.extent, shear.across);
        place_images(periodic, cell);
    }
    Grains<D>& g = state.grains;
    for (std::size_t i = 0; i < g.size(); ++i) {
        Vec<D> const before = g.place[i].centre;
        Vec<D> sped;
        bool crosses = false;
        auto const along = [&](int k) {
            if (!periodic.axis[static_cast<std::size_t>(k)]) return;
            double const n = std::floor(component(g.place[i].centre - periodic.low, k) / component(cell.extent, k));
            if (n == 0.0) return;
            g.place[i].centre -= n * edge_of(periodic, cell, k);
            sped -= n * edge_rate_of(periodic, cell, k);
            crosses = true;
        };
        if (periodic.is_sheared()) along(shear.across);  // moves it along the other axis, too
        for (int k = 0; k < D; ++k)
            if (!periodic.is_sheared() || k != shear.across) along(k);
        if (!crosses) continue;
        g.motion[i].velocity += sped;
        g.half[i].velocity += sped;
        state.crossings.push_back({static_cast<std::uint32_t>(i), g.place[i].centre - before, sped});
    }
}

template <int D>
void find_periodic_pairs(Setup<D> const& setup, State<D> const& state, std::vector<std::uint32_t>& first,
                         std::vector<std::uint32_t>& other, std::vector<std::uint32_t>& image)
{
    std::size_t const count = state.grains.size();
    double largest = 0.0;
    for (auto const& place : state.grains.place) largest = std::max(largest, place.radius);
    check_size(setup, state, largest);
    Copies<D> const copies = copies_near(setup, state, largest);
    std::vector<std::uint32_t> near_first, near;
    find_pairs(copies.all, setup.skin, near_first, near);
    first.assign(count + 1, 0);
    other.clear();
    image.clear();
    std::vector<std::pair<std::uint32_t, std::uint32_t>> row;  // (other, image)
    for (std::uint32_t i = 0; i < count; ++i) {
        row.clear();
        for (std::uint32_t slot = near_first[i]; slot < near_first[i + 1]; ++slot) {
            std::size_t const j = near[slot];
            if (j < count)
                row.emplace_back(near[slot], home<D>);
            else if (copies.of[j - count] > i)  // the pair is seen from both sides
                row.emplace_back(copies.of[j - count], copies.image[j - count]);
        }
        std::sort(row.begin(), row.end());
        for (auto const& [j, seen] : row) {
            other.push_back(j);
            image.push_back(seen);
        }
        first[i + 1] = static_cast<std::uint32_t>(other.size());
    }
}

template void put_back<2>(Periodic<2> const&, State<2>&);
template void put_back<3>(Periodic<3> const&, State<3>&);
template void find_periodic_pairs<2>(Setup<2> const&, State<2> const&, std::vector<std::uint32_t>&,
                                     std::vector<std::uint32_t>&, std::vector<std::uint32_t>&);
template void find_periodic_pairs<3>(Setup<3> const&, State<3> const&, std::vector<std::uint32_t>&,
                                     std::vector<std::uint32_t>&, std::vector<std::uint32_t>&);

}  // namespace dem
