#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/lbm/layout.hpp"
#include "participants/ranks/peers.hpp"

namespace lbm {

//! Layers of a lattice shared out among processes: rows of cells in the plane, planes in space. Each process has some
//! that follow one another, which cost as much as the others', to a layer.
class Slabs
{
 public:
    //! Across an axis. `extra`: what each layer costs beyond its stored cells, in cells; empty: nothing. Throws
    //! sluice::Error (exit 2) if there are fewer layers with cells than processes, or `extra` is of another lattice.
    Slabs(Layout const& whole, std::size_t axis, int count, std::span<double const> extra);

    int owner(std::ptrdiff_t layer) const noexcept
    {
        return static_cast<int>(std::upper_bound(cut_.begin(), cut_.end(), layer) - cut_.begin()) - 1;
    }
    std::ptrdiff_t begin(int rank) const noexcept { return cut_[static_cast<std::size_t>(rank)]; }
    std::ptrdiff_t end(int rank) const noexcept { return cut_[static_cast<std::size_t>(rank) + 1]; }

 private:
    std::vector<std::ptrdiff_t> cut_;  //!< the first layer of each, and the number of layers
};

//! Why so many processes cannot share so many layers across an axis.
sluice::Error too_many(int processes, std::ptrdiff_t layers, std::size_t axis);

//! What belongs to one of several sums, of one layer.
template <std::size_t K>
struct SumPart
{
    std::size_t which;
    std::int64_t layer;  //!< parts are added up by it
    std::array<double, K> sum;
};

//! Makes one part of those from `first` on, which are all of one sum: it is then here alone.
template <std::size_t K>
void join(std::vector<SumPart<K>>& parts, std::size_t first)
{
    if (parts.size() < first + 2) return;
    for (std::size_t p = first + 1; p < parts.size(); ++p)
        for (std::size_t k = 0; k < K; ++k) parts[first].sum[k] += parts[p].sum[k];
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(first) + 1, parts.end());
}

//! The part of a lattice that this process has: all of it, or a slab.
template <int D>
class Domain
{
 public:
    //! `peers`: the processes that share it; null: there is one. `extra`: as Slabs takes it. Throws as Slabs does.
    Domain(Layout whole, ranks::Peers* peers, std::span<double const> extra = {});

    Layout const& whole() const noexcept { return whole_; }
    Layout const& own() const noexcept { return own_ ? *own_ : whole_; }
    ranks::Peers* peers() const noexcept { return peers_; }
    Slabs const& slabs() const noexcept { return slabs_; }
    int rank() const noexcept { return peers_ ? peers_->rank() : 0; }
    std::ptrdiff_t begin() const noexcept { return slabs_.begin(rank()); }  //!< the first layer
    std::ptrdiff_t end() const noexcept { return slabs_.end(rank()); }

    //! Which layer of which box of the whole lattice a row of own() lies in; ascending from row to row.
    std::int64_t layer_of(std::ptrdiff_t r) const noexcept
    {
        Row const& row = own().row(r);
        return origin_[static_cast<std::size_t>(row.box)] * whole_.cells()[D - 1] + (D == 2 ? row.y : row.z);
    }
    //! Whether all layers [begin, end) of the lattice are here.
    bool has_layers(std::ptrdiff_t first, std::ptrdiff_t last) const noexcept
    {
        return !peers_ || (first >= begin() && last <= end());
    }

    //! Those of the layers [first, last) that a process has not, ascending; beyond periodic sides those of the other
    //! end, beyond others none.
    std::vector<std::ptrdiff_t> missing_layers(int rank, std::ptrdiff_t first, std::ptrdiff_t last,
                                               bool periodic) const;

    //! Sums of the parts of all processes, known to all, in the order of layers: the same bits for any number of
    //! processes. `parts`: of this one, in each sum ascending by layer; or one part with all that there is.
    template <std::size_t K>
    std::vector<std::array<double, K>> totals(std::vector<SumPart<K>> const& parts, std::size_t count) const;

 private:
    ranks::Peers* peers_;
    Layout whole_;
    Slabs slabs_;
    std::optional<Layout> own_{};
    std::vector<std::int64_t> origin_{};  //!< for each of our boxes, the whole lattice's that it was cut from
};

template <int D>
template <std::size_t K>
std::vector<std::array<double, K>> Domain<D>::totals(std::vector<SumPart<K>> const& parts, std::size_t count) const
{
    std::vector<std::array<double, K>> sums(count, std::array<double, K>{});
    auto const add = [&](std::vector<SumPart<K>> const& some) {
        for (SumPart<K> const& part : some)
            for (std::size_t k = 0; k < K; ++k) sums[part.which][k] += part.sum[k];
    };
    if (!peers_) {
        add(parts);
        return sums;
    }
    std::vector<SumPart<K>> all;
    for (auto const& some : ranks::of_everyone(*peers_, parts)) all.insert(all.end(), some.begin(), some.end());
    std::stable_sort(all.begin(), all.end(), [](auto const& a, auto const& b) { return a.layer < b.layer; });
    add(all);
    return sums;
}

}  // namespace lbm
