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

template <int D>
void forget(Planes<D> const& box, std::size_t from, std::size_t count)
{
    std::fill_n(box[from], count * box.plane, 0.0);
}

}  // namespace

template <int D>
PackedStep<D>::PackedStep(int threads, ranks::Peers* peers)
    : threads_(threads), peers_(peers), team_(std::make_unique<sluice::Team>(threads))
{}
template <int D>
PackedStep<D>::PackedStep(PackedStep const& other) : PackedStep(other.threads_, other.peers_)
{
    shares_ = other.shares_;
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
    auto const boxes = own_boxes();
    share(chunks_.size(), [&](std::size_t c) { each(chunks_[c], boxes[c]); });
}
template <int D>
template <class Each>
void PackedStep<D>::each_slice(Each&& each)
{
    // waiting for each other takes longer than the work on few nodes, most of all where others use the cores, too
    if (nodes_.planes().nodes() >= worth_sharing) return share(nodes_.slices(), each);
    for (std::size_t slice = 0; slice < nodes_.slices(); ++slice) each(slice);
}

//! Brings planes of boxes to where processes border on each other.
template <int D>
void PackedStep<D>::share_boxes(std::size_t from, std::size_t count)
{
    if (peers_) borders_.swap(own_boxes(), from, count);
}

//! Means over the points of a cell.
template <int D>
void PackedStep<D>::share_means()
{
    share_boxes(G::volume, 2);
    each_slice([&](std::size_t slice) {
        nodes_.add(slice, boxes_, G::volume, 2);
        nodes_.take_mean(slice);
    });
}

template <int D>
template <bool shared, bool rings>
void PackedStep<D>::begin_boxes()
{
    each_chunk([&](Chunk& c, Planes<D>& box) {
        box.plane = box.nodes() + 4;
        if (c.numbers.size() < G::count * box.plane) c.numbers.resize(G::count * box.plane);
        box.data = c.numbers.data();
        forget(box, 0, G::count);
        if constexpr (shared) mean_stress_to_cells<D, rings>(points_, c.points, box);
    });
    if constexpr (shared) share_means();
}

template <int D>
template <bool affine, bool shared, bool rings>
void PackedStep<D>::give_to_nodes(Given const& now)
{
    each_chunk([&](Chunk& c, Planes<D> const& box) {
        if constexpr (shared) forget(box, G::volume, 2);
        c.outcome.kinetic_before =
            to_grid<D, affine, shared, rings>(points_, c.points, now.shape, now.setup.cell, box, nodes_.planes());
        if (now.loaded()) loads_to_grid<D, rings>(points_, now.loads, c.points, now.shape, box);
    });
    share_boxes(G::mass, now.planes());
}

template <int D>
void PackedStep<D>::move_nodes(Given const& now, GrainContacts<D>& grains, Outcome& outcome)
{
    each_slice([&](std::size_t slice) {
        nodes_.add(slice, boxes_, G::mass, now.planes());
        if (now.loaded()) nodes_.add_loads(slice);
        now.setup.frame ? nodes_.template move<true>(slice, now.setup, now.field, now.dt)
                        : nodes_.template move<false>(slice, now.setup, now.field, now.dt);
        if (now.loaded()) nodes_.book_loads(slice, now.setup, now.dt);
        if (!grains.any()) nodes_.hold(slice, now.setup, now.time, now.dt);
    });
    if (!grains.any()) return;
    touch_grains(now, grains, outcome);
    each_slice([&](std::size_t slice) { nodes_.hold(slice, now.setup, now.time, now.dt); });
}

template <int D>
template <bool affine, bool musl, bool rings>
void PackedStep<D>::move_points(Given const& now)
{
    auto const room = room_of<D>(now.setup);
    each_chunk([&](Chunk& c, Planes<D> const& box) {
        if (now.loaded()) forget(box, G::again, D);
        auto const move = [&]<bool turning>() {
            return to_points<D, affine, musl, turning, rings>(points_, c.points, now.setup, now.field, now.shape,
                                                              now.dt, room, box, nodes_.planes());
        };
        Moved const moved = now.setup.frame ? move.template operator()<!rings>() : move.template operator()<false>();
        c.outcome.kinetic_after = moved.kinetic;
        c.outcome.booked.field_work += moved.round;
        c.outcome.field = moved.field;
        c.outcome.all_inside = moved.inside;
    });
}

//! Returns whether strain is felt from the nodes.
template <int D>
template <bool musl>
bool PackedStep<D>::set_strain_velocities(Setup<D> const& setup)
{
    if constexpr (musl) {
        share_boxes(G::again, D);
        each_slice([&](std::size_t slice) {
            nodes_.add(slice, boxes_, G::again, D);
            nodes_.set_strain_velocities(slice);
        });
        return true;
    }
    auto light = nodes_.sums().light;
    if (peers_) light = ranks::sums(*peers_, std::vector{light})[0];
    if (light == 0) return false;
    each_slice([&](std::size_t slice) { nodes_.pass_light_nodes(slice, setup); });
    return true;
}

template <int D>
template <bool musl, bool shared, bool rings>
void PackedStep<D>::find_gradients(Given const& now, bool gathered)
{
    auto const& nodes = nodes_.planes();
    each_chunk([&](Chunk& c, Planes<D> const& box) {  // musl always gathers
        gathered ? gradients<D, true, shared, rings>(points_, c.points, now.setup, now.shape, now.dt, box, nodes)
                 : gradients<D, musl, shared, rings>(points_, c.points, now.setup, now.shape, now.dt, box, nodes);
    });
    if constexpr (shared) share_means();
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
void PackedStep<D>::run(Given const& now, GrainContacts<D>& grains, Outcome& outcome)
{
    begin_boxes<shared, rings>();
    give_to_nodes<affine, shared, rings>(now);
    move_nodes(now, grains, outcome);
    move_points<affine, musl, rings>(now);
    bool const gathered = set_strain_velocities<musl>(now.setup);
    find_gradients<musl, shared, rings>(now, gathered);
    std::visit(
        [&](auto const& law) {
            if constexpr (requires { packed_law(law, now.dt); })
                deform<affine, shared, rings>(now.dt, packed_law(law, now.dt));
        },
        now.setup.law);
}

//! Of the points, which a field that changes works on.
template <int D>
void PackedStep<D>::book_potential(Setup<D> const& setup, double time, double sign)
{
    using C = PackedColumns<D>;
    Potential<D> const potential(setup, time);
    each_chunk([&](Chunk& c, Planes<D> const&) {
        double sum = 0;
        for (std::size_t k = c.points.begin; k < c.points.end; ++k) {
            Vec<D> place;
            for (std::size_t a = 0; a < D; ++a) place[static_cast<int>(a)] = points_[C::place + a][k];
            sum += points_[C::mass][k] * potential(place);
        }
        c.outcome.booked.field_work += sign * sum;
    });
}

template <int D>
void PackedStep<D>::add_up(Outcome& outcome)
{
    std::vector<Outcome> chunks;
    for (Chunk const& c : chunks_) chunks.push_back(c.outcome);
    auto sums = nodes_.sums();
    if (peers_) {
        chunks = ranks::all_rows(*peers_, chunks);
        auto const others = ranks::everyone(*peers_, sums);
        sums = {};
        for (auto const& some : others) sums.add(some);
    }
    for (Outcome const& o : chunks) {
        outcome.kinetic_before += o.kinetic_before, outcome.kinetic_after += o.kinetic_after;
        outcome.field += o.field, outcome.stress += o.stress;
        outcome.booked.plastic += o.booked.plastic;
        outcome.booked.field_work += o.booked.field_work;
        outcome.speed = std::max(outcome.speed, o.speed);
        outcome.all_inside &= o.all_inside, outcome.all_upright &= o.all_upright;
    }
    outcome.booked.damping += sums.damped.value();
    outcome.booked.sliding += sums.sliding.value();
    outcome.booked.external_work += sums.external.value();
    outcome.light_nodes = sums.light;
    outcome.nodes = static_cast<std::size_t>(sums.reached);
}

template <int D>
bool PackedStep<D>::go(Given const& now, GrainContacts<D>& grains, Outcome& outcome)
{
    Setup<D> const& setup = now.setup;
    if (!lay_out(setup)) return false;
    outcome = {};
    bool const changes = setup.frame && setup.frame->changes(now.time);
    if (changes) book_potential(setup, now.time, -1);
    auto const pick = [&]<bool affine, bool musl, bool rings = false>()
    {
        setup.shared_volume ? run<affine, musl, true, rings>(now, grains, outcome)
                            : run<affine, musl, false, rings>(now, grains, outcome);
    };
    bool const musl = setup.scheme == Scheme::musl;
    if (setup.symmetry == Symmetry::axial) {
        if constexpr (D == 2) pick.template operator()<true, true, true>();
    } else if (setup.affine)
        musl ? pick.template operator()<true, true>() : pick.template operator()<true, false>();
    else
        musl ? pick.template operator()<false, true>() : pick.template operator()<false, false>();
    if (changes) book_potential(setup, now.time + now.dt, 1);
    add_up(outcome);
    if (changes) outcome.booked.field_work += outcome.field;
    return true;
}

template <int D>
bool PackedStep<D>::step(Setup<D> const& setup, double time, double dt, std::span<Vec<D> const> loads,
                         GrainContacts<D>& grains, Outcome& outcome)
{
    Given const now{setup, time, dt, loads};
    if (threads_ == 1) return go(now, grains, outcome);
    using Clock = std::chrono::steady_clock;
    auto const begin = Clock::now();
    together_ = pace_.together();
    std::optional<sluice::Team::Awake> awake;
    if (together_) awake.emplace(*team_);
    bool const done = go(now, grains, outcome);
    pace_.took(std::chrono::duration<double>(Clock::now() - begin).count());
    return done;
}

template class PackedStep<2>;
template class PackedStep<3>;

}  // namespace mpm
