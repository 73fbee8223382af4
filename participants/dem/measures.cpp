#include "participants/dem/measures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "participants/dem/neighbours.hpp"
#include "participants/dem/touches.hpp"

namespace dem {
namespace {

//! Disjoint sets of grains.
class Sets
{
 public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    std::size_t root(std::size_t i)
    {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) { parent_[root(b)] = root(a); }

 private:
    std::vector<std::size_t> parent_;
};

//! Sum over slices across x of a body of this radius, within [low, high]: `across(half)` is the extent of the slice
//! whose half width is given.
template <class Across>
double sliced(double x, double radius, double low, double high, Across&& across)
{
    constexpr int slices = 64;
    double sum = 0.0;
    for (int s = 0; s < slices; ++s) {
        double const offset = radius * ((s + 0.5) * 2.0 / slices - 1.0);
        if (x + offset < low || x + offset > high) continue;
        sum += across(std::sqrt(radius * radius - offset * offset)) * 2.0 * radius / slices;
    }
    return sum;
}

//! Area of a disc within a rectangle [m2]: strips, each clipped exactly in y.
double clipped(Vec2 centre, double radius, Vec2 lower, Vec2 upper)
{
    return sliced(centre.x, radius, lower.x, upper.x, [&](double half) {
        return std::max(0.0, std::min(upper.y, centre.y + half) - std::max(lower.y, centre.y - half));
    });
}

//! Volume of a sphere within a box [m3]: slices along x, each a clipped disc.
double clipped(Vec3 centre, double radius, Vec3 lower, Vec3 upper)
{
    return sliced(centre.x, radius, lower.x, upper.x, [&](double disc) {
        return clipped(Vec2{centre.y, centre.z}, disc, {lower.y, lower.z}, {upper.y, upper.z});
    });
}

}  // namespace

template <int D>
double mean_diameter(Grains<D> const& g)
{
    double sum = 0.0;
    for (auto const& place : g.place) sum += place.radius;
    return 2.0 * sum / static_cast<double>(g.size());
}

template <int D>
std::vector<bool> main_mass(Grains<D> const& g)
{
    std::vector<std::uint32_t> first, other;
    find_pairs(g, 0.1 * mean_diameter(g), first, other);
    Sets sets(g.size());
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = first[i]; slot < first[i + 1]; ++slot) sets.join(i, other[slot]);
    std::vector<std::size_t> size(g.size(), 0);
    for (std::size_t i = 0; i < g.size(); ++i) ++size[sets.root(i)];
    auto const largest = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
    std::vector<bool> belongs(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) belongs[i] = sets.root(i) == largest;
    return belongs;
}

template <int D>
RunOut run_out_of(Grains<D> const& g)
{
    RunOut r;
    if (g.size() == 0) return r;
    auto const belongs = main_mass(g);
    double const back = 2.0 * mean_diameter(g);
    r.front = r.foremost = -INFINITY;
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [centre, radius] = g.place[i];
        double const right = centre.x + radius;
        r.foremost = std::max(r.foremost, right);
        if (belongs[i]) r.front = std::max(r.front, right);
        if (belongs[i] && centre.x < back) r.height = std::max(r.height, up(centre) + radius);
    }
    return r;
}

template <int D>
Vec<D> centre_of_mass(Grains<D> const& g)
{
    if (g.size() == 0) return {};
    double mass = 0.0;
    Vec<D> moment;
    for (std::size_t i = 0; i < g.size(); ++i) {
        mass += g.mass[i];
        moment += g.mass[i] * g.place[i].centre;
    }
    return (1.0 / mass) * moment;
}

template <int D>
std::vector<std::size_t> contacts_of_grains(Setup<D> const& setup, State<D> const& state, Partners partners)
{
    std::size_t const grains = state.grains.size();
    std::vector<std::size_t> touching(grains, 0);
    each_touch(setup, state, [&](Touch<D> const& touch) {
        bool const wall = touch.second >= grains;
        if (wall && partners == Partners::grains) return;
        ++touching[touch.first];
        if (!wall) ++touching[touch.second];
    });
    return touching;
}

Coordination coordination_of(std::vector<std::size_t> const& contacts, std::size_t most)
{
    Coordination c;
    c.grains.assign(most + 1, 0.0);
    std::size_t all = 0, sum = 0;
    for (std::size_t const count : contacts) {
        c.grains[std::min(count, most)] += 1.0;
        all += count;
        if (count < 2)
            ++c.rattlers;
        else
            sum += count;
    }
    auto const mean = [](std::size_t total, std::size_t of) {
        return of > 0 ? static_cast<double>(total) / static_cast<double>(of) : 0.0;
    };
    c.mean = mean(all, contacts.size());
    c.bearing = mean(sum, contacts.size() - c.rattlers);
    return c;
}

template <int D>
ContactNumbers contact_numbers(Setup<D> const& setup, State<D> const& state)
{
    ContactNumbers n;
    each_touch(setup, state, [&](Touch<D> const& touch) {
        ++n.contacts;
        n.largest_overlap = std::max(n.largest_overlap, touch.overlap / touch.reach);
    });
    return n;
}

template <int D>
Measures<D> measure(Solver<D> const& solver)
{
    Grains<D> const& g = solver.grains();
    auto const coordination =
        coordination_of(contacts_of_grains(solver.setup(), solver.state(), Partners::grains_and_walls), 0);
    return {run_out_of(g),        contact_numbers(solver.setup(), solver.state()),
            kinetic_energy(g),    centre_of_mass(g),
            coordination.bearing, coordination.rattlers};
}

template <int D>
double packing_fraction(Grains<D> const& g, Vec<D> lower, Vec<D> upper)
{
    double volume = 0.0, box = 1.0;
    for (auto const& [centre, radius] : g.place) volume += clipped(centre, radius, lower, upper);
    for (int k = 0; k < D; ++k) box *= component(upper - lower, k);
    return volume / box;
}

#define DEM_MEASURES(D)                                                                                  \
    template double mean_diameter<D>(Grains<D> const&);                                                  \
    template std::vector<bool> main_mass<D>(Grains<D> const&);                                           \
    template RunOut run_out_of<D>(Grains<D> const&);                                                     \
    template Vec<D> centre_of_mass<D>(Grains<D> const&);                                                 \
    template std::vector<std::size_t> contacts_of_grains<D>(Setup<D> const&, State<D> const&, Partners); \
    template ContactNumbers contact_numbers<D>(Setup<D> const&, State<D> const&);                        \
    template Measures<D> measure<D>(Solver<D> const&);                                                   \
    template double packing_fraction<D>(Grains<D> const&, Vec<D>, Vec<D>);
DEM_MEASURES(2)
DEM_MEASURES(3)
#undef DEM_MEASURES

}  // namespace dem
