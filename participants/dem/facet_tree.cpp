#include "participants/dem/facet_tree.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <numeric>
#include <utility>

namespace dem {
namespace {

constexpr std::uint32_t most_in_a_leaf = 4;
constexpr double infinity = std::numeric_limits<double>::infinity();

template <int D>
Vec<D> sum_of_corners(Facet<D> const& facet)
{
    Vec<D> sum{};
    for (Vec<D> const& corner : facet.corner) sum += corner;
    return sum;
}

//! Square of the distance from a point to a box [m2]; 0 inside.
template <int D>
double square_to(Vec<D> const& low, Vec<D> const& high, Vec<D> const& point) noexcept
{
    double square = 0.0;
    for (int k = 0; k < D; ++k) {
        double const x = component(point, k);
        double const out = std::max({component(low, k) - x, x - component(high, k), 0.0});
        square += out * out;
    }
    return square;
}

}  // namespace

template <int D>
FacetTree<D>::FacetTree(std::vector<Facet<D>> facets) : facets_(std::move(facets)), order_(facets_.size())
{
    assert(!facets_.empty());
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, static_cast<std::uint32_t>(order_.size()));
}

//! Adds the box of order_[begin] .. order_[end] and, behind it, what it is made of.
template <int D>
void FacetTree<D>::build(std::uint32_t begin, std::uint32_t end)
{
    Node node{{}, {}, begin, end};
    Vec<D> first{}, last{};  // of the corners' sums
    for (int k = 0; k < D; ++k) {
        component<D>(node.low, k) = component<D>(first, k) = infinity;
        component<D>(node.high, k) = component<D>(last, k) = -infinity;
    }
    auto const widen = [](Vec<D>& low, Vec<D>& high, Vec<D> const& by) {
        for (int k = 0; k < D; ++k) {
            component<D>(low, k) = std::min(component(low, k), component(by, k));
            component<D>(high, k) = std::max(component(high, k), component(by, k));
        }
    };
    for (std::uint32_t n = begin; n < end; ++n) {
        Facet<D> const& facet = facets_[order_[n]];
        for (Vec<D> const& corner : facet.corner) widen(node.low, node.high, corner);
        widen(first, last, sum_of_corners(facet));
    }
    std::size_t const self = nodes_.size();
    nodes_.push_back(node);
    if (end - begin <= most_in_a_leaf) return;
    int longest = 0;
    for (int k = 1; k < D; ++k)
        if (component(last - first, k) > component(last - first, longest)) longest = k;
    std::uint32_t const middle = begin + (end - begin) / 2;
    auto const place = [&](std::uint32_t f) { return std::pair(component(sum_of_corners(facets_[f]), longest), f); };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    build(begin, middle);
    nodes_[self].second = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
}

//! Calls `visit(facet)` for the facets of all leaves whose box is within `square` [m2], which a visit may lessen.
template <int D>
template <class Visit>
void FacetTree<D>::walk(Vec<D> point, double const& square, Visit&& visit) const
{
    std::array<std::uint32_t, 64> waiting;  // halves: 2^32 facets are 32 deep
    std::size_t count = 0;
    waiting[count++] = 0;
    while (count > 0) {
        std::uint32_t const at = waiting[--count];
        Node const& node = nodes_[at];
        if (square_to(node.low, node.high, point) > square) continue;
        if (node.second == 0) {
            for (std::uint32_t n = node.begin; n < node.end; ++n) visit(order_[n]);
        } else {
            waiting[count++] = node.second;
            waiting[count++] = at + 1;
        }
    }
}

template <int D>
Facing<D> FacetTree<D>::facing(Vec<D> point) const noexcept
{
    double square = infinity;
    std::uint32_t nearest = 0;
    Facing<D> found{infinity, {}};
    walk(point, square, [&](std::uint32_t f) {
        Facing<D> const at = facets_[f].facing(point);
        if (at.distance > found.distance || (at.distance == found.distance && f > nearest)) return;
        found = at, nearest = f;
        square = at.distance * at.distance;
    });
    return found;
}

template <int D>
void FacetTree<D>::find_near(Vec<D> point, double reach, std::vector<std::uint32_t>& found) const
{
    found.clear();
    walk(point, reach * reach, [&](std::uint32_t f) {
        if (facets_[f].facing(point).distance < reach) found.push_back(f);
    });
    std::sort(found.begin(), found.end());
}

template class FacetTree<2>;
template class FacetTree<3>;

}  // namespace dem
