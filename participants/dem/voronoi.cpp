#include "participants/dem/voronoi.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <type_traits>
#include <voro++/voro++.hh>

#include "participants/dem/config.hpp"
#include "participants/dem/measures.hpp"

namespace dem {
namespace {

constexpr int wall_mark = -10;  //!< voro++'s name for a neighbour that is a wall; -1 to -6 are the sides of the box

//! A plane as a side of cells. `outward` is a unit vector.
struct Side
{
    Vec3 outward;
    double offset;  //!< outward . x = offset on the plane

    template <class Cell>
    bool cut(Cell& cell, Vec3 at) const
    {
        double const distance = offset - dot(outward, at);
        return distance > 0.0 && cell.nplane(outward.x, outward.y, outward.z, 2.0 * distance, wall_mark);
    }
};

//! A wall as voro++ wants it: `cut(cell, centre)` is false when nothing is left of the cell.
template <class Cut>
class Boundary : public voro::wall
{
 public:
    explicit Boundary(Cut cut) : cut_(std::move(cut)) {}
    bool point_inside(double, double, double) override { return true; }
    bool cut_cell(voro::voronoicell& c, double x, double y, double z) override { return cut_(c, Vec3{x, y, z}); }
    bool cut_cell(voro::voronoicell_neighbor& c, double x, double y, double z) override
    {
        return cut_(c, Vec3{x, y, z});
    }

 private:
    Cut cut_;
};
template <class Cut>
std::unique_ptr<voro::wall> boundary(Cut cut)
{
    return std::make_unique<Boundary<Cut>>(std::move(cut));
}

//! The inside of a cylinder as a prism of the same cross-section area, so that the cells fill its volume.
std::unique_ptr<voro::wall> hollow(Vec3 point, Vec3 axis, double radius)
{
    constexpr int sides = 64;
    double const pi = std::numbers::pi, apothem = radius * std::sqrt(pi / (sides * std::tan(pi / sides)));
    Vec3 const first = across(axis), second = cross(axis, first);
    std::vector<Side> prism;
    for (int k = 0; k < sides; ++k) {
        double const angle = 2.0 * pi * k / sides;
        Vec3 const outward = std::cos(angle) * first + std::sin(angle) * second;
        prism.push_back({outward, dot(outward, point) + apothem});
    }
    return boundary([prism](auto& cell, Vec3 at) {
        return std::all_of(prism.begin(), prism.end(), [&](Side const& side) { return side.cut(cell, at); });
    });
}

//! The tangent plane of a cylinder that faces the grain.
std::unique_ptr<voro::wall> pillar(Vec3 point, Vec3 axis, double radius)
{
    return boundary([=](auto& cell, Vec3 at) {
        Vec3 const off = at - point, radial = off - dot(off, axis) * axis;
        Vec3 const inward = (-1.0 / norm(radial)) * radial;
        return Side{inward, dot(inward, point) - radius}.cut(cell, at);
    });
}

//! The walls as they are now, in units of `unit` [m].
template <int D>
std::vector<std::unique_ptr<voro::wall>> boundaries(Setup<D> const& setup, State<D> const& state, double unit)
{
    std::vector<std::unique_ptr<voro::wall>> walls;
    for (std::size_t w = 0; w < setup.walls.size(); ++w) {
        if (!state.walls[w].active) continue;
        auto const moved = [&](Vec<D> point) { return (1.0 / unit) * in_space(point + state.walls[w].shift); };
        if (auto const* plane = std::get_if<Plane<D>>(&setup.walls[w].shape)) {
            Vec3 const outward = -in_space(plane->normal);
            walls.push_back(boundary([side = Side{outward, dot(outward, moved(plane->point))}](auto& cell, Vec3 at) {
                return side.cut(cell, at);
            }));
        }
        if (auto const* cylinder = std::get_if<Cylinder<D>>(&setup.walls[w].shape)) {
            Vec3 const axis = D == 2 ? Vec3{0, 0, 1} : in_space(cylinder->axis);
            walls.push_back(
                (cylinder->inside ? hollow : pillar)(moved(cylinder->point), axis, cylinder->radius / unit));
        }
    }
    return walls;
}

//! Blocks that a box is cut into, so that there are a few grains in each.
template <int D>
std::array<int, 3> blocks_of(Vec3 const& size, std::size_t grains)
{
    double const volume = size.x * size.y * size.z;
    double const block = std::pow(voro::optimal_particles * volume / static_cast<double>(grains), 1.0 / D);
    auto const blocks = [&](double length) { return std::max(1, static_cast<int>(length / block)); };
    return {blocks(size.x), blocks(size.y), D == 2 ? 1 : blocks(size.z)};
}

//! A container of spheres in the box around the grains, along periodic axes in the cell; discs lie in the middle of a
//! slab one unit thick.
template <int D>
voro::container_poly container_of(Setup<D> const& setup, State<D> const& state, double unit)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Grains<D> const& g = state.grains;
    Vec3 low{infinity, infinity, infinity}, high = -low;
    for (auto const& [centre, radius] : g.place)
        for (int k = 0; k < D; ++k) {
            double const at = component(centre, k) / unit, reach = radius / unit + 1.0;
            component<3>(low, k) = std::min(component<3>(low, k), at - reach);
            component<3>(high, k) = std::max(component<3>(high, k), at + reach);
        }
    if (D == 2) low.z = -0.5, high.z = 0.5;
    std::array<bool, 3> periodic{};
    for (int k = 0; k < D; ++k) {
        auto const axis = static_cast<std::size_t>(k);
        periodic[axis] = setup.periodic.axis[axis];
        if (!periodic[axis]) continue;
        component<3>(low, k) = component(setup.periodic.low, k) / unit;
        component<3>(high, k) = component(setup.periodic.low + state.cell.extent, k) / unit;
    }
    auto const n = blocks_of<D>(high - low, g.size());
    return {low.x, high.x, low.y, high.y, low.z, high.z, n[0], n[1], n[2], periodic[0], periodic[1], periodic[2], 8};
}

//! The cells of all grains of a container, at(i) their centres there.
template <int D, class Container, class At>
void compute_cells(Container& container, Grains<D> const& g, double unit, At&& at, Tessellation& t)
{
    for (std::size_t i = 0; i < g.size(); ++i) {
        Vec3 const centre = at(g.place[i].centre);
        container.put(static_cast<int>(i), centre.x, centre.y, centre.z, g.place[i].radius / unit);
    }
    voro::voronoicell_neighbor cell;
    std::vector<int> neighbours;
    std::conditional_t<std::is_same_v<Container, voro::container_poly>, voro::c_loop_all, voro::c_loop_all_periodic>
        loop(container);
    if (!loop.start()) return;
    do {
        if (!container.compute_cell(cell, loop)) continue;
        auto const i = static_cast<std::size_t>(loop.pid());
        t.volume[i] = cell.volume() * std::pow(unit, D);
        t.fraction[i] = volume_of<D>(g.place[i].radius) / t.volume[i];
        cell.neighbors(neighbours);
        t.closed[i] = std::none_of(neighbours.begin(), neighbours.end(),
                                   [](int n) { return n < 0 && n > (D == 2 ? -5 : -7); });  // the slab's faces bound
    } while (loop.inc());
}

//! Those of a sheared cell, seen along its shear: what moves along is x there, what it moves across y.
template <int D>
void compute_sheared(Setup<D> const& setup, State<D> const& state, double unit, Tessellation& t)
{
    Shear const& shear = setup.periodic.shear;
    auto const turned = [&](Vec<D> const& v) {
        double const third = D == 3 ? component(v, 3 - shear.along - shear.across) / unit : 0.0;
        return Vec3{component(v, shear.along) / unit, component(v, shear.across) / unit, third};
    };
    Vec3 size = turned(state.cell.extent);
    if (D == 2) size.z = 1.0;
    auto const n = blocks_of<D>(size, state.grains.size());
    voro::container_periodic_poly container(size.x, state.cell.offset / unit, size.y, 0.0, 0.0, size.z, n[0], n[1],
                                            n[2], 8);
    compute_cells<D>(
        container, state.grains, unit, [&](Vec<D> const& centre) { return turned(centre - setup.periodic.low); }, t);
}

}  // namespace

template <int D>
Tessellation tessellate(Setup<D> const& setup, State<D> const& state)
{
    Grains<D> const& g = state.grains;
    std::size_t const count = g.size();
    Tessellation t{std::vector<double>(count), std::vector<double>(count), std::vector<bool>(count)};
    if (count == 0) return t;
    double const unit = mean_diameter(g);  // voro++'s tolerances are absolute
    if (setup.periodic.is_sheared()) {     // periodic along all axes: there are no walls
        compute_sheared(setup, state, unit, t);
        return t;
    }
    auto const walls = boundaries(setup, state, unit);
    auto container = container_of(setup, state, unit);
    for (auto const& wall : walls) container.add_wall(*wall);
    compute_cells<D>(
        container, g, unit, [&](Vec<D> const& centre) { return (1.0 / unit) * in_space(centre); }, t);
    return t;
}

template <int D>
Packed packed_of(Grains<D> const& g, Tessellation const& cells, Bins const& bins)
{
    Packed p;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (!cells.closed[i]) continue;
        low = std::min(low, bins.position(g.place[i].centre));
        high = std::max(high, bins.position(g.place[i].centre));
        ++p.closed;
    }
    if (p.closed == 0) return p;
    p.position = slice_positions(bins, low, high);
    std::vector<double> matter(p.position.size()), room(p.position.size());
    double all_matter = 0.0, all_room = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (!cells.closed[i]) continue;
        auto const slice = static_cast<std::size_t>(bins.slice(bins.position(g.place[i].centre)) - bins.slice(low));
        double const volume = volume_of<D>(g.place[i].radius);
        matter[slice] += volume, all_matter += volume;
        room[slice] += cells.volume[i], all_room += cells.volume[i];
    }
    p.fraction = all_matter / all_room;
    for (std::size_t k = 0; k < matter.size(); ++k) p.fractions.push_back(room[k] > 0.0 ? matter[k] / room[k] : 0.0);
    return p;
}

template Tessellation tessellate<2>(Setup<2> const&, State<2> const&);
template Tessellation tessellate<3>(Setup<3> const&, State<3> const&);
template Packed packed_of<2>(Grains<2> const&, Tessellation const&, Bins const&);
template Packed packed_of<3>(Grains<3> const&, Tessellation const&, Bins const&);

}  // namespace dem
