#pragma once

#include <numeric>

#include "coupler/base/team.hpp"
#include "participants/dem/packed_contacts.hpp"

//! The pairs of spheres by several threads, each with a range of grains and the pairs that these own. What pairs of
//! earlier ranges do to its grains a thread computes itself, before the others begin to change histories: such pairs
//! are computed twice, on either side. A grain so adds up the pairs in which it is the other, ascending, then those
//! that it owns: the order in which one thread adds them as it goes through the list, so that no number of threads
//! changes a bit.
namespace dem {

//! What a range makes besides the loads of its grains; kept from step to step.
struct RangeWork
{
    Pairs<3> reaching;  //!< a block of pairs of earlier ranges that touch
    std::vector<Push<3>> pushes, theirs;
    std::vector<SeamLoad<3>> seams;
};

//! Adds what pairs of earlier ranges do to the grains of one. Changes nothing else.
template <Features F>
void add_reaching_pairs(ContactLaw const& law, Range const& range, State<3>& state, double dt, RangeWork& work) noexcept
{
    Grains<3>& g = state.grains;
    Pairs<3> const& pairs = state.pairs;
    Images<3> const& images = state.cell.images;
    Pairs<3>& block = work.reaching;
    Books theirs;
    auto const one = [&](std::uint32_t k) {
        work.theirs.clear();
        std::uint32_t const j = block.other[k];
        auto const load = load_of_pair<F>(law, g, block, images, block.owner[k], k, dt, theirs, work.theirs);
        if (!load) return;
        g.contact[j].force -= load->force;
        g.contact[j].torque = g.contact[j].torque + load->on_j;
        if constexpr (F.ledger) add<F>(state.lossy, j, load->lossy, -1.0, load->lossy.on_j);
    };
    auto const four = [&](FourForces const& forces, [[maybe_unused]] FourLosses<F.ledger> const& lost,
                          FourPairs const& p) {
        RowForces const r = rows(forces);
        for (std::size_t k = 0; k < 4; ++k) add(g.contact[p.j[k]], -r.force[k], r.on_j[k]);
        if constexpr (F.ledger) {
            auto const row = rows<F>(lost, !state.lossy.tangential.empty());
            for (std::size_t k = 0; k < 4; ++k) add<F>(state.lossy, p.j[k], row[k], all(-1.0), row[k].on_j);
        }
    };
    std::array<std::uint32_t, sieve_block> numbers;
    std::iota(numbers.begin(), numbers.end(), 0U);
    std::uint32_t count = 0;
    auto const do_block = [&] {
        pass<F>(law, g, block, images, numbers.data(), count / 4, dt, four, one);
        for (std::uint32_t k = count / 4 * 4; k < count; ++k) one(k);
        count = 0;
    };
    for (std::vector<std::uint32_t>* v : {&block.owner, &block.other, &block.image}) v->resize(sieve_block);
    block.sqrt_mass.resize(sieve_block);
    each_array(pairs.history, block.history, [](auto const&, auto& to) { to.resize(sieve_block); });
    for (std::uint32_t const slot : range.reaches) {
        std::uint32_t const i = pairs.owner[slot], j = pairs.other[slot];
        Vec3 const apart = g.place[i].centre - centre_seen<F>(g.place[j].centre, pairs, slot, images);
        double const reach = g.place[i].radius + g.place[j].radius;
        if (!(dot(apart, apart) < reach * reach)) continue;
        block.owner[count] = i;
        block.other[count] = j;
        if constexpr (F.periodic) block.image[count] = pairs.image[slot];
        block.sqrt_mass[count] = pairs.sqrt_mass[slot];
        each_array(pairs.history, block.history, [&](auto const& from, auto& to) { to[count] = from[slot]; });
        if (++count == sieve_block) do_block();
    }
    do_block();
}

template <Features F>
void add_shared_pair_forces(Setup<3> const& setup, State<3>& state, double dt, sluice::Team& team) noexcept
{
    static thread_local std::vector<RangeWork> of_ranges;  // of the thread that steps: solvers that take turns share it
    static thread_local std::vector<Books> of_groups;
    std::vector<Range> const& ranges = state.pairs.ranges;
    if (of_ranges.size() < ranges.size()) of_ranges.resize(ranges.size());
    if constexpr (F.ledger) of_groups.assign((state.grains.size() + grains_booked - 1) / grains_booked, {});
    RangeWork* const work = of_ranges.data();
    Books* const books = of_groups.data();
    auto const each = [&](auto const& body) {
        team.share(static_cast<std::ptrdiff_t>(ranges.size()), 1, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
            for (auto r = static_cast<std::size_t>(from); r < static_cast<std::size_t>(to); ++r)
                body(ranges[r], work[r]);
        });
    };
    each([&](Range const& range, RangeWork& its) { add_reaching_pairs<F>(setup.law, range, state, dt, its); });
    each([&, books](Range const& range, RangeWork& its) {
        its.pushes.clear();
        its.seams.clear();
        add_pairs_of<F>(setup.law, range.begin, range.end, dt, {state, its.pushes, its.seams, range.end},
                        [&](std::size_t group, Books const& sum) { books[group] = sum; });
    });
    for (std::size_t r = 0; r < ranges.size(); ++r) {
        state.pushes.insert(state.pushes.end(), work[r].pushes.begin(), work[r].pushes.end());
        state.seams.insert(state.seams.end(), work[r].seams.begin(), work[r].seams.end());
    }
    if constexpr (F.ledger) {
        Books sum;
        for (Books const& group : of_groups) sum.add(group);
        sum.add_to(state.booked);
    }
}

}  // namespace dem
