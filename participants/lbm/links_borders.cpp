// Links: what processes that share a lattice tell one another.
#include <algorithm>
#include <bit>

#include "participants/lbm/links.hpp"

namespace lbm {
namespace {

void sort_once(std::vector<Extent>& cells)
{
    std::ranges::sort(cells);
    auto const twice = std::ranges::unique(cells);
    cells.erase(twice.begin(), twice.end());
}

}  // namespace

//! For each process across a border: fluid of ours beside cells that bodies have left there, and the other way round.
template <int D>
std::map<int, typename Links<D>::Border> Links<D>::beside_left() const
{
    std::map<int, Border> borders;
    auto const owner = [&](Extent const& at) { return domain_.slabs().owner(at[D - 1]); };
    for (auto const& [body, cell] : cells_.left())
        for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
            bool const here = cells_.is_here(cell.at);
            Extent there = cell.at;
            if (!cells_.step(there, q) || cells_.is_here(there) == here) continue;
            if (!cells_.is_known(there) || cells_.owner(there) != Cells::nobody) continue;
            here ? borders[owner(there)].in.push_back(there) : borders[owner(cell.at)].out.push_back(there);
        }
    for (auto& [peer, border] : borders) {
        sort_once(border.out);
        sort_once(border.in);
    }
    return borders;
}

//! The populations of fluid that lies beside a cell which a body has left, across a border. Both sides know which.
template <int D>
void Links<D>::fetch_neighbours(Populations<D> const& populations)
{
    foreign_.clear();
    if (!domain_.peers()) return;
    auto const borders = beside_left();
    std::vector<ranks::Parcel> parcels;
    for (auto const& [peer, border] : borders) {
        parcels.push_back({peer, {}, std::vector<double>(Lattice<D>::directions * border.in.size())});
        std::vector<double>& out = parcels.back().out;
        populations.visit([&](auto const& rows) {
            for (Extent const& at : border.out) {
                auto const some = populations_of(rows, at);
                out.insert(out.end(), some.begin(), some.end());
            }
        });
    }
    domain_.peers()->swap(parcels);
    auto parcel = parcels.begin();
    for (auto const& [peer, border] : borders) {
        auto from = (parcel++)->in.begin();
        for (Extent const& at : border.in) {
            std::copy_n(from, Lattice<D>::directions, foreign_[cells_.index(at)].begin());
            from += Lattice<D>::directions;
        }
    }
}

//! Whether all links to a body come from cells of this process.
template <int D>
bool Links<D>::has_all_of(Body<D> const& body) const noexcept
{
    auto const [begin, end] = cells_.reach(body);
    return domain_.has_layers(begin, end);
}

//! What the links of a body have to know of it, wherever they are: their weight and what it lacks.
template <int D>
void Links<D>::share_changes()
{
    std::size_t const n = weight_.size(), before = old_bodies_.size();
    for (std::size_t i = 0; i < n; ++i)
        if (weight_[i] > 0)
            changes_.push_back({i, 0, std::bit_cast<std::array<double, changes>>(Change{.weight = weight_[i]})});
    auto const sums = domain_.totals(changes_, n + before);
    auto const of = [&](std::size_t which) { return std::bit_cast<Change>(sums[which]); };
    for (std::size_t i = 0; i < n; ++i) {
        weight_[i] = of(i).weight;
        missing_[i] += of(i).excess;
        if (was_[i] != nothing) missing_[i] -= of(n + static_cast<std::size_t>(was_[i])).excess;
    }
    for (std::size_t i = 0; i < before; ++i)
        for (std::size_t k = 0; k < D; ++k) given_back_[k] += of(n + i).given_back[k];
}

//! What the bodies got, known to all.
template <int D>
void Links<D>::share_sums()
{
    std::vector<SumPart<numbers>> all;
    for (auto const& parts : parts_) all.insert(all.end(), parts.begin(), parts.end());
    auto const sums = domain_.totals(all, sums_.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        Sums const& s = sums_[i] = std::bit_cast<Sums>(sums[i]);
        double const excess = s.links > 0 ? s.excess / s.links : 0.0;
        impulse_[i] = s.impulse;
        for (std::size_t k = 0; k < impulse_[i].size(); ++k) pressed_[i][k] = s.still[k] + excess * s.per_excess[k];
        missing_[i] += s.missing;
    }
}

#define LBM_LINKS_BORDERS(D)                                           \
    template void Links<D>::fetch_neighbours(Populations<D> const&);   \
    template bool Links<D>::has_all_of(Body<D> const&) const noexcept; \
    template void Links<D>::share_changes();                           \
    template void Links<D>::share_sums();
LBM_LINKS_BORDERS(2)
LBM_LINKS_BORDERS(3)
#undef LBM_LINKS_BORDERS

}  // namespace lbm
