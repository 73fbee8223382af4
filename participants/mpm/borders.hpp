#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "participants/mpm/packed_passes.hpp"
#include "participants/mpm/shares.hpp"

namespace mpm {

//! What the chunks of a process give to nodes that others have, and theirs to its own. A process's nodes are a box
//! around those that its points reach. All processes make the same calls.
template <int D>
class Borders
{
 public:
    //! `boxes`: of the chunks of all processes; `rounds`: ways to nodes that are the same (PackedNodes).
    void lay_out(Shares const& shares, std::span<NodeBox<D> const> boxes, std::span<std::array<int, D> const> rounds);

    //! Of each process, by rank.
    std::vector<NodeBox<D>> const& nodes() const { return nodes_; }
    //! Of the boxes of others what lies over nodes that are here, in the order of their chunks; those before and those
    //! after ours.
    std::span<Planes<D> const> before() const { return std::span(in_).first(before_); }
    std::span<Planes<D> const> after() const { return std::span(in_).subspan(before_); }

    //! Brings planes of numbers: of our chunks' boxes, `own`, to others, theirs to before() and after().
    void swap(std::span<Planes<D> const> own, std::size_t from, std::size_t count);

 private:
    struct Part  //!< of the box of a chunk of ours
    {
        std::size_t chunk;
        NodeBox<D> nodes;
    };
    struct Neighbour
    {
        int rank;
        std::vector<Part> out;
        std::size_t first_in = 0, last_in = 0;    //!< of in_, one beyond the last
        std::size_t nodes_out = 0, nodes_in = 0;  //!< of all parts
    };
    Neighbour neighbour(Shares const& shares, int rank, std::span<NodeBox<D> const> boxes,
                        std::span<std::array<int, D> const> rounds);

    ranks::Peers* peers_ = nullptr;
    std::vector<NodeBox<D>> nodes_;
    std::vector<Neighbour> neighbours_;
    std::vector<Planes<D>> in_;
    std::size_t before_ = 0;
    std::vector<double> numbers_;  //!< of in_
    std::vector<ranks::Parcel> parcels_;
};

}  // namespace mpm
