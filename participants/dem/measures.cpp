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

double mean_diameter(Grains const& g)
{
    return 2.0 * std::accumulate(g.radius.begin(), g.radius.end(), 0.0) / static_cast<double>(g.size());
}

//! For each grain whether it belongs to the largest linked set.
std::vector<bool> main_mass(Grains const& g)
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

double wall_overlap(Grains const& g, Wall const& wall, std::size_t i)
{
    return g.radius[i] - dot(Vec2{g.x[i], g.y[i]} - wall.point, wall.normal);
}

void measure_contacts(Solver const& solver, Measures& m)
{
    Grains const& g = solver.grains();
    Pairs const& pairs = solver.state().pairs;
    std::vector<std::size_t> touching(g.size(), 0);
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            std::size_t const j = pairs.other[slot];
            double const reach = g.radius[i] + g.radius[j];
            double const overlap = reach - std::hypot(g.x[i] - g.x[j], g.y[i] - g.y[j]);
            if (overlap <= 0.0) continue;
            ++m.contacts, ++touching[i], ++touching[j];
            m.largest_overlap = std::max(m.largest_overlap, overlap / reach);
        }
    for (std::size_t w = 0; w < solver.setup().walls.size(); ++w)
        for (std::uint32_t i : solver.state().wall_contacts[w].grain) {
            double const overlap = wall_overlap(g, solver.setup().walls[w], i);
            if (overlap <= 0.0) continue;
            ++m.contacts, ++touching[i];
            m.largest_overlap = std::max(m.largest_overlap, overlap / (2.0 * g.radius[i]));
        }
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

}  // namespace

Measures measure(Solver const& solver)
{
    Grains const& g = solver.grains();
    Measures m;
    if (g.size() == 0) return m;
    auto const belongs = main_mass(g);
    double const back = 2.0 * mean_diameter(g);
    double mass = 0.0;
    Vec2 moment;
    m.front = m.foremost = -INFINITY;
    for (std::size_t i = 0; i < g.size(); ++i) {
        double const right = g.x[i] + g.radius[i];
        m.foremost = std::max(m.foremost, right);
        if (belongs[i]) m.front = std::max(m.front, right);
        if (belongs[i] && g.x[i] < back) m.height = std::max(m.height, g.y[i] + g.radius[i]);
        m.kinetic +=
            0.5 * g.mass[i] * (g.vx[i] * g.vx[i] + g.vy[i] * g.vy[i]) + 0.5 * g.inertia[i] * g.spin[i] * g.spin[i];
        mass += g.mass[i];
        moment = moment + g.mass[i] * Vec2{g.x[i], g.y[i]};
    }
    m.centre_of_mass = (1.0 / mass) * moment;
    measure_contacts(solver, m);
    return m;
}

double packing_fraction(Grains const& g, Vec2 lower, Vec2 upper)
{
    double area = 0.0;
    constexpr int strips = 64;  // of a disc; each is clipped exactly in y
    for (std::size_t i = 0; i < g.size(); ++i)
        for (int s = 0; s < strips; ++s) {
            double const offset = g.radius[i] * ((s + 0.5) * 2.0 / strips - 1.0), x = g.x[i] + offset;
            if (x < lower.x || x > upper.x) continue;
            double const half = std::sqrt(g.radius[i] * g.radius[i] - offset * offset);
            double const length = std::min(upper.y, g.y[i] + half) - std::max(lower.y, g.y[i] - half);
            area += std::max(0.0, length) * 2.0 * g.radius[i] / strips;
        }
    return area / ((upper.x - lower.x) * (upper.y - lower.y));
}

Vec2 wall_reaction(Solver const& solver, std::size_t w)
{
    Grains const& g = solver.grains();
    Wall const& wall = solver.setup().walls[w];
    WallContacts const& contacts = solver.state().wall_contacts[w];
    TangentialForce const& law = wall.tangential_force;
    Vec2 sum;
    for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
        std::size_t const i = contacts.grain[k];
        double const overlap = wall_overlap(g, wall, i), sqrt_mass = std::sqrt(g.mass[i]);
        if (overlap <= 0.0) continue;
        Vec2 const velocity{g.vx[i], g.vy[i]}, tangent = tangent_of(wall.normal);
        double const normal = wall.normal_force(overlap, -dot(velocity, wall.normal), sqrt_mass);
        double const slip = dot(velocity, tangent) - g.radius[i] * g.spin[i];
        double const tangential = law.stiffness * contacts.spring[k] + law.damping * sqrt_mass * slip;
        sum = sum + normal * wall.normal - tangential * tangent;
    }
    return sum;
}

}  // namespace dem
