#include "participants/dem/stress.hpp"

#include <algorithm>
#include <cmath>

#include "participants/dem/contact_forces.hpp"
#include "participants/dem/measures.hpp"

namespace dem {
namespace {

template <int D>
void add_product(Tensor<D>& to, double weight, Vec<D> const& a, Vec<D> const& b)
{
    for (int k = 0; k < D; ++k) to[static_cast<std::size_t>(k)] += (weight * component(a, k)) * b;
}

template <int D>
void scale(Tensor<D>& tensor, double by)
{
    for (Vec<D>& row : tensor) row = by * row;
}

//! The part of the line from a to b that lies in the box [-].
template <int D>
double part_within(Box<D> const& box, Vec<D> const& a, Vec<D> const& b)
{
    double from = 0.0, to = 1.0;
    for (int k = 0; k < D; ++k) {
        double const start = component(a, k), along = component(b - a, k);
        double const low = component(box.first, k) - start, high = component(box.second, k) - start;
        if (along == 0.0) {
            if (low > 0.0 || high <= 0.0) return 0.0;
            continue;
        }
        from = std::max(from, std::min(low / along, high / along));
        to = std::min(to, std::max(low / along, high / along));
    }
    return std::max(0.0, to - from);
}

//! Calls `visit(shift, velocity)` for the grains' own places and those of all images of the cell.
template <int D, class Visit>
void each_image(Setup<D> const& setup, State<D> const& state, Visit&& visit)
{
    if (!setup.features.periodic) return visit(Vec<D>{}, Vec<D>{});
    for (std::size_t image = 0; image < image_count<D>; ++image)
        if (has_image(setup.periodic, image)) visit(state.cell.images[image].shift, state.cell.images[image].velocity);
}

//! Which part of each contact counts, as its line lies.
template <int D>
double part_of(ContactForce<D> const& f, Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box)
{
    if (!box) return 1.0;
    double part = 0.0;
    each_image(setup, state, [&](Vec<D> shift, Vec<D>) { part += part_within(*box, f.begin + shift, f.end + shift); });
    return part;
}

template <int D>
void add_contacts(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box, Averages<D>& sum)
{
    for (ContactForce<D> const& f : contact_forces(setup, state)) {
        double const part = part_of(f, setup, state, box);
        if (!(part > 0.0)) continue;
        Vec<D> const branch = f.begin - f.end;
        add_product<D>(sum.contact, part, f.force(), branch);
        add_product<D>(sum.fabric, part / dot(branch, branch), branch, branch);
        sum.contacts += part;
    }
}

//! The grains that count, where their images are, and how those move.
template <int D>
struct Moving
{
    double mass;
    Vec<D> centre, velocity;
};
template <int D>
std::vector<Moving<D>> grains_within(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box)
{
    Grains<D> const& g = state.grains;
    std::vector<Moving<D>> within;
    auto const is_in = [&](Vec<D> centre) {
        bool yes = true;
        for (int k = 0; k < D; ++k)
            yes = yes && component(centre - box->first, k) >= 0.0 && component(box->second - centre, k) > 0.0;
        return yes;
    };
    for (std::size_t i = 0; i < g.size(); ++i) {
        Vec<D> const centre = g.place[i].centre, velocity = g.motion[i].velocity;
        if (!box) {
            within.push_back({g.mass[i], centre, velocity});
            continue;
        }
        each_image(setup, state, [&](Vec<D> shift, Vec<D> sped) {
            if (is_in(centre + shift)) within.push_back({g.mass[i], centre + shift, velocity + sped});
        });
    }
    return within;
}

template <int D>
void add_motion(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box, Averages<D>& sum)
{
    auto grains = grains_within(setup, state, box);
    Shear const& shear = setup.periodic.shear;
    double mass = 0.0;
    Vec<D> momentum;
    for (Moving<D>& grain : grains) {
        component<D>(grain.velocity, shear.along) -= shear.rate * component(grain.centre, shear.across);
        mass += grain.mass;
        momentum += grain.mass * grain.velocity;
    }
    if (!(mass > 0.0)) return;
    for (Moving<D> const& grain : grains) {
        Vec<D> const beyond = grain.velocity - (1.0 / mass) * momentum;
        add_product<D>(sum.kinetic, grain.mass, beyond, beyond);
    }
}

//! Volume of all grains within [m3].
template <int D>
double matter_within(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box, double volume)
{
    double matter = 0.0;
    if (!box) {
        for (Place<D> const& place : state.grains.place) matter += volume_of<D>(place.radius);
        return matter;
    }
    each_image(setup, state, [&](Vec<D> shift, Vec<D>) {
        matter += volume * packing_fraction(state.grains, box->first - shift, box->second - shift);
    });
    return matter;
}

}  // namespace

template <int D>
Averages<D> averages(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box)
{
    Averages<D> sum;
    sum.volume = 1.0;
    for (int k = 0; k < D; ++k)
        sum.volume *= box ? component(box->second - box->first, k) : component(state.cell.extent, k);
    add_contacts(setup, state, box, sum);
    add_motion(setup, state, box, sum);
    scale<D>(sum.contact, 1.0 / sum.volume);
    scale<D>(sum.kinetic, 1.0 / sum.volume);
    if (sum.contacts > 0.0) scale<D>(sum.fabric, 1.0 / sum.contacts);
    sum.packing_fraction = matter_within(setup, state, box, sum.volume) / sum.volume;
    return sum;
}

template <int D>
double friction_angle(Averages<D> const& a, int first, int second)
{
    auto const s = [&](int i, int j) { return a.stress(static_cast<std::size_t>(i), j); };
    double const shear = 0.5 * (s(first, second) + s(second, first));
    double const deviator = std::hypot(0.5 * (s(first, first) - s(second, second)), shear);
    double const mean = 0.5 * (s(first, first) + s(second, second));
    return mean > 0.0 ? std::asin(std::min(1.0, deviator / mean)) : 0.0;
}

template <int D>
double stress_across(Setup<D> const& setup, State<D> const& state) noexcept
{
    Grains<D> const& g = state.grains;
    int const across = setup.periodic.shear.across;
    double const low = component(setup.periodic.low, across), height = component(state.cell.extent, across);
    double sum = 0.0, volume = 1.0;  // sum over pairs of f (xi - xj - n h) = that over grains of F x, less f n h
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (g.is_ghost(i)) continue;
        double const speed = component(g.motion[i].velocity, across);
        sum += component(g.contact[i].force, across) * (component(g.place[i].centre, across) - low) +
               g.mass[i] * speed * speed;
    }
    sum -= component(state.cell.pull[static_cast<std::size_t>(across)], across) * height;
    for (int k = 0; k < D; ++k) volume *= component(state.cell.extent, k);
    return sum / volume;
}

template Averages<2> averages<2>(Setup<2> const&, State<2> const&, std::optional<Box<2>> const&);
template Averages<3> averages<3>(Setup<3> const&, State<3> const&, std::optional<Box<3>> const&);
template double friction_angle<2>(Averages<2> const&, int, int);
template double friction_angle<3>(Averages<3> const&, int, int);
template double stress_across<2>(Setup<2> const&, State<2> const&) noexcept;
template double stress_across<3>(Setup<3> const&, State<3> const&) noexcept;

}  // namespace dem
