#pragma once

#include "participants/dem/listed_contact.hpp"
#include "participants/dem/packed_rows.hpp"

//! What the ledger books of four contacts at a time: to the last bit what lossy_loads.hpp and contact.hpp book of one.
namespace dem {

//! What the ledger needs of four contacts; nothing without it.
template <bool ledger>
struct FourLosses
{};
template <>
struct FourLosses<true>
{
    PackVec normal, tangential, on_i, on_j, rolling;  //!< as in LossyLoad
    PackMask slides;
    Pack slid, rolled;      //!< taken from the springs [J]
    Pack touch = all(0.0);  //!< of a spring that is no straight line, over the step [J]
};

//! Books what the springs of those of four contacts lost that are marked.
template <Features F>
inline void book(FourLosses<true> const& lost, unsigned marked, Books& books) noexcept
{
    for (std::size_t k = 0; k < 4; ++k) {
        if (!(marked >> k & 1U)) continue;
        if constexpr (F.elasticity != Elasticity::linear) books.touch += lost.touch[k];
        books.sliding += lost.slid[k];
        if constexpr (F.rolling == Rolling::elastic_plastic) books.rolling += lost.rolled[k];
    }
}

//! As spring_loss() in contact.hpp.
inline Pack spring_loss(PackVec before, Pack stiffness_before, PackVec after, Pack stiffness,
                        PackVec displacement) noexcept
{
    auto const energy = [](PackVec f, Pack k) { return either(k > all(0.0), all(0.5) * dot(f, f) / k, all(0.0)); };
    Pack const work = all(0.5) * dot(before + after, displacement);
    return work - (energy(after, stiffness) - energy(before, stiffness_before));
}

//! The parts of one contact's load that are not elastic, as rows of 32 bytes (LossyLoad).
struct LossyRow
{
    Pack normal, tangential, on_i, on_j, rolling;
    bool slides;
};
template <Features F>
[[gnu::always_inline]] inline std::array<LossyRow, 4> rows(FourLosses<true> const& f, bool tangential) noexcept
{
    std::array<LossyRow, 4> row;
    auto const normal = rows(f.normal);
    unsigned const slides = bits(f.slides);
    for (std::size_t k = 0; k < 4; ++k) row[k].normal = normal[k], row[k].slides = (slides >> k & 1U) != 0;
    if (tangential) {
        auto const force = rows(f.tangential), on_i = rows(f.on_i), on_j = rows(f.on_j);
        for (std::size_t k = 0; k < 4; ++k) row[k].tangential = force[k], row[k].on_i = on_i[k], row[k].on_j = on_j[k];
    }
    if constexpr (F.rolling != Rolling::none) {
        auto const torque = rows(f.rolling);
        for (std::size_t k = 0; k < 4; ++k) row[k].rolling = torque[k];
    }
    return row;
}

//! As add() in lossy_loads.hpp.
template <Features F>
[[gnu::always_inline]] inline void add(LossyLoads<3>& loads, std::size_t grain, LossyRow const& row, Pack sign,
                                       Pack torque) noexcept
{
    auto const to = [](Load<3>& load, std::size_t offset, Pack more) {
        auto* const at = reinterpret_cast<double*>(&load) + offset;
        store(at, dem::load(at) + more);
    };
    to(loads.press_and_roll[grain], 0, sign * row.normal);
    if constexpr (F.rolling != Rolling::none) to(loads.press_and_roll[grain], of_spin, sign * row.rolling);
    if (!loads.tangential.empty()) {
        Load<3>& kind = (row.slides ? loads.sliding : loads.tangential)[grain];
        to(kind, 0, sign * row.tangential);
        to(kind, of_spin, torque);
    }
}
inline LossyForces<3> lossy_forces(LossyRow const& row, bool tangential) noexcept
{
    auto const vector = [](Pack p) { return Vec3{p[0], p[1], p[2]}; };
    LossyForces<3> forces{vector(row.normal), {}, {}};
    if (tangential) (row.slides ? forces.sliding : forces.tangential) = vector(row.tangential);
    return forces;
}

//! Bit k: the grain is no ghost.
inline unsigned ours(Grains<3> const& g, Four const& grain) noexcept
{
    unsigned all = 0;
    for (unsigned k = 0; k < 4; ++k) all |= (g.is_ghost(grain[k]) ? 0U : 1U) << k;
    return all;
}

}  // namespace dem
