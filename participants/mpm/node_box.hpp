#pragma once

#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <span>

namespace mpm {

//! Nodes of a grid side by side, numbered with x fastest.
template <int D>
struct NodeBox
{
    std::array<int, D> first{};  //!< node
    std::array<int, D> count{};  //!< of nodes, each way

    std::size_t nodes() const
    {
        std::size_t all = 1;
        for (int const n : count) all *= static_cast<std::size_t>(n);
        return all;
    }
    std::size_t at(std::array<int, D> const& node) const
    {
        std::size_t place = 0;
        for (std::size_t a = D; a-- > 0;)
            place = place * static_cast<std::size_t>(count[a]) + static_cast<std::size_t>(node[a] - first[a]);
        return place;
    }
    std::array<int, D> index(std::size_t at) const
    {
        std::array<int, D> node;
        for (std::size_t a = 0; a < D; ++a) {
            auto const n = static_cast<std::size_t>(count[a]);
            node[a] = first[a] + static_cast<int>(at % n);
            at /= n;
        }
        return node;
    }
    bool empty() const
    {
        return std::ranges::any_of(count, [](int n) { return n <= 0; });
    }
    bool has(std::array<int, D> const& node) const
    {
        for (std::size_t a = 0; a < D; ++a)
            if (node[a] < first[a] || node[a] >= first[a] + count[a]) return false;
        return true;
    }
    //! each(place of the first node, how many), for each row of nodes along x of a part of this box.
    template <class Each>
    void each_row(NodeBox const& part, Each&& each) const
    {
        if (part.empty()) return;
        auto const stride = static_cast<std::size_t>(count[0]), layer = stride * static_cast<std::size_t>(count[1]);
        std::size_t const begin = at(part.first), length = static_cast<std::size_t>(part.count[0]);
        auto const rows = static_cast<std::size_t>(part.count[1]);
        std::size_t const layers = D == 3 ? static_cast<std::size_t>(part.count[D - 1]) : 1;
        for (std::size_t z = 0; z < layers; ++z)
            for (std::size_t y = 0; y < rows; ++y) each(begin + z * layer + y * stride, length);
    }
    NodeBox moved(std::array<int, D> const& way) const
    {
        NodeBox box = *this;
        for (std::size_t a = 0; a < D; ++a) box.first[a] += way[a];
        return box;
    }
};

//! What two boxes have in common; may be empty.
template <int D>
NodeBox<D> common(NodeBox<D> const& one, NodeBox<D> const& other)
{
    NodeBox<D> both;
    for (std::size_t a = 0; a < D; ++a) {
        both.first[a] = std::max(one.first[a], other.first[a]);
        both.count[a] = std::min(one.first[a] + one.count[a], other.first[a] + other.count[a]) - both.first[a];
    }
    return both;
}

//! The smallest box around those that are not empty; empty if there is none.
template <int D>
NodeBox<D> around(std::span<NodeBox<D> const> boxes)
{
    std::array<int, D> low, high;
    low.fill(INT_MAX), high.fill(INT_MIN);
    for (NodeBox<D> const& box : boxes)
        for (std::size_t a = 0; a < D && !box.empty(); ++a) {
            low[a] = std::min(low[a], box.first[a]);
            high[a] = std::max(high[a], box.first[a] + box.count[a]);
        }
    NodeBox<D> all;
    for (std::size_t a = 0; a < D && low[a] < high[a]; ++a) all.first[a] = low[a], all.count[a] = high[a] - low[a];
    return all;
}

}  // namespace mpm
