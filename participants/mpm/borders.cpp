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

//! What planes of a box have on a part of it, one after the other; returns where the next goes.
template <int D>
double* copy_part(NodeBox<D> const& part, Planes<D> const& box, std::size_t from, std::size_t count, double* to)
{
    for (std::size_t q = from; q < from + count; ++q)
        box.each_row(part, [&](std::size_t row, std::size_t length) { to = std::copy_n(box[q] + row, length, to); });
    return to;
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
        if (auto const part = given_to<D>(nodes_[static_cast<std::size_t>(rank)], own[c], rounds); !part.empty()) {
            n.out.push_back({c, part});
            n.nodes_out += part.nodes();
        }
    n.first_in = in_.size();
    for (NodeBox<D> const& box : chunks_of(rank))
        if (auto const part = given_to<D>(nodes_[static_cast<std::size_t>(shares.rank())], box, rounds);
            !part.empty()) {
            in_.push_back({part, nullptr, part.nodes()});
            n.nodes_in += part.nodes();
        }
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
    for (Neighbour const& n : neighbours_) all += packed::Given<D>::count * n.nodes_in;
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
        parcel.out.resize(count * n.nodes_out);
        double* to = parcel.out.data();
        for (Part const& part : n.out) to = copy_part(part.nodes, own[part.chunk], from, count, to);
        parcel.in.resize(count * n.nodes_in);
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
