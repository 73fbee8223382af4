#pragma once

#include <algorithm>
#include <cstddef>

#include "participants/dem/listed_contact.hpp"

//! The pairs one at a time.
namespace dem {

//! The pairs of grains from `begin` to `end`. `booked(group, books)` is called for each group of grains that is booked
//! together, of which `begin` begins one; with the ledger only.
template <Features F, int D, class OnBooks>
void add_plain_pairs_of(ContactLaw const& law, std::size_t begin, std::size_t end, double dt, Sink<D> const& to,
                        OnBooks&& booked) noexcept
{
    Pairs<D> const& pairs = to.state.pairs;
    for (; begin < end; begin += grains_booked) {
        Books books;
        [[maybe_unused]] Books theirs;  // of pairs whose first grain is another process's, which books them
        for (std::size_t i = begin; i < std::min(end, begin + grains_booked); ++i) {
            Books& in = F.ledger && to.state.grains.is_ghost(i) ? theirs : books;
            for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot)
                add_pair<F>(law, to, i, slot, dt, in);
        }
        if constexpr (F.ledger) booked(begin / grains_booked, books);
    }
}

//! All listed pairs.
template <Features F, int D>
void add_plain_pair_forces(Setup<D> const& setup, State<D>& state, double dt) noexcept
{
    Books all;
    ContactLaw const law = setup.law;
    add_plain_pairs_of<F, D>(law, 0, state.grains.size(), dt, {state, state.pushes, state.seams},
                             [&](std::size_t, Books const& books) { all.add(books); });
    if constexpr (F.ledger) all.add_to(state.booked);
}

}  // namespace dem
