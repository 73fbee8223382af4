// PackedStep: which points are where: shares of processes, order, chunks with their boxes of nodes.
#include <algorithm>
#include <cmath>

#include "participants/mpm/packed_step.hpp"
#include "participants/mpm/tiles.hpp"

namespace mpm {
namespace {

constexpr double most_nodes_of_a_point = 50;

//! Whether boxes of nodes would be mostly empty.
template <int D>
bool far_apart(std::span<NodeBox<D> const> boxes, std::size_t points)
{
    auto nodes = static_cast<double>(around(boxes).nodes());
    for (NodeBox<D> const& box : boxes) nodes += static_cast<double>(box.nodes());
    return nodes > most_nodes_of_a_point * static_cast<double>(points) + 1e4;
}

}  // namespace

template <int D>
void PackedStep<D>::take(State<D> const& state)
{
    shares_ = Shares(peers_, state.points.size());
    points_.take(state, shares_.begin(shares_.rank()), shares_.end(shares_.rank()));
}

template <int D>
void PackedStep<D>::give(Setup<D> const& setup, State<D>& state, Whom whom) const
{
    peers_ ? gather_points(shares_, points_, setup.affine, whom, state) : points_.give(state, 0, setup.affine);
}

//! Places in cells; returns the box of nodes around them.
template <int D>
NodeBox<D> PackedStep<D>::find_box(Setup<D> const& setup, Chunk& chunk)
{
    using C = PackedColumns<D>;
    PackVec<D> low, high;
    for (int a = 0; a < D; ++a) low[a] = all(1e300), high[a] = all(-1e300);
    for (std::size_t k = chunk.points.begin; k < chunk.points.end; k += 4) {
        PackVec<D> place = points_.vector_at(C::place, k);
        for (int a = 0; a < D; ++a) {
            place[a] = (place[a] - all(setup.origin[a])) / all(setup.cell);
            low[a] = sluice::packs::smaller(low[a], place[a]), high[a] = sluice::packs::larger(high[a], place[a]);
        }
        points_.set(C::cell, k, place);
    }
    auto const node = [](double place) { return static_cast<int>(std::floor(place - 0.5)); };
    NodeBox<D> box;
    for (int a = 0; a < D; ++a) {
        auto const k = static_cast<std::size_t>(a);
        double const least = std::min(std::min(low[a][0], low[a][1]), std::min(low[a][2], low[a][3]));
        double const most = std::max(std::max(high[a][0], high[a][1]), std::max(high[a][2], high[a][3]));
        box.first[k] = node(least), box.count[k] = node(most) - node(least) + 3;
    }
    return box;
}

template <int D>
bool PackedStep<D>::lay_out(Setup<D> const& setup)
{
    points_.place_fillers();
    std::size_t const filled = (points_.size() + 3) / 4 * 4;
    chunks_.resize((filled + chunk - 1) / chunk);
    std::vector<NodeBox<D>> own;
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        chunks_[c].points = {c * chunk, std::min(filled, (c + 1) * chunk)};
        chunks_[c].outcome = {};
        own.push_back(find_box(setup, chunks_[c]));
    }
    auto const everywhere = peers_ ? ranks::all_rows(*peers_, own) : own;
    if (far_apart<D>(everywhere, shares_.points())) return false;
    nodes_.lay_out({around<D>(own)}, setup);
    if (peers_) {
        borders_.lay_out(shares_, everywhere, nodes_.rounds());
        nodes_.leave_out(std::span(borders_.nodes()).first(static_cast<std::size_t>(shares_.rank())));
    }
    boxes_.assign(borders_.before().begin(), borders_.before().end());
    for (NodeBox<D> const& box : own) boxes_.push_back({box});
    boxes_.insert(boxes_.end(), borders_.after().begin(), borders_.after().end());
    return true;
}

template <int D>
void PackedStep<D>::sort(Setup<D> const& setup)
{
    std::vector<std::array<int, D>> cells(points_.size());
    std::array<int, D> low, high;
    low.fill(INT32_MAX), high.fill(INT32_MIN);
    for (std::size_t k = 0; k < cells.size(); ++k)
        for (std::size_t a = 0; a < D; ++a) {
            double const place = points_[PackedColumns<D>::place + a][k] - setup.origin[static_cast<int>(a)];
            cells[k][a] = static_cast<int>(std::floor(place / setup.cell - 0.5));
            low[a] = std::min(low[a], cells[k][a]), high[a] = std::max(high[a], cells[k][a]);
        }
    NodeBox<D> box{.first = low};
    for (std::size_t a = 0; a < D; ++a) box.count[a] = high[a] - low[a] + 1;
    if (peers_) box = around<D>(ranks::everyone(*peers_, box));
    Tiles<D> const tiles(box);
    if (!tiles.serve(shares_.points())) return;
    std::vector<std::uint32_t> keys;
    for (auto const& cell : cells) keys.push_back(tiles.key(cell));
    if (peers_) keys = ranks::all_rows(*peers_, keys);
    auto const to = places_by_key(keys, static_cast<std::size_t>(tiles.keys()));
    peers_ ? mpm::move_points(shares_, to, points_) : points_.move(to);
}

template void PackedStep<2>::take(State<2> const&);
template void PackedStep<2>::give(Setup<2> const&, State<2>&, Whom) const;
template bool PackedStep<2>::lay_out(Setup<2> const&);
template void PackedStep<2>::sort(Setup<2> const&);
template void PackedStep<3>::take(State<3> const&);
template void PackedStep<3>::give(Setup<3> const&, State<3>&, Whom) const;
template bool PackedStep<3>::lay_out(Setup<3> const&);
template void PackedStep<3>::sort(Setup<3> const&);

}  // namespace mpm
