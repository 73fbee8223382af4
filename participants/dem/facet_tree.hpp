#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/facet.hpp"

namespace dem {

//! The facets of a mesh and where they are: a binary tree of boxes whose sides are parallel to the axes, halved at the
//! median along their longest side, down to a few facets.
template <int D>
class FacetTree
{
 public:
    //! At least one facet.
    explicit FacetTree(std::vector<Facet<D>> facets);

    std::vector<Facet<D>> const& facets() const { return facets_; }
    //! What the nearest facet is to a point; of several the first.
    Facing<D> facing(Vec<D> point) const noexcept;
    //! The facets nearer than `reach` [m] to a point, ascending, in place of what `found` held.
    void find_near(Vec<D> point, double reach, std::vector<std::uint32_t>& found) const;

 private:
    //! A box and either the facets within, order_[begin] .. order_[end], or two boxes: the next one, and `second`.
    struct Node
    {
        Vec<D> low, high;
        std::uint32_t begin, end, second = 0;
    };
    void build(std::uint32_t begin, std::uint32_t end);
    template <class Visit>
    void walk(Vec<D> point, double const& square, Visit&& visit) const;

    std::vector<Facet<D>> facets_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace dem
