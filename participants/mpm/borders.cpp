#include "participants/mpm/borders.hpp"

#include <algorithm>

namespace mpm {
namespace {

//! Of a chunk's box what is given to nodes: a box around it, for they may meet it from more than one side.
template <int D>
NodeBox<D> given_to(NodeBox<D> const& nodes, NodeBox<D> const& box, std::span<std::array<int, D> const> rounds)
{
    std::vector<NodeBox<D>> parts;
    for (auto const& round : rounds) parts.push_back(common(box, nodes.moved(round)));
    return around<D>(parts);
}

//! each(a row of nodes of `part` in the planes of `box`, how many)
template <int D, class Each>
void each_row(NodeBox<D> const& part, Planes<D> const& box, Each&& each)
{
    auto const length = static_cast<std::size_t>(part.count[0]);
    for (std::size_t k = 0; k < part.nodes(); k += length) each(box.at(part.index(k)), length);
}

}  // namespace

template <int D>
typename Borders<D>::Neighbour Borders<D>::neighbour(Shares const& shares, int rank, std::span<NodeBox<D> const> boxes,
                                                     std::span<std::array<int, D> const> rounds)
{
    auto const chunks_of = [&](int process) {
        std::size_t const first = shares.first_chunk(process);
        return boxes.subspan(first, shares.first_chunk(process + 1) - first);
    };
    Neighbour n{rank, {}};
    auto const own = chunks_of(shares.rank());
    for (std::size_t c = 0; c < own.size(); ++c)
        if (auto const part = given_to<D>(nodes_[static_cast<std::size_t>(rank)], own[c], rounds); !part.empty())
            n.out.push_back({c, part});
    n.first_in = in_.size();
    for (NodeBox<D> const& box : chunks_of(rank))
        if (auto const part = given_to<D>(nodes_[static_cast<std::size_t>(shares.rank())], box, rounds); !part.empty())
            in_.push_back({part});
    n.last_in = in_.size();
    return n;
}

template <int D>
void Borders<D>::lay_out(Shares const& shares, std::span<NodeBox<D> const> boxes,
                         std::span<std::array<int, D> const> rounds)
{
    peers_ = shares.peers();
    nodes_.clear(), neighbours_.clear(), in_.clear();
    for (int r = 0; r < shares.processes(); ++r)
        nodes_.push_back(
            around<D>(boxes.subspan(shares.first_chunk(r), shares.first_chunk(r + 1) - shares.first_chunk(r))));
    for (int r = 0; r < shares.processes(); ++r) {
        if (r == shares.rank()) {
            before_ = in_.size();
            continue;
        }
        Neighbour n = neighbour(shares, r, boxes, rounds);
        if (!n.out.empty() || n.first_in < n.last_in) neighbours_.push_back(std::move(n));
    }
    std::size_t all = 0;
    for (Planes<D>& box : in_) {
        box.plane = box.nodes();
        all += packed::Given<D>::count * box.plane;
    }
    if (numbers_.size() < all) numbers_.resize(all);
    double* next = numbers_.data();
    for (Planes<D>& box : in_) {
        box.data = next;
        next += packed::Given<D>::count * box.plane;
    }
    parcels_.resize(neighbours_.size());
}

template <int D>
void Borders<D>::swap(std::span<Planes<D> const> own, std::size_t from, std::size_t count)
{
    for (std::size_t k = 0; k < parcels_.size(); ++k) {
        Neighbour const& n = neighbours_[k];
        ranks::Parcel& parcel = parcels_[k];
        parcel.peer = n.rank;
        parcel.out.clear();
        for (Part const& part : n.out)
            for (std::size_t q = from; q < from + count; ++q)
                each_row(part.nodes, own[part.chunk], [&](std::size_t at, std::size_t length) {
                    double const* const row = own[part.chunk][q] + at;
                    parcel.out.insert(parcel.out.end(), row, row + length);
                });
        std::size_t coming = 0;
        for (std::size_t i = n.first_in; i < n.last_in; ++i) coming += count * in_[i].plane;
        parcel.in.resize(coming);
    }
    peers_->swap(parcels_);
    for (std::size_t k = 0; k < parcels_.size(); ++k) {
        double const* next = parcels_[k].in.data();
        for (std::size_t i = neighbours_[k].first_in; i < neighbours_[k].last_in; ++i) {
            std::copy_n(next, count * in_[i].plane, in_[i][from]);
            next += count * in_[i].plane;
        }
    }
}

template class Borders<2>;
template class Borders<3>;

}  // namespace mpm
