// Phase: what processes that share a lattice tell one another.
#include <algorithm>

#include "participants/lbm/phase.hpp"

namespace lbm {

//! Layers of others that the points near a process reach. They may be less than a hat away.
template <int D>
std::vector<std::ptrdiff_t> Phase<D>::border(int rank) const
{
    std::ptrdiff_t const reach = 2 * width_ - 1;
    return domain_.missing_layers(rank, domain_.slabs().begin(rank) - reach, domain_.slabs().end(rank) + reach,
                                  periodic_[D - 1]);
}

//! The rows with solid of those layers that a process has.
template <int D>
std::vector<std::size_t> Phase<D>::rows_of(std::vector<std::ptrdiff_t> const& layers, int owner) const
{
    std::ptrdiff_t const in_layer = D == 2 ? 1 : cells_[1];
    std::vector<std::size_t> rows;
    for (std::ptrdiff_t const layer : layers)
        for (std::ptrdiff_t r = layer * in_layer; r < (layer + 1) * in_layer; ++r)
            if (any_[static_cast<std::size_t>(r)] && domain_.slabs().owner(layer) == owner)
                rows.push_back(static_cast<std::size_t>(r));
    return rows;
}

//! Which points and rows are this process's matter, and what goes to and fro for them.
template <int D>
void Phase<D>::find_near()
{
    auto const across = static_cast<std::size_t>(2 * width_);
    near_.clear();
    for (std::size_t i = 0; i < points_.size(); ++i) {
        auto const at = at_.begin() + static_cast<std::ptrdiff_t>((i * D + D - 1) * across);
        if (std::any_of(at, at + static_cast<std::ptrdiff_t>(across),
                        [&](std::int32_t layer) { return layer >= 0 && domain_.has_layers(layer, layer + 1); }))
            near_.push_back(i);
    }
    std::vector<std::ptrdiff_t> own;
    for (std::ptrdiff_t layer = domain_.begin(); layer < domain_.end(); ++layer) own.push_back(layer);
    rows_ = rows_of(own, domain_.rank());
    borders_.clear();
    parcels_.clear();
    auto* const peers = domain_.peers();
    for (int p = 0; peers && p < peers->count(); ++p) {
        if (p == domain_.rank()) continue;
        Border with{rows_of(border(p), domain_.rank()), rows_of(border(domain_.rank()), p)};
        if (with.out.empty() && with.in.empty()) continue;
        rows_.insert(rows_.end(), with.in.begin(), with.in.end());
        std::size_t const row = (1 + D) * static_cast<std::size_t>(cells_[0]);
        parcels_.push_back({p, std::vector<double>(row * with.out.size()), std::vector<double>(row * with.in.size())});
        borders_.push_back(std::move(with));
    }
}

//! What cells have given up, to and from other processes.
template <int D>
void Phase<D>::swap_borders()
{
    if (!domain_.peers()) return;
    auto const each_column = [&](std::size_t row, auto&& visit) {
        auto const first = static_cast<std::ptrdiff_t>(row) * cells_[0];
        visit(own_.begin() + first);
        for (auto& component : given_) visit(component.begin() + first);
    };
    for (std::size_t b = 0; b < borders_.size(); ++b) {
        auto to = parcels_[b].out.begin();
        for (std::size_t const row : borders_[b].out)
            each_column(row, [&](auto column) { to = std::copy_n(column, cells_[0], to); });
    }
    domain_.peers()->swap(parcels_);
    for (std::size_t b = 0; b < borders_.size(); ++b) {
        auto from = parcels_[b].in.begin();
        for (std::size_t const row : borders_[b].in)
            each_column(row, [&](auto column) {
                std::copy_n(from, cells_[0], column);
                from += cells_[0];
            });
    }
}

//! What points have got in all steps, from those who know to all.
template <int D>
void Phase<D>::share_impulses()
{
    if (!domain_.peers()) return;
    struct Got
    {
        std::size_t point;
        Vector impulse;
    };
    std::vector<Got> known;
    for (std::size_t const i : near_) known.push_back({i, points_[i].impulse});
    for (auto const& some : ranks::of_everyone(*domain_.peers(), known))  // whoever knows a point knows the same
        for (Got const& got : some) points_[got.point].impulse = got.impulse;
}

#define LBM_PHASE_BORDERS(D)                \
    template void Phase<D>::find_near();    \
    template void Phase<D>::swap_borders(); \
    template void Phase<D>::share_impulses();
LBM_PHASE_BORDERS(2)
LBM_PHASE_BORDERS(3)
#undef LBM_PHASE_BORDERS

}  // namespace lbm
