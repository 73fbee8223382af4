#pragma once

#include <array>
#include <cstddef>

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
};

}  // namespace mpm
