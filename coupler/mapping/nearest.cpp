#include "coupler/mapping/neighbours.hpp"

namespace sluice {

namespace {

template <int D>
Mapping nearest(Places<D> const& sources, Places<D> const& targets)
{
    MappingRows rows;
    if (targets.empty()) return Mapping(rows, sources.size());
    Neighbours<D> const near(sources);
    for (Place<D> const& at : targets) {
        rows.source.push_back(near.nearest(at).index);
        rows.weight.push_back(1.0);
        rows.end_row();
    }
    return Mapping(std::move(rows), sources.size());
}

}  // namespace

Mapping map_nearest(Points sources, Points targets)
{
    return build_mapping("nearest", sources, targets,
                         [](auto const& from, auto const& to) { return nearest(from, to); });
}

}  // namespace sluice
