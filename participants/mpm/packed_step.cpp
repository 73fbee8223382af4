#include "participants/mpm/packed_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "coupler/base/team.hpp"
#include "participants/mpm/packed_cones.hpp"
#include "participants/mpm/packed_deform.hpp"
#include "participants/mpm/room.hpp"

namespace mpm {
namespace {

using namespace packed;

constexpr std::int64_t sorted_every = 32;  //!< steps; 8 to 128 are within 2 %
constexpr double most_nodes_of_a_point = 50;
//! Cells along an edge of the tiles that points are sorted by: a chunk of four (eight) points a cell is one (two) of
//! them, and reaches few nodes.
template <int D>
constexpr int tile = D == 2 ? 16 : 4;

PackedElastic packed_law(LinearElastic const& law, double)
{
    return PackedElastic(law);
}
PackedMohrCoulomb packed_law(MohrCoulomb const& law, double)
{
    return PackedMohrCoulomb(law);
}
PackedDruckerPrager packed_law(DruckerPrager const& law, double)
{
    return PackedDruckerPrager(law);
}
PackedMuOfI packed_law(MuOfI const& law, double dt)
{
    return {law, dt};
}

}  // namespace

template <int D>
PackedStep<D>::PackedStep(int threads) : threads_(threads), team_(std::make_unique<sluice::Team>(threads))
{}
template <int D>
PackedStep<D>::PackedStep(PackedStep const& other) : PackedStep(other.threads_)
{
    points_ = other.points_;
}
template <int D>
PackedStep<D>& PackedStep<D>::operator=(PackedStep const& other)
{
    return *this = PackedStep(other);
}
template <int D>
PackedStep<D>::PackedStep(PackedStep&&) noexcept = default;
template <int D>
PackedStep<D>& PackedStep<D>::operator=(PackedStep&&) noexcept = default;
template <int D>
PackedStep<D>::~PackedStep() = default;

template <int D>
bool PackedStep<D>::serves(Setup<D> const& setup)
{
    return (setup.basis == BasisKind::gimp || setup.basis == BasisKind::spline) && setup.width == Width::fixed &&
           setup.tractions.empty() && !std::holds_alternative<NeoHookean>(setup.law) &&
           (setup.symmetry == Symmetry::plane || (setup.affine && setup.scheme == Scheme::musl)) &&
           !setup.one_at_a_time;
}

template <int D>
template <class Each>
void PackedStep<D>::share(std::size_t count, Each&& each)
{
    auto const body = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t k = begin; k < end; ++k) each(static_cast<std::size_t>(k));
    };
    auto const all = static_cast<std::ptrdiff_t>(count);
    // several pieces a thread: a core that others use takes fewer
    !together_ ? body(0, all) : team_->share(all, std::max<std::ptrdiff_t>(1, all / (8 * threads_)), body);
}
template <int D>
template <class Each>
void PackedStep<D>::each_chunk(Each&& each)
{
    share(chunks_.size(), [&](std::size_t c) { each(chunks_[c], boxes_[c]); });
}
template <int D>
template <class Each>
void PackedStep<D>::each_slice(Each&& each)
{
    // waiting for each other takes longer than the work on few nodes, most of all where others use the cores, too
    if (nodes_.planes().nodes() >= worth_sharing) return share(nodes_.slices(), each);
    for (std::size_t slice = 0; slice < nodes_.slices(); ++slice) each(slice);
}

//! Places in cells, and the box of nodes around them.
template <int D>
void PackedStep<D>::find_box(Setup<D> const& setup, Chunk& chunk, Planes<D>& box)
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
    for (int a = 0; a < D; ++a) {
        auto const k = static_cast<std::size_t>(a);
        double const least = std::min(std::min(low[a][0], low[a][1]), std::min(low[a][2], low[a][3]));
        double const most = std::max(std::max(high[a][0], high[a][1]), std::max(high[a][2], high[a][3]));
        box.first[k] = node(least), box.count[k] = node(most) - node(least) + 3;
    }
    chunk.outcome = {};
}

template <int D>
bool PackedStep<D>::lay_out(Setup<D> const& setup)
{
    points_.place_fillers();
    std::size_t const filled = (points_.size() + 3) / 4 * 4;
    chunks_.resize((filled + chunk - 1) / chunk);
    boxes_.resize(chunks_.size());
    for (std::size_t c = 0; c < chunks_.size(); ++c) chunks_[c].points = {c * chunk, std::min(filled, (c + 1) * chunk)};
    for (std::size_t c = 0; c < chunks_.size(); ++c) find_box(setup, chunks_[c], boxes_[c]);
    Planes<D> around = boxes_[0];
    double nodes = 0;
    for (Planes<D> const& box : boxes_) {
        double own = 1;
        for (std::size_t a = 0; a < D; ++a) {
            int const end = std::max(around.first[a] + around.count[a], box.first[a] + box.count[a]);
            around.first[a] = std::min(around.first[a], box.first[a]);
            around.count[a] = end - around.first[a];
            own *= box.count[a];
        }
        nodes += own;
    }
    double whole = 1;
    for (int const n : around.count) whole *= n;
    if (nodes + whole > most_nodes_of_a_point * static_cast<double>(points_.size()) + 1e4) return false;
    nodes_.lay_out(around, setup);
    return true;
}

//! By cells, in tiles.
template <int D>
void PackedStep<D>::sort(Setup<D> const& setup)
{
    constexpr int edge = tile<D>;
    constexpr std::uint32_t in_tile = D == 2 ? edge * edge : edge * edge * edge;
    std::vector<std::array<int, D>> cells(points_.size());
    std::array<int, D> low, high;
    low.fill(INT32_MAX), high.fill(INT32_MIN);
    for (std::size_t k = 0; k < cells.size(); ++k)
        for (std::size_t a = 0; a < D; ++a) {
            double const place = points_[PackedColumns<D>::place + a][k] - setup.origin[static_cast<int>(a)];
            cells[k][a] = static_cast<int>(std::floor(place / setup.cell - 0.5));
            low[a] = std::min(low[a], cells[k][a]), high[a] = std::max(high[a], cells[k][a]);
        }
    double count = 1;
    std::array<std::uint32_t, D> tiles;
    for (std::size_t a = 0; a < D; ++a) {
        tiles[a] = static_cast<std::uint32_t>((high[a] - low[a]) / edge + 1);
        count *= double(tiles[a]) * edge;
    }
    if (count > 100 * most_nodes_of_a_point * static_cast<double>(cells.size())) return;
    std::vector<std::uint32_t> keys(cells.size());
    for (std::size_t k = 0; k < keys.size(); ++k) {
        std::uint32_t of_tile = 0, within = 0;
        for (std::size_t a = D; a-- > 0;) {
            auto const at = static_cast<std::uint32_t>(cells[k][a] - low[a]);
            of_tile = of_tile * tiles[a] + at / edge;
            within = within * edge + at % edge;
        }
        keys[k] = of_tile * in_tile + within;
    }
    points_.sort(keys, static_cast<std::size_t>(count));
}

template <int D>
void PackedStep<D>::touch_grains(Setup<D> const& setup, double time, double dt, GrainContacts<D>& grains,
                                 Outcome& outcome)
{
    grains.begin(setup);
    for (std::size_t k = 0; k < points_.size(); ++k) {
        Vec<D> place;
        for (std::size_t a = 0; a < D; ++a) place[static_cast<int>(a)] = points_[PackedColumns<D>::place + a][k];
        if (grains.is_near(setup, place))
            grains.consider(setup, dt, points_.order()[k], place, points_[PackedColumns<D>::ratio][k]);
    }
    nodes_.touch(setup, time, dt, grains, outcome.booked);
}

template <int D>
template <bool affine, bool shared, bool rings, class Law>
void PackedStep<D>::deform(double dt, Law const& law)
{
    each_chunk([&](Chunk& c, Planes<D> const&) {
        auto const d = packed::deform<D, affine, shared, rings>(points_, c.points, dt, law, nodes_.planes());
        c.outcome.stress = d.work;
        c.outcome.booked.plastic = d.plastic;
        c.outcome.speed = d.speed;
        c.outcome.all_upright = d.upright;
    });
}

template <int D>
template <bool affine, bool musl, bool shared, bool rings>
void PackedStep<D>::run(Setup<D> const& setup, double time, double dt, std::span<Vec<D> const> loads,
                        GrainContacts<D>& grains, Outcome& outcome)
{
    Shape const shape{setup.basis == BasisKind::spline ? 0.5 : setup.half_width, setup.origin[0] / setup.cell};
    Planes<D> const& nodes = nodes_.planes();
    auto const forget = [](Planes<D> const& box, std::size_t from, std::size_t count) {
        std::fill_n(box[from], count * box.plane, 0.0);
    };
    each_chunk([&](Chunk& c, Planes<D>& box) {
        box.plane = box.nodes() + 4;
        if (c.numbers.size() < G::count * box.plane) c.numbers.resize(G::count * box.plane);
        box.data = c.numbers.data();
        forget(box, 0, G::count);
        if constexpr (shared) mean_stress_to_cells<D, rings>(points_, c.points, box);
    });
    auto const share_mean = [&](std::size_t slice) {
        nodes_.add(slice, boxes_, G::volume, 2);
        nodes_.take_mean(slice);
    };
    if constexpr (shared) each_slice(share_mean);
    each_chunk([&](Chunk& c, Planes<D> const& box) {
        if constexpr (shared) forget(box, G::volume, 2);
        c.outcome.kinetic_before = to_grid<D, affine, shared, rings>(points_, c.points, shape, setup.cell, box, nodes);
        if (!loads.empty()) loads_to_grid<D, rings>(points_, loads, c.points, shape, box);
    });
    Field<D> const field(setup, time, dt);
    each_slice([&](std::size_t slice) {
        nodes_.add(slice, boxes_, G::mass, (loads.empty() ? std::size_t{G::again} : std::size_t{G::volume}));
        if (!loads.empty()) nodes_.add_loads(slice);
        setup.frame ? nodes_.template move<true>(slice, setup, field, dt)
                    : nodes_.template move<false>(slice, setup, field, dt);
        if (!loads.empty()) nodes_.book_loads(slice, setup, dt);
        if (!grains.any()) nodes_.hold(slice, setup, time, dt);
    });
    if (grains.any()) {
        touch_grains(setup, time, dt, grains, outcome);
        each_slice([&](std::size_t slice) { nodes_.hold(slice, setup, time, dt); });
    }
    auto const sums = nodes_.sums();
    outcome.booked.damping += sums.damped;
    outcome.booked.sliding += sums.sliding;
    outcome.booked.external_work += sums.external;
    outcome.light_nodes = sums.light;
    outcome.nodes = static_cast<std::size_t>(sums.reached);
    auto const room = room_of<D>(setup);
    each_chunk([&](Chunk& c, Planes<D> const& box) {
        if (!loads.empty()) forget(box, G::again, D);
        auto const move = [&]<bool turning>() {
            return to_points<D, affine, musl, turning, rings>(points_, c.points, setup, field, shape, dt, room, box,
                                                              nodes);
        };
        Moved const moved = setup.frame ? move.template operator()<!rings>() : move.template operator()<false>();
        c.outcome.kinetic_after = moved.kinetic;
        c.outcome.booked.field_work = moved.round;
        c.outcome.field = moved.field;
        c.outcome.all_inside = moved.inside;
    });
    bool const gathered = musl || sums.light > 0;
    if constexpr (musl)
        each_slice([&](std::size_t slice) {
            nodes_.add(slice, boxes_, G::again, D);
            nodes_.set_strain_velocities(slice);
        });
    else if (gathered)
        each_slice([&](std::size_t slice) { nodes_.pass_light_nodes(slice, setup); });
    each_chunk([&](Chunk& c, Planes<D> const& box) {  // musl always gathers
        gathered ? gradients<D, true, shared, rings>(points_, c.points, setup, shape, dt, box, nodes)
                 : gradients<D, musl, shared, rings>(points_, c.points, setup, shape, dt, box, nodes);
    });
    if constexpr (shared) each_slice(share_mean);
    std::visit(
        [&](auto const& law) {
            if constexpr (requires { packed_law(law, dt); }) deform<affine, shared, rings>(dt, packed_law(law, dt));
        },
        setup.law);
}

template <int D>
bool PackedStep<D>::go(Setup<D> const& setup, double time, std::int64_t steps, double dt, std::span<Vec<D> const> loads,
                       GrainContacts<D>& grains, Outcome& outcome)
{
    if (steps % sorted_every == 0) sort(setup);
    if (!lay_out(setup)) return false;
    outcome = {};
    auto const pick = [&]<bool affine, bool musl, bool rings = false>()
    {
        setup.shared_volume ? run<affine, musl, true, rings>(setup, time, dt, loads, grains, outcome)
                            : run<affine, musl, false, rings>(setup, time, dt, loads, grains, outcome);
    };
    bool const musl = setup.scheme == Scheme::musl;
    if (setup.symmetry == Symmetry::axial) {
        if constexpr (D == 2) pick.template operator()<true, true, true>();
    } else if (setup.affine)
        musl ? pick.template operator()<true, true>() : pick.template operator()<true, false>();
    else
        musl ? pick.template operator()<false, true>() : pick.template operator()<false, false>();
    for (Chunk const& c : chunks_) {
        Outcome const& o = c.outcome;
        outcome.kinetic_before += o.kinetic_before, outcome.kinetic_after += o.kinetic_after;
        outcome.field += o.field, outcome.stress += o.stress;
        outcome.booked.plastic += o.booked.plastic;
        outcome.booked.field_work += o.booked.field_work;
        outcome.speed = std::max(outcome.speed, o.speed);
        outcome.all_inside &= o.all_inside, outcome.all_upright &= o.all_upright;
    }
    return true;
}

template <int D>
bool PackedStep<D>::step(Setup<D> const& setup, double time, std::int64_t steps, double dt,
                         std::span<Vec<D> const> loads, GrainContacts<D>& grains, Outcome& outcome)
{
    if (threads_ == 1) return go(setup, time, steps, dt, loads, grains, outcome);
    using Clock = std::chrono::steady_clock;
    auto const begin = Clock::now();
    together_ = pace_.together();
    std::optional<sluice::Team::Awake> awake;
    if (together_) awake.emplace(*team_);
    bool const done = go(setup, time, steps, dt, loads, grains, outcome);
    pace_.took(std::chrono::duration<double>(Clock::now() - begin).count());
    return done;
}

template class PackedStep<2>;
template class PackedStep<3>;

}  // namespace mpm
