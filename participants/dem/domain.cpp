#include "participants/dem/domain.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/dem/neighbours.hpp"
#include "participants/dem/periodic_neighbours.hpp"

namespace dem {
namespace {

constexpr double most_uneven = 0.05;  //!< slabs are chosen anew when one holds so much more than when they were chosen
constexpr double rounding = 1.0 + 1e-9;  //!< of reaches: a pair at the list's very edge is seen by both

//! What is the same everywhere but for the grains, from process 0 to all.
template <int D>
struct Common
{
    double time = 0.0;
    std::int64_t steps = 0, rebuilds = 0;
    std::uint64_t grains = 0;
    double smallest_radius = 0.0, largest_radius = 0.0;
};
template <int D>
struct CommonWall
{
    bool active = true;
    Vec<D> shift, built_shift, velocity;
};

//! What partners are told of a grain in each window.
template <int D>
struct MotionRow
{
    std::uint32_t number;  //!< of the grain in the run
    Vec<D> centre;
    Motion<D> motion;
};

template <int D>
void spread_walls(ranks::Peers& peers, std::vector<WallContacts<D>>& walls)
{
    std::vector<CommonWall<D>> rows;
    for (auto const& wall : walls) rows.push_back({wall.active, wall.shift, wall.built_shift, wall.velocity});
    rows = ranks::from_first(peers, rows);
    for (std::size_t w = 0; w < walls.size(); ++w) {
        walls[w].active = rows[w].active;
        walls[w].shift = rows[w].shift;
        walls[w].built_shift = rows[w].built_shift;
        walls[w].velocity = rows[w].velocity;
    }
}

//! Calls `each` for the numbers that are sums over processes.
template <int D, class Each>
void each_sum(State<D>& state, Each&& each)
{
    using Numbers = std::array<double, (sizeof(Booked) + sizeof(LossyPower)) / sizeof(double)>;
    struct Sums
    {
        Booked booked;
        LossyPower power;
    };
    auto numbers = std::bit_cast<Numbers>(Sums{state.booked, state.power});
    for (double& number : numbers) each(number);
    auto const sums = std::bit_cast<Sums>(numbers);
    state.booked = sums.booked;
    state.power = sums.power;
    for (auto& wall : state.walls) each_number(wall.force, each);
    for (auto& pull : state.cell.pull) each_number(pull, each);
}

//! Calls `each` for the numbers of what a ghost has from its owner.
template <int D, class Each>
void spread(Motion<D>& motion, Load<D>& load, Each&& each)
{
    each_number(motion.velocity, each);
    each_number(motion.spin, each);
    each_number(load.force, each);
    each_number(load.torque, each);
}
template <int D>
constexpr std::size_t numbers_of_ghost = D == 2 ? 6 : 12;

}  // namespace

template <int D>
void require_shareable(Setup<D> const& setup)
{
    sluice::require(!setup.sleep.any(), [] {
        return sluice::Error(
            "dem: grains that may sleep cannot be shared out among processes (needed: ranks: 1). Try without `sleep`.");
    });
}
template void require_shareable<2>(Setup<2> const&);
template void require_shareable<3>(Setup<3> const&);

template <int D>
double Domain<D>::sum(double mine)
{
    double all = 0.0;
    for (double const number : peers_.numbers(mine)) all += number;
    return all;
}

template <int D>
void Domain<D>::distribute(Setup<D> const& setup, State<D>& state)
{
    state.walls.resize(setup.walls.size());
    agree(state);
    if (peers_.rank() != 0) {  // its own part is nothing yet
        state.grains = {};
        state.built.clear();
        state.booked = {};
        state.power = {};
        state.cell.pull = {};
        for (auto& wall : state.walls) wall.force = {};
    }
    census_.number.resize(state.grains.size());
    for (std::uint32_t i = 0; i < census_.number.size(); ++i) census_.number[i] = i;
    census_.owner.assign(state.grains.size(), 0);
    if (peers_.rank() != 0) {
        state.pairs = {};
        state.pairs.first = {0};
        for (auto& wall : state.walls) forget_contacts(wall);
    }
    if (slabs_.bounds.empty() || is_uneven(state)) choose_slabs(state);  // a run that goes back keeps them
    // the lists are those that were: of where all was when they were built
    Cell<D> const cell = state.cell;
    set_as_built(setup.periodic, state.cell);
    ship(setup, state);
    std::vector<Vec<D>> now, shifts;
    auto const rebuilds = state.rebuilds;
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        now.push_back(std::exchange(state.grains.place[i].centre, state.built[i]));
    for (auto& wall : state.walls) shifts.push_back(std::exchange(wall.shift, wall.built_shift));
    list_neighbours(setup, state);
    state.cell = cell;
    for (std::size_t i = 0; i < state.grains.size(); ++i) state.grains.place[i].centre = now[i];
    for (std::size_t w = 0; w < state.walls.size(); ++w) state.walls[w].shift = shifts[w];
    state.rebuilds = rebuilds;
}

//! What process 0 knows of the run; radii and how many grains there are.
template <int D>
void Domain<D>::agree(State<D>& state)
{
    Common<D> mine{state.time, state.steps, state.rebuilds, state.grains.size(), 0.0, 0.0};
    if (!state.grains.place.empty()) mine.smallest_radius = mine.largest_radius = state.grains.place[0].radius;
    for (auto const& place : state.grains.place) {
        mine.smallest_radius = std::min(mine.smallest_radius, place.radius);
        mine.largest_radius = std::max(mine.largest_radius, place.radius);
    }
    Common<D> const first = ranks::from_first(peers_, std::vector{mine})[0];
    state.time = first.time;
    state.steps = first.steps;
    state.rebuilds = first.rebuilds;
    census_.all = first.grains;
    smallest_radius_ = first.smallest_radius;
    largest_radius_ = first.largest_radius;
    spread_walls(peers_, state.walls);
    state.cell = ranks::from_first(peers_, std::vector{state.cell})[0];
}

template <int D>
void Domain<D>::rebuild(Setup<D> const& setup, State<D>& state)
{
    check_finite(state);
    if (setup.features.periodic) put_back(setup.periodic, state);
    for (std::size_t i = 0; i < state.grains.size(); ++i) state.built[i] = state.grains.place[i].centre;
    if (is_uneven(state)) {
        choose_slabs(state);
        ++moves_;
    }
    ship(setup, state);
    list_neighbours(setup, state);
}

template <int D>
void Domain<D>::choose_slabs(State<D> const& state)
{
    std::vector<Vec<D>> own;
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        if (census_.owner[i] == peers_.rank()) own.push_back(state.built[i]);
    slabs_ = even_slabs<D>(peers_, own);
    chosen_imbalance_ = imbalance(state);
}

//! The most grains in a slab over their mean.
template <int D>
double Domain<D>::imbalance(State<D> const& state)
{
    std::vector<std::int64_t> count(static_cast<std::size_t>(peers_.count()), 0);
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        if (census_.owner[i] == peers_.rank()) ++count[static_cast<std::size_t>(slabs_.owner(state.built[i]))];
    count = ranks::sums(peers_, count);
    double const mean = static_cast<double>(census_.all) / static_cast<double>(count.size());
    return static_cast<double>(*std::max_element(count.begin(), count.end())) / std::max(mean, 1.0);
}

template <int D>
bool Domain<D>::is_uneven(State<D> const& state)
{
    return imbalance(state) > chosen_imbalance_ + most_uneven;
}

//! Calls `visit(process)` for all that have the grain, as their own or as a ghost, ascending.
template <int D>
template <class Visit>
void Domain<D>::each_viewer(Setup<D> const& setup, State<D> const& state, std::size_t i, Visit&& visit)
{
    double const reach = rounding * (state.grains.place[i].radius + largest_radius_ + setup.skin);
    viewers_.clear();
    auto const look_from = [&](Vec<D> const& point) {
        auto const [from, to] = slabs_.near(point, reach);
        for (int who = from; who <= to; ++who) viewers_.push_back(who);
    };
    if (!setup.features.periodic) look_from(state.built[i]);
    for (std::size_t image = 0; setup.features.periodic && image < image_count<D>; ++image)
        if (has_image(setup.periodic, image)) look_from(state.built[i] + state.cell.images[image].shift);
    std::sort(viewers_.begin(), viewers_.end());
    viewers_.erase(std::unique(viewers_.begin(), viewers_.end()), viewers_.end());
    for (int const who : viewers_) visit(who);
}

//! Each process's own grains, with the histories of their contacts, to the owners that the slabs now give them, and to
//! all who see them. The grains of the state are then those of the new slab and its ghosts; its lists have histories
//! only.
template <int D>
void Domain<D>::ship(Setup<D> const& setup, State<D>& state)
{
    Grains<D> const& g = state.grains;
    int const self = peers_.rank();
    std::vector<Shipment<D>> out(static_cast<std::size_t>(peers_.count()));
    for (std::size_t i = 0; i < g.size(); ++i) {
        if (census_.owner[i] != self) continue;
        int const owner = slabs_.owner(state.built[i]);
        each_viewer(setup, state, i, [&](int to_whom) {
            out[static_cast<std::size_t>(to_whom)].grains.push_back(row_of(state, census_, i, owner));
        });
    }
    for (auto const& [i, moved, sped] : state.crossings)
        if (census_.owner[i] == self)
            out[static_cast<std::size_t>(slabs_.owner(state.built[i]))].crossings.push_back(
                {census_.number[i], moved, sped});
    each_contact_row<D>(state, census_, [&](ContactRow<D> const& row, std::uint32_t i, std::uint32_t j) {
        if (census_.owner[i] != self || row.is_blank()) return;
        int const owner = slabs_.owner(state.built[i]), other = j < g.size() ? slabs_.owner(state.built[j]) : owner;
        out[static_cast<std::size_t>(owner)].contacts.push_back(row);
        if (other != owner) out[static_cast<std::size_t>(other)].contacts.push_back(row);
    });
    each_foot_row<D>(state, census_, [&](FootRow<D> const& row, std::uint32_t i) {
        out[static_cast<std::size_t>(slabs_.owner(state.built[i]))].feet.push_back(row);
    });
    std::vector<ranks::Bytes> bytes;
    for (auto const& shipment : out) bytes.push_back(shipment.to_bytes());
    Shipment<D> in;
    for (ranks::Bytes const& came : peers_.all_to_all(std::move(bytes))) in.add(came);
    assemble(in, setup.features, state, census_);
    state.grains.ghost.resize(state.grains.size());
    for (std::size_t i = 0; i < state.grains.size(); ++i) state.grains.ghost[i] = census_.owner[i] != self;
    lay_borders(setup, state);
}

//! Who sees which grains: both sides find the same from the slabs and the places where the lists are built.
template <int D>
void Domain<D>::lay_borders(Setup<D> const& setup, State<D> const& state)
{
    auto const peers = static_cast<std::size_t>(peers_.count());
    std::vector<std::vector<std::uint32_t>> shown(peers), seen(peers);
    for (std::uint32_t i = 0; i < state.grains.size(); ++i) {
        if (census_.owner[i] != peers_.rank()) {
            seen[static_cast<std::size_t>(census_.owner[i])].push_back(i);
            continue;
        }
        each_viewer(setup, state, i, [&](int who) {
            if (who != peers_.rank()) shown[static_cast<std::size_t>(who)].push_back(i);
        });
    }
    parcels_.clear();
    shown_.clear();
    seen_.clear();
    for (std::size_t p = 0; p < peers; ++p) {
        if (shown[p].empty() && seen[p].empty()) continue;
        ranks::Parcel parcel{.peer = static_cast<int>(p), .out = {}, .in = {}};
        parcel.out.resize(shown[p].size() * numbers_of_ghost<D>);
        parcel.in.resize(seen[p].size() * numbers_of_ghost<D>);
        parcels_.push_back(std::move(parcel));
        shown_.push_back(std::move(shown[p]));
        seen_.push_back(std::move(seen[p]));
    }
}

template <int D>
void Domain<D>::refresh(Grains<D>& g)
{
    for (std::size_t p = 0; p < parcels_.size(); ++p) {
        double* to = parcels_[p].out.data();
        for (std::uint32_t const i : shown_[p])
            spread(g.motion[i], g.contact[i], [&](double const& number) { *to++ = number; });
    }
    peers_.swap(parcels_);
    for (std::size_t p = 0; p < parcels_.size(); ++p) {
        double const* from = parcels_[p].in.data();
        for (std::uint32_t const i : seen_[p])
            spread(g.motion[i], g.contact[i], [&](double& number) { number = *from++; });
    }
}

template <int D>
void Domain<D>::deal(std::vector<Load<D>> const& loads, Grains<D>& g)
{
    std::vector<Load<D>> const dealt = ranks::from_first(peers_, loads);
    for (std::size_t i = 0; i < g.size(); ++i) g.external[i] = dealt[census_.number[i]];
}

template <int D>
void Domain<D>::gather_motion(Grains<D> const& g, Grains<D>& all)
{
    std::vector<MotionRow<D>> own;
    for (std::size_t i = 0; i < g.size(); ++i)
        if (!g.is_ghost(i)) own.push_back({census_.number[i], g.place[i].centre, g.motion[i]});
    std::vector<ranks::Bytes> out(static_cast<std::size_t>(peers_.count()));
    out[0] = ranks::to_bytes(own);
    for (ranks::Bytes const& came : peers_.all_to_all(std::move(out)))
        for (MotionRow<D> const& row : ranks::rows_of<MotionRow<D>>(came)) {
            all.place[row.number].centre = row.centre;
            all.motion[row.number] = row.motion;
        }
}

template <int D>
State<D> Domain<D>::gather(Setup<D> const& setup, State<D> const& state)
{
    bool const root = peers_.rank() == 0;
    Shipment<D> own;
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        if (census_.owner[i] == peers_.rank()) own.grains.push_back(row_of(state, census_, i, peers_.rank()));
    each_contact_row<D>(state, census_, [&](ContactRow<D> const& row, std::uint32_t i, std::uint32_t) {
        if (census_.owner[i] == peers_.rank()) own.contacts.push_back(row);
    });
    each_foot_row<D>(state, census_, [&](FootRow<D> const& row, std::uint32_t) { own.feet.push_back(row); });
    std::vector<ranks::Bytes> out(static_cast<std::size_t>(peers_.count()));
    out[0] = own.to_bytes();
    Shipment<D> in;
    for (ranks::Bytes const& came : peers_.all_to_all(std::move(out))) in.add(came);
    State<D> whole;
    whole.time = state.time;
    whole.steps = state.steps;
    whole.rebuilds = state.rebuilds;
    whole.walls = state.walls;
    whole.cell = state.cell;
    Census everybody{.all = census_.all, .number = {}, .owner = {}, .index_of = {}};
    assemble(in, setup.features, whole, everybody);
    derive_from_list(setup, whole.pairs, whole.grains.size());
    set_sqrt_masses(setup, whole.grains, whole.pairs);
    whole.booked = state.booked;
    whole.power = state.power;
    std::vector<double> parts;
    each_sum(whole, [&](double number) { parts.push_back(number); });
    parts = ranks::sums(peers_, parts);
    each_sum(whole, [&, at = std::size_t{0}](double& number) mutable { number = root ? parts[at++] : 0.0; });
    return whole;
}

template class Domain<2>;
template class Domain<3>;

}  // namespace dem
