#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "participants/dem/vec.hpp"
#include "participants/ranks/peers.hpp"

namespace dem {

//! The part of space of each process: slabs across one axis, the first and the last without end.
template <int D>
struct Slabs
{
    int axis = 0;
    std::vector<double> bounds;  //!< between slab k and k + 1, ascending; one less than there are slabs [m]

    int owner(Vec<D> const& point) const { return slab_of(component(point, axis)); }
    //! The first and the last slab of which a part is nearer to the point than `reach` [m].
    std::pair<int, int> near(Vec<D> const& point, double reach) const
    {
        double const at = component(point, axis);
        return {slab_of(at - reach), slab_of(at + reach)};
    }

 private:
    int slab_of(double at) const
    {
        return static_cast<int>(std::upper_bound(bounds.begin(), bounds.end(), at) - bounds.begin());
    }
};

//! Slabs across the longest axis of the box of all centres, with as many of them in each (to half a percent, if they do
//! not lie in layers). `centres`: those of this process; all processes call it and get the same.
template <int D>
Slabs<D> even_slabs(ranks::Peers& peers, std::span<Vec<D> const> centres);

}  // namespace dem
