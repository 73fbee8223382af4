#pragma once

#include <numeric>

#include "coupler/base/team.hpp"
#include "participants/dem/packed_contacts.hpp"
#include "participants/dem/plain_contacts.hpp"

//! The pairs by several threads, each with a range of grains and the pairs that these own. What pairs of earlier ranges
//! do to its grains a thread computes itself, before the others begin to change histories: such pairs are computed
//! twice, on either side. A grain so adds up the pairs in which it is the other, ascending, then those that it owns:
//! the order in which one thread adds them as it goes through the list, so that no number of threads changes a bit.
namespace dem {

//! What a range makes besides the loads of its grains; kept from step to step.
template <int D>
struct RangeWork
{
    Pairs<D> reaching;  //!< a block of pairs of earlier ranges that touch
    std::vector<Push<D>> pushes, theirs;
    std::vector<SeamLoad<D>> seams;
};

//! The pairs of a block by fours: what they do to their second grains. Returns how many are done; `one` does those that
//! packs cannot.
template <Features F, class OnOne>
std::uint32_t add_reaching_fours(ContactLaw const& law, std::uint32_t count, State<3>& state, double dt,
                                 Pairs<3>& block, OnOne const& one) noexcept
{
    Grains<3>& g = state.grains;
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
    pass<F>(law, g, block, state.cell.images, numbers.data(), count / 4, dt, four, one);
    return count / 4 * 4;
}

//! Adds what pairs of earlier ranges do to the grains of one, by fours or one at a time. Changes nothing else.
template <Features F, bool fours, int D>
void add_reaching_pairs(ContactLaw const& law, Range const& range, State<D>& state, double dt,
                        RangeWork<D>& work) noexcept
{
    Grains<D>& g = state.grains;
    Pairs<D> const& pairs = state.pairs;
    Images<D> const& images = state.cell.images;
    Pairs<D>& block = work.reaching;
    Books theirs;
    auto const one = [&](std::uint32_t k) {
        work.theirs.clear();
        std::uint32_t const j = block.other[k];
        auto const load = load_of_pair<F>(law, g, block, images, block.owner[k], k, dt, theirs, work.theirs);
        if (!load) return;
        g.contact[j].force -= load->force;
        if constexpr (F.friction) g.contact[j].torque = g.contact[j].torque + load->on_j;
        if constexpr (F.ledger) add<F>(state.lossy, j, load->lossy, -1.0, load->lossy.on_j);
    };
    std::uint32_t count = 0;
    auto const do_block = [&] {
        std::uint32_t done = 0;
        if constexpr (fours) done = add_reaching_fours<F>(law, count, state, dt, block, one);
        for (; done < count; ++done) one(done);
        count = 0;
    };
    for (std::vector<std::uint32_t>* v : {&block.owner, &block.other, &block.image}) v->resize(sieve_block);
    block.sqrt_mass.resize(sieve_block);
    each_array(pairs.history, block.history, [](auto const&, auto& to) { to.resize(sieve_block); });
    for (std::uint32_t const slot : range.reaches) {
        std::uint32_t const i = pairs.owner[slot], j = pairs.other[slot];
        Vec<D> const apart = g.place[i].centre - centre_seen<F>(g.place[j].centre, pairs, slot, images);
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

template <Features F, bool fours, int D>
void add_shared_pair_forces(Setup<D> const& setup, State<D>& state, double dt, sluice::Team& team) noexcept
{
    // of the thread that steps: solvers that take turns share them
    static thread_local std::vector<RangeWork<D>> of_ranges;
    static thread_local std::vector<Books> of_groups;
    std::vector<Range> const& ranges = state.pairs.ranges;
    if (of_ranges.size() < ranges.size()) of_ranges.resize(ranges.size());
    if constexpr (F.ledger) of_groups.assign((state.grains.size() + grains_booked - 1) / grains_booked, {});
    RangeWork<D>* const work = of_ranges.data();
    Books* const books = of_groups.data();
    auto const each = [&](auto const& body) {
        team.share(static_cast<std::ptrdiff_t>(ranges.size()), 1, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
            for (auto r = static_cast<std::size_t>(from); r < static_cast<std::size_t>(to); ++r)
                body(ranges[r], work[r]);
        });
    };
    each(
        [&](Range const& range, RangeWork<D>& its) { add_reaching_pairs<F, fours>(setup.law, range, state, dt, its); });
    each([&, books](Range const& range, RangeWork<D>& its) {
        its.pushes.clear();
        its.seams.clear();
        Sink<D> const to{state, its.pushes, its.seams, range.end};
        auto const booked = [&](std::size_t group, Books const& sum) { books[group] = sum; };
        if constexpr (fours)
            add_pairs_of<F>(setup.law, range.begin, range.end, dt, to, booked);
        else
            add_plain_pairs_of<F>(setup.law, range.begin, range.end, dt, to, booked);
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
