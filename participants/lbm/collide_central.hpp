#pragma once

#include "participants/lbm/cell_row.hpp"

//! Collision in central moments, those about the velocity of the cell: the deviatoric stress relaxes by the viscosity;
//! its trace, and all of higher order, are those of a Maxwellian at once (Geier, Greiner and Korvink, Phys. Rev. E 73
//! (2006) 066705; with a force De Rosis, Phys. Rev. E 95 (2017) 023311). What a cell becomes depends on its density,
//! velocity and stress alone.
//!
//! Solids in a cell are a force, too, -2 B (j - rho u_s), and make its stress more viscous (`open`, solid_weight.hpp).
//! Of what else it has beyond a Maxwellian, nothing in a fluid, they leave (1 - open)/(1 + open) of the even moments,
//! and as much with the other sign of the odd ones: what `stiffened` and `loosened` make of rates of 1. A cell that is
//! covered wholly then throws back what comes in, seen from the solid.
namespace lbm {

//! Raw moments of third and fourth order, less those of the weights, in the plane of two axes a and b, after a
//! collision. k: central moments of second order, those of a Maxwellian not taken off; u, force: of both axes.
template <bool force, class V>
struct HighMoments
{
    V aab, abb, aabb;

    [[gnu::always_inline]] HighMoments(V const& rho, V const& excess, V const& ua, V const& ub, V const& kaa,
                                       V const& kbb, V const& kab, V const& Fa, V const& Fb) noexcept
    {
        V const both = ua * ub, two_kab = 2.0 * kab, square_a = ua * ua, square_b = ub * ub;
        V const bulk_a = madd(rho, square_a, kaa), bulk_b = madd(rho, square_b, kbb);
        aab = madd(ub, bulk_a, ua * two_kab);
        abb = madd(ua, bulk_b, ub * two_kab);
        aabb = madd(square_a, kbb, madd(square_b, bulk_a, madd(2.0 * both, two_kab, excess * (1.0 / 9))));
        if constexpr (force) {  // half of it: the source of a moment that relaxes at once
            V const third_a = madd(3.0, square_a, V(1.0)) * (1.0 / 6),
                    third_b = madd(3.0, square_b, V(1.0)) * (1.0 / 6);
            aab = madd(third_a, Fb, madd(both, Fa, aab));
            abb = madd(third_b, Fa, madd(both, Fb, abb));
            aabb = madd(2.0 * ua * third_b, Fa, madd(2.0 * ub * third_a, Fb, aabb));
        }
    }

    //! By how much those of a cell are others.
    [[gnu::always_inline]] std::array<V, 3> to(V const& of_aab, V const& of_abb, V const& of_aabb) const noexcept
    {
        return {of_aab - aab, of_abb - abb, of_aabb - aabb};
    }
    //! Adds what solids leave of what a cell had beyond a Maxwellian: of odd central moments -left, of even ones left.
    [[gnu::always_inline]] void add_left(std::array<V, 3> const& beyond, V const& ua, V const& ub,
                                         V const& left) noexcept
    {
        V const carried = 2.0 * madd(ub, beyond[0], ua * beyond[1]);  // of the fourth order: by the velocity
        aab = madd(-left, beyond[0], aab);
        abb = madd(-left, beyond[1], abb);
        aabb = madd(left, beyond[2] - 2.0 * carried, aabb);
    }
};

//! What solids leave of central moments that a fluid loses at once.
template <class V>
[[gnu::always_inline]] inline V left_by_solids(V const& open) noexcept
{
    return (1.0 - open) / (1.0 + open);
}

//! Two axes: what leaves along each, and along both, from the moments.
template <class V>
struct Corners
{
    V even_plus, even_minus, odd_plus, odd_minus;  //!< along (1, 1) and (1, -1)

    template <bool force>
    [[gnu::always_inline]] Corners(HighMoments<force, V> const& high, V const& ab) noexcept
        : even_plus(0.25 * (high.aabb + ab)),
          even_minus(0.25 * (high.aabb - ab)),
          odd_plus(0.25 * (high.aab + high.abb)),
          odd_minus(0.25 * (high.abb - high.aab))
    {}
};

}  // namespace lbm
