#include <algorithm>
#include <cmath>
#include <cstdio>

#include "participants/dem/packing_start.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/touches.hpp"

namespace dem {
namespace {

constexpr double allowed_overlap = 1e-4;  //!< over Ri + Rj, when growth is over [-]
constexpr int stages = 60;
constexpr double lift = 1.003;  //!< of the lid, where the grains have jammed before the column is full

//! Over Ri + Rj, at a wall over R [-].
template <int D>
double largest_overlap(Solver<D> const& solver)
{
    double largest = 0.0;
    each_touch(solver.setup(), solver.state(), [&](Touch<D> const& touch) {
        bool const wall = touch.second >= solver.grains().size();
        largest = std::max(largest, touch.overlap / (wall ? 0.5 * touch.reach : touch.reach));
    });
    return largest;
}

//! No weight, no friction, strong dashpots, and a lid.
template <int D>
Setup<D> weightless(Config const& config, Setup<D> const& setup, double height)
{
    ContactConfig soft = config.contact;
    soft.friction = soft.rolling_friction = 0.0;
    soft.rolling = Rolling::none;
    soft.damping_ratio = 0.5;
    soft.may_pull = false;
    Setup<D> all = setup;
    all.gravity = {};
    all.law = contact_law(soft);
    all.features.rolling = Rolling::none;
    for (Wall<D>& wall : all.walls) wall.law = all.law;
    Vec<D> top{}, down{};
    component<D>(top, D - 1) = height;
    component<D>(down, D - 1) = -1.0;
    all.walls.push_back({.name = "lid", .shape = Plane<D>{top, down}, .motion = {}, .law = all.law});
    return all;
}

//! Lets grains push each other apart until they overlap by less than `enough`, or for `most` steps. Returns by how
//! much.
template <int D>
double part(Setup<D> const& setup, Grains<D>& grains, double t_c, double enough, int most)
{
    Solver<D> solver(setup, std::move(grains));
    double overlap = largest_overlap(solver);
    for (int n = 0; n < most && overlap > enough; ++n) {
        step_with_drag(solver, t_c / 20.0, 0.5 / t_c);
        if (n % 20 == 19) overlap = largest_overlap(solver);
    }
    grains = solver.grains();
    return overlap;
}

//! The same places, higher by a factor, radii by another.
template <int D>
Grains<D> stretched(Grains<D> const& grains, double up_factor, double radius_factor, double density)
{
    Grains<D> all;
    for (auto [centre, radius] : grains.place) {
        component<D>(centre, D - 1) *= up_factor;
        all.add(centre, radius * radius_factor, density);
    }
    return all;
}

//! t_c of the smallest grains there are [s].
template <int D>
double contact_time_among(Config const& config, Grains<D> const& grains)
{
    double lightest = INFINITY, smallest = INFINITY;
    for (std::size_t i = 0; i < grains.size(); ++i) {
        lightest = std::min(lightest, grains.mass[i]);
        smallest = std::min(smallest, grains.place[i].radius);
    }
    return contact_time_of(config.contact, D, lightest, smallest);
}

void tell(Progress const& progress, double fraction, double overlap)
{
    if (!progress) return;
    char text[160];
    std::snprintf(text, sizeof text, "packing: grown to a fraction of %.3f, overlaps up to %.1e of a diameter%s",
                  fraction, overlap, overlap > allowed_overlap ? " (NOT below 1e-4)" : "");
    progress(text);
}

}  // namespace

template <int D>
Grains<D> grown(Config const& config, Setup<D> const& setup, Progress const& progress)
{
    double const fraction = config.column->packing_fraction, density = config.density;
    double height = column_width(config) * config.column->aspect_ratio;
    double const first = std::pow(std::min(1.0, scattered_fraction(D) / fraction), 1.0 / D);  // of the radii
    Grains<D> grains = scattered(config, weightless(config, setup, height), fraction * std::pow(first, D), first);
    double const t_c = contact_time_among(config, grains), growth = std::pow(first, -1.0 / stages);
    for (int stage = 0; stage < stages; ++stage) {
        grains = stretched(grains, 1.0, growth, density);
        part(weightless(config, setup, height), grains, t_c, 1e-3, 400);
    }
    double overlap = part(weightless(config, setup, height), grains, t_c, allowed_overlap, 4000);
    for (int jammed = 0; jammed < 100 && overlap > allowed_overlap; ++jammed) {
        height *= lift;
        grains = stretched(grains, lift, 1.0, density);
        overlap = part(weightless(config, setup, height), grains, t_c, allowed_overlap, 4000);
    }
    tell(progress, fraction * column_width(config) * config.column->aspect_ratio / height, overlap);
    return stretched(grains, 1.0, 1.0, density);
}

template Grains<2> grown<2>(Config const&, Setup<2> const&, Progress const&);
template Grains<3> grown<3>(Config const&, Setup<3> const&, Progress const&);

}  // namespace dem
