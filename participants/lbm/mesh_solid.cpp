#include "participants/lbm/mesh_solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "participants/lbm/solid_weight.hpp"

namespace lbm {
namespace {

using files::Point;
using files::Triangle;
using Polygon = std::vector<Point>;

Point minus(Point const& a, Point const& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(Point const& a, Point const& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(Point const& a)
{
    return std::hypot(a[0], a[1], a[2]);
}
//! Across a triangle, twice its area long.
Point across(Triangle const& t)
{
    return cross(minus(t[1], t[0]), minus(t[2], t[0]));
}

using Edge = std::pair<Point, Point>;
//! The triangles that go along each edge.
std::map<Edge, std::vector<Triangle const*>> edges_of(std::vector<Triangle> const& surface)
{
    std::map<Edge, std::vector<Triangle const*>> edges;
    for (Triangle const& t : surface)
        for (std::size_t k = 0; k < 3; ++k) edges[{t[k], t[(k + 1) % 3]}].push_back(&t);
    return edges;
}

double volume(std::vector<Triangle> const& surface)
{
    double sum = 0;
    for (Triangle const& t : surface) sum += dot(t[0], cross(t[1], t[2])) / 6;
    return sum;
}

//! The part of a polygon on one side of a plane across an axis: above it, or below.
void cut(Polygon const& from, std::size_t axis, double at, bool above, Polygon& to)
{
    to.clear();
    for (std::size_t k = 0; k < from.size(); ++k) {
        Point const &a = from[k], &b = from[(k + 1) % from.size()];
        double const da = above ? a[axis] - at : at - a[axis], db = above ? b[axis] - at : at - b[axis];
        if (da >= 0) to.push_back(a);
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
            Point p;
            double const s = da / (da - db);
            for (std::size_t i = 0; i < 3; ++i) p[i] = a[i] + s * (b[i] - a[i]);
            p[axis] = at;
            to.push_back(p);
        }
    }
}

//! Range of cells that a polygon lies in along an axis, within [low, high).
std::pair<std::ptrdiff_t, std::ptrdiff_t> range(Polygon const& p, std::size_t axis, std::ptrdiff_t low,
                                                std::ptrdiff_t high)
{
    auto const [least, most] =
        std::minmax_element(p.begin(), p.end(), [&](Point const& a, Point const& b) { return a[axis] < b[axis]; });
    return {std::max(low, static_cast<std::ptrdiff_t>(std::floor((*least)[axis]))),
            std::min(high, static_cast<std::ptrdiff_t>(std::floor((*most)[axis])) + 1)};
}

//! Under a polygon: its area seen along x, positive where it faces +x, and that area's integral of x.
struct Lid
{
    double area = 0, moment = 0;
    explicit Lid(Polygon const& p)
    {
        for (std::size_t k = 2; k < p.size(); ++k) {
            Point const a = minus(p[k - 1], p[0]), b = minus(p[k], p[0]);
            double const part = 0.5 * (a[1] * b[2] - a[2] * b[1]);
            area += part;
            moment += part * (p[0][0] + p[k - 1][0] + p[k][0]) / 3;
        }
    }
};

//! Sums up columns under lids, row by row.
class Columns
{
 public:
    explicit Columns(Patch<3>& patch)
        : patch_(patch), full_(static_cast<std::size_t>(patch.size[0] * patch.size[1] * patch.size[2]))
    {
        patch.fraction.assign(full_.size(), 0.0);
    }

    void add(Triangle const& t)
    {
        Polygon const whole(t.begin(), t.end());
        auto const [z0, z1] = range(whole, 2, first(2), last(2));
        for (std::ptrdiff_t z = z0; z < z1; ++z) {
            Polygon const& slab = between(whole, 2, z, slab_);
            if (slab.size() < 3) continue;
            auto const [y0, y1] = range(slab, 1, first(1), last(1));
            for (std::ptrdiff_t y = y0; y < y1; ++y) add_to_row(between(slab, 1, y, beam_), y, z);
        }
    }
    //! A column that reaches through a cell fills it.
    void finish(double sign)
    {
        for (std::size_t row = 0; row < full_.size(); row += static_cast<std::size_t>(patch_.size[0])) {
            double above = 0;
            for (auto k = static_cast<std::size_t>(patch_.size[0]); k-- > 0;) {
                above += full_[row + k];
                double& f = patch_.fraction[row + k];
                f = std::clamp(sign * (f + above), 0.0, 1.0);
            }
        }
    }

 private:
    std::ptrdiff_t first(std::size_t axis) const { return patch_.first[axis]; }
    std::ptrdiff_t last(std::size_t axis) const { return patch_.first[axis] + patch_.size[axis]; }

    Polygon const& between(Polygon const& from, std::size_t axis, std::ptrdiff_t cell, Polygon& to)
    {
        cut(from, axis, static_cast<double>(cell), true, half_);
        cut(half_, axis, static_cast<double>(cell + 1), false, to);
        return to;
    }
    void add_to_row(Polygon const& lid, std::ptrdiff_t y, std::ptrdiff_t z)
    {
        if (lid.size() < 3) return;
        auto const row = static_cast<std::size_t>(((z - first(2)) * patch_.size[1] + y - first(1)) * patch_.size[0]);
        cut(lid, 0, static_cast<double>(last(0)), true, beyond_);
        full_[row + static_cast<std::size_t>(patch_.size[0]) - 1] += Lid(beyond_).area;
        auto const [x0, x1] = range(lid, 0, first(0), last(0));
        for (std::ptrdiff_t x = x0; x < x1; ++x) {
            Lid const part(between(lid, 0, x, piece_));
            auto const k = static_cast<std::size_t>(x - first(0));
            patch_.fraction[row + k] += part.moment - static_cast<double>(x) * part.area;
            if (k > 0) full_[row + k - 1] += part.area;
        }
    }

    Patch<3>& patch_;
    std::vector<double> full_;  //!< lids right above a cell: they cover it and all below
    Polygon half_, slab_, beam_, piece_, beyond_;
};

}  // namespace

std::string open_edges(std::vector<Triangle> const& surface)
{
    auto const edges = edges_of(surface);
    std::size_t open = 0;
    Edge shown;
    for (auto const& [edge, triangles] : edges) {
        auto const back = edges.find({edge.second, edge.first});
        if (back != edges.end() && back->second.size() == triangles.size()) continue;
        if (open++ == 0) shown = edge;
    }
    if (open == 0) return "";
    char text[300];
    auto const& [a, b] = shown;
    std::snprintf(
        text, sizeof text,
        "is not closed: %zu edges have a facet on one side only, or two that go round opposite ways, the first "
        "from (%g, %g, %g) to (%g, %g, %g) (a solid needs a closed surface). Close it where it was made.",
        open, a[0], a[1], a[2], b[0], b[1], b[2]);
    return text;
}

double mean_curvature(std::vector<Triangle> const& surface)
{
    double area = 0, bend = 0;
    for (Triangle const& t : surface) area += 0.5 * length(across(t));
    auto const edges = edges_of(surface);
    for (auto const& [edge, triangles] : edges) {
        auto const back = edges.find({edge.second, edge.first});
        if (triangles.size() != 1 || back == edges.end() || back->second.size() != 1 || edge.second < edge.first)
            continue;  // each once; where four facets meet there is no angle
        Point const m = across(*triangles[0]), n = across(*back->second[0]), along = minus(edge.second, edge.first);
        double const angle = std::atan2(dot(cross(m, n), along) / length(along), dot(m, n));
        bend += 0.5 * angle * length(along);
    }
    return (volume(surface) < 0 ? -bend : bend) / area;
}

Patch<3> mesh_patch(std::vector<Triangle> const& surface, Extent const& cells)
{
    Patch<3> patch;
    for (std::size_t k = 0; k < 3; ++k) {
        double low = surface[0][0][k], high = low;
        for (Triangle const& t : surface)
            for (Point const& corner : t) low = std::min(low, corner[k]), high = std::max(high, corner[k]);
        patch.first[k] = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(low)), 0, cells[k]);
        std::ptrdiff_t const end = std::min(static_cast<std::ptrdiff_t>(std::ceil(high)), cells[k]);
        patch.size[k] = std::max<std::ptrdiff_t>(0, end - patch.first[k]);
    }
    if (patch.size[0] * patch.size[1] * patch.size[2] == 0) patch.size = {0, 0, 0};
    Columns columns(patch);
    if (!patch.fraction.empty())
        for (Triangle const& t : surface) columns.add(t);
    columns.finish(volume(surface) < 0 ? -1 : 1);
    patch.drag = drag_of_curvature<3>(std::max(0.0, mean_curvature(surface)));
    return patch;
}

}  // namespace lbm
