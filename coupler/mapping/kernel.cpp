#include <cmath>

#include "coupler/mapping/neighbours.hpp"
#include "coupler/mapping/wendland.hpp"

namespace sluice {

namespace {

//! Adds one row; true if nobody is near enough.
template <int D>
bool add_row(MappingRows& rows, Neighbours<D> const& near, Place<D> const& at, double radius,
             std::vector<Neighbour>& found)
{
    near.within(at, radius, found);
    std::size_t const first = rows.weight.size();
    double sum = 0;
    for (Neighbour const& n : found) {
        rows.source.push_back(n.index);
        rows.weight.push_back(wendland_c2(std::sqrt(n.square) / radius));
        sum += rows.weight.back();
    }
    bool const alone = !(sum > 0);
    if (alone) {
        rows.source.resize(first, 0);
        rows.weight.resize(first, 0);
        rows.source.push_back(near.nearest(at).index);
        rows.weight.push_back(sum = 1);
    }
    for (std::size_t e = first; e < rows.weight.size(); ++e) rows.weight[e] /= sum;
    rows.end_row();
    return alone;
}

template <int D>
Mapping kernel(Places<D> const& sources, Places<D> const& targets, double radius)
{
    MappingRows rows;
    if (targets.empty()) return Mapping(rows, sources.size());
    Neighbours<D> const near(sources);
    std::vector<Neighbour> found;
    std::size_t alone = 0;
    for (Place<D> const& at : targets) alone += add_row(rows, near, at, radius, found);
    return Mapping(std::move(rows), sources.size(), alone);
}

}  // namespace

Mapping map_kernel(Points sources, Points targets, double radius)
{
    require(radius > 0 && radius < 1e100, [&] {
        return Error("mapping kernel: radius = " + std::to_string(radius) + " m (must be > 0 and finite).");
    });
    return build_mapping("kernel", sources, targets,
                         [&](auto const& from, auto const& to) { return kernel(from, to, radius); });
}

}  // namespace sluice
