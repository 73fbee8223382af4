#include "participants/lbm/domain.hpp"

#include <numeric>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"

namespace lbm {
namespace {

//! Of each layer across an axis.
std::vector<std::ptrdiff_t> cells_of_layers(Layout const& layout, std::size_t axis)
{
    std::vector<std::ptrdiff_t> cells(static_cast<std::size_t>(layout.cells()[axis]));
    for (Box const& box : layout.boxes())
        for (std::ptrdiff_t k = 0; k < box.size[axis]; ++k)
            cells[static_cast<std::size_t>(box.first[axis] + k)] += box.cells() / box.size[axis];
    return cells;
}

}  // namespace

sluice::Error too_many(int processes, std::ptrdiff_t layers, std::size_t axis)
{
    return sluice::Error("fluid: " + std::to_string(processes) + " processes for a lattice of " +
                         std::to_string(layers) + " layers of cells along " + "xyz"[axis] +
                         " (needed: one layer or more for each). Give fewer ranks.");
}

Slabs::Slabs(Layout const& whole, std::size_t axis, int count, std::span<double const> extra)
{
    auto const cells = cells_of_layers(whole, axis);
    sluice::require(extra.empty() || extra.size() == cells.size(), [&] {
        return sluice::Error("fluid: the cost of " + std::to_string(extra.size()) +
                             " layers of cells for a lattice of " + std::to_string(cells.size()) +
                             " (needed: one of each).");
    });
    // lest processes without bodies have all the memory: none stores more than three even shares, but for whole layers
    auto const stored = static_cast<double>(whole.stored());
    double const all_extra = std::accumulate(extra.begin(), extra.end(), 0.0);
    double const counted = all_extra > 2 * stored ? 2 * stored / all_extra : 1;
    std::vector<std::ptrdiff_t> filled;  // layers
    std::vector<double> cost;            // of those
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (cells[k] == 0) continue;
        filled.push_back(static_cast<std::ptrdiff_t>(k));
        cost.push_back(static_cast<double>(cells[k]) + (extra.empty() ? 0.0 : counted * extra[k]));
    }
    std::size_t const layers = filled.size();
    sluice::require(static_cast<std::size_t>(count) <= layers,
                    [&] { return too_many(count, static_cast<std::ptrdiff_t>(layers), axis); });
    double const all = std::accumulate(cost.begin(), cost.end(), 0.0);
    cut_.push_back(0);
    std::size_t next = 0;  // of `filled`
    double below = 0;      // cost of those before
    for (int rank = 1; rank < count; ++rank) {
        double const wanted = all * rank / count;
        std::size_t const last = layers - static_cast<std::size_t>(count - rank);  // leaves one for each that follows
        do below += cost[next++];
        while (next < last && below + cost[next] / 2 < wanted);
        cut_.push_back(filled[next]);
    }
    cut_.push_back(whole.cells()[axis]);
}

template <int D>
Domain<D>::Domain(Layout whole, ranks::Peers* peers, std::span<double const> extra)
    : peers_(peers), whole_(std::move(whole)), slabs_(whole_, D - 1, peers ? peers->count() : 1, extra)
{
    std::vector<Box> boxes;
    for (std::size_t b = 0; b < whole_.boxes().size(); ++b) {
        Box box = whole_.boxes()[b];
        std::ptrdiff_t& first = box.first[D - 1];
        std::ptrdiff_t const last = std::min(first + box.size[D - 1], end());
        first = std::max(first, begin());
        box.size[D - 1] = last - first;
        if (first >= last) continue;
        boxes.push_back(box);
        origin_.push_back(static_cast<std::int64_t>(b));
    }
    if (peers_) own_.emplace(whole_.cells(), std::move(boxes));
}

template <int D>
std::vector<std::ptrdiff_t> Domain<D>::missing_layers(int rank, std::ptrdiff_t first, std::ptrdiff_t last,
                                                      bool periodic) const
{
    std::ptrdiff_t const n = whole_.cells()[D - 1];
    std::vector<std::ptrdiff_t> layers;
    for (std::ptrdiff_t k = first; k < last; ++k)
        if ((periodic || (k >= 0 && k < n)) && slabs_.owner(wrap(k, n)) != rank) layers.push_back(wrap(k, n));
    std::ranges::sort(layers);
    auto const twice = std::ranges::unique(layers);
    layers.erase(twice.begin(), twice.end());
    return layers;
}

template class Domain<2>;
template class Domain<3>;

}  // namespace lbm
