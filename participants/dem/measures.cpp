#include "participants/dem/measures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "participants/dem/neighbours.hpp"

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

template <int D>
double mean_diameter(Grains<D> const& g)
{
    double sum = 0.0;
    for (auto const& place : g.place) sum += place.radius;
    return 2.0 * sum / static_cast<double>(g.size());
}

//! For each grain whether it belongs to the largest linked set.
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
void measure_contacts(Solver<D> const& solver, Measures<D>& m)
{
    Grains<D> const& g = solver.grains();
    Pairs<D> const& pairs = solver.state().pairs;
    std::vector<std::size_t> touching(g.size(), 0);
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            std::size_t const j = pairs.other[slot];
            double const reach = g.place[i].radius + g.place[j].radius;
            double const overlap = reach - norm(apart(g, pairs, solver.state().cell, i, slot));
            if (overlap <= 0.0) continue;
            ++m.contacts, ++touching[i], ++touching[j];
            m.largest_overlap = std::max(m.largest_overlap, overlap / reach);
        }
    for (std::size_t w = 0; w < solver.setup().walls.size(); ++w)
        std::visit(
            [&](auto const& shape) {
                auto const& wall = solver.state().walls[w];
                for (std::size_t k = 0; k < wall.grain.size(); ++k) {
                    auto const& place = g.place[wall.grain[k]];
                    double const overlap = place.radius - shape.facing(place.centre - wall.shift).distance;
                    if (overlap <= 0.0) continue;
                    ++m.contacts, ++touching[wall.grain[k]];
                    m.largest_overlap = std::max(m.largest_overlap, overlap / (2.0 * place.radius));
                }
            },
            solver.setup().walls[w].shape);
    std::size_t sum = 0;
    for (std::size_t count : touching) {
        if (count < 2)
            ++m.rattlers;
        else
            sum += count;
    }
    std::size_t const bearing = g.size() - m.rattlers;
    m.coordination = bearing > 0 ? static_cast<double>(sum) / static_cast<double>(bearing) : 0.0;
}

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
Measures<D> measure(Solver<D> const& solver)
{
    Grains<D> const& g = solver.grains();
    Measures<D> m;
    if (g.size() == 0) return m;
    auto const belongs = main_mass(g);
    double const back = 2.0 * mean_diameter(g);
    double mass = 0.0;
    Vec<D> moment;
    m.front = m.foremost = -INFINITY;
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const& [centre, radius] = g.place[i];
        double const right = centre.x + radius;
        m.foremost = std::max(m.foremost, right);
        if (belongs[i]) m.front = std::max(m.front, right);
        if (belongs[i] && centre.x < back) m.height = std::max(m.height, up(centre) + radius);
        mass += g.mass[i];
        moment += g.mass[i] * centre;
    }
    m.kinetic = kinetic_energy(g);
    m.centre_of_mass = (1.0 / mass) * moment;
    measure_contacts(solver, m);
    return m;
}

template <int D>
double packing_fraction(Grains<D> const& g, Vec<D> lower, Vec<D> upper)
{
    double volume = 0.0, box = 1.0;
    for (auto const& [centre, radius] : g.place) volume += clipped(centre, radius, lower, upper);
    for (int k = 0; k < D; ++k) box *= component(upper - lower, k);
    return volume / box;
}

template Measures<2> measure<2>(Solver<2> const&);
template Measures<3> measure<3>(Solver<3> const&);
template double packing_fraction<2>(Grains<2> const&, Vec<2>, Vec<2>);
template double packing_fraction<3>(Grains<3> const&, Vec<3>, Vec<3>);

}  // namespace dem
