#pragma once

#include "coupler/base/team.hpp"
#include "participants/dem/packed_contacts.hpp"

//! The pairs of spheres by several threads: first every touching pair's load is computed and kept, in blocks of the
//! list; then every grain gathers its own. A grain adds the pairs in which it is the other, ascending, then those that
//! it owns: this is the order in which one thread adds them as it goes through the list, so that no number of threads
//! changes a bit. What is kept costs about a fifth of the time of one thread.
namespace dem {

//! The load of one slot, as rows of 32 bytes.
struct alignas(32) KeptLoad
{
    Pack force, on_i, on_j;
};

inline void keep(FourForces const& f, FourPairs const& p, KeptLoad* kept) noexcept
{
    RowForces const r = rows(f);
    for (std::size_t k = 0; k < 4; ++k) kept[p.slot[k]] = {r.force[k], r.on_i[k], r.on_j[k]};
}

inline Pack row_of(Vec3 v) noexcept
{
    return Pack{v.x, v.y, v.z, 0.0};
}
inline LossyRow row_of(LossyLoad<3> const& l) noexcept
{
    return {row_of(l.normal), row_of(l.tangential), row_of(l.on_i), row_of(l.on_j), row_of(l.rolling), l.slides};
}

//! What the threads write between the two loops; kept from step to step.
struct Workspace
{
    std::vector<KeptLoad> kept;                //!< one a slot
    std::vector<LossyRow> lossy;               //!< one a slot, with the ledger
    std::vector<std::vector<Push<3>>> pushes;  //!< of each block
    std::vector<Books> books;                  //!< of each block
};

template <Features F>
void add_shared_pair_forces(Setup<3> const& setup, State<3>& state, double dt, sluice::Team& team) noexcept
{
    static thread_local Workspace work;  // of the thread that steps: solvers that take turns share it
    ContactLaw const law = setup.law;
    Grains<3>& g = state.grains;
    Pairs<3>& pairs = state.pairs;
    Images<3> const& images = state.cell.images;
    std::size_t const slots = pairs.other.size(), blocks = (slots + sieve_block - 1) / sieve_block;
    if (work.kept.size() < slots) work.kept.resize(slots);
    if (work.pushes.size() < blocks) work.pushes.resize(blocks);
    if (F.ledger && work.lossy.size() < slots) work.lossy.resize(slots);
    work.books.assign(blocks, {});
    KeptLoad* const kept = work.kept.data();
    std::vector<Push<3>>* const pushes = work.pushes.data();
    Books* const books = work.books.data();
    LossyRow* const lossy = work.lossy.data();
    bool const tangential = !state.lossy.tangential.empty();
    auto const by_threads = [&, kept, pushes, books, lossy](std::ptrdiff_t from, std::ptrdiff_t to) {
        std::array<std::uint32_t, sieve_block + 8> touching;
        [[maybe_unused]] Books theirs;
        for (auto block = static_cast<std::size_t>(from); block < static_cast<std::size_t>(to); ++block) {
            pushes[block].clear();
            auto const one = [&](std::uint32_t slot) {
                std::uint32_t const i = pairs.owner[slot];
                Books& book = F.ledger && g.is_ghost(i) ? theirs : books[block];
                auto const load = load_of_pair<F>(law, g, pairs, images, i, slot, dt, book, pushes[block]);
                if (!load) return;
                kept[slot] = {row_of(load->force), row_of(load->on_i), row_of(load->on_j)};
                if constexpr (F.ledger) lossy[slot] = row_of(load->lossy);
            };
            auto const four = [&](FourForces const& forces, [[maybe_unused]] FourLosses<F.ledger> const& lost,
                                  FourPairs const& p) {
                keep(forces, p, kept);
                if constexpr (F.ledger) {
                    auto const row = rows<F>(lost, tangential);
                    for (std::size_t k = 0; k < 4; ++k) lossy[p.slot[k]] = row[k];
                    book<F>(lost, ours(g, p.i), books[block]);
                }
            };
            std::size_t const begin = block * sieve_block, end = std::min(slots, begin + sieve_block);
            std::size_t const count = sieve<F>(g, pairs, images, begin, end, touching.data(), 0);
            pass<F>(law, g, pairs, images, touching.data(), count / 4, dt, four, one);
            for (std::size_t k = count / 4 * 4; k < count; ++k) one(touching[k]);
        }
    };
    team.share(static_cast<std::ptrdiff_t>(blocks), 1, by_threads);
    constexpr std::ptrdiff_t chunk = 256;  // grains at a time
    team.share(static_cast<std::ptrdiff_t>(g.size()), chunk, [&, kept, lossy](std::ptrdiff_t from, std::ptrdiff_t to) {
        for (auto i = static_cast<std::size_t>(from); i < static_cast<std::size_t>(to); ++i) {
            Pack force{}, torque{};
            for (std::uint32_t k = pairs.below_first[i]; k < pairs.below_first[i + 1]; ++k) {
                std::uint32_t const slot = pairs.below[k];
                if (!pairs.touched[slot]) continue;
                force = force - kept[slot].force;
                torque = torque + kept[slot].on_j;
                if constexpr (F.ledger) add<F>(state.lossy, i, lossy[slot], all(-1.0), lossy[slot].on_j);
            }
            for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
                if (!pairs.touched[slot]) continue;
                force = force + kept[slot].force;
                torque = torque + kept[slot].on_i;
                if constexpr (F.ledger) add<F>(state.lossy, i, lossy[slot], all(1.0), lossy[slot].on_i);
            }
            auto* const to_i = reinterpret_cast<double*>(&g.contact[i]);
            store(to_i, force);
            store(to_i + of_spin, torque);
        }
    });
    if constexpr (F.periodic)  // few, and in the order in which one thread comes to them
        for (std::uint32_t const slot : pairs.seam)
            if (pairs.touched[slot]) {
                auto* const through = reinterpret_cast<double*>(&state.cell.images[pairs.image[slot]].through);
                store(through, load(through) + kept[slot].force);
                if constexpr (F.ledger) add(state.lossy.image[pairs.image[slot]], lossy[slot], tangential);
            }
    for (std::size_t block = 0; block < blocks; ++block)
        state.pushes.insert(state.pushes.end(), pushes[block].begin(), pushes[block].end());
    if constexpr (F.ledger) {
        Books sum;
        for (std::size_t block = 0; block < blocks; ++block) sum.add(books[block]);
        sum.add_to(state.booked);
    }
}

}  // namespace dem
