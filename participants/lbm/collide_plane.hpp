#pragma once

#include <algorithm>
#include <cmath>

#include "participants/lbm/cell_row.hpp"

namespace lbm {

inline constexpr std::ptrdiff_t eddy_block = 128;  //!< cells; an EddyBlock and 9 x 128 populations stay in cache

//! What the first pass of the large-eddy model finds of a block of cells.
struct EddyBlock
{
    alignas(64) double inverse_density[eddy_block];
    alignas(64) double normal_change[eddy_block], shear_change[eddy_block];  //!< of p_xx and p_xy by 1/tau_eff, over 4
};

//! The body force on the cell x of a row, and half of it to its momentum.
template <Features F>
[[gnu::always_inline]] inline void take_half_force(Relaxation const& r, std::ptrdiff_t x, double& jx, double& jy,
                                                   double& force_x, double& force_y) noexcept
{
    force_x = r.force[0];
    force_y = r.force[1];
    if constexpr (F.frame) {
        force_x += r.slope[0] * static_cast<double>(x);
        force_y += r.slope[1] * static_cast<double>(x);
    }
    jx += 0.5 * force_x;
    jy += 0.5 * force_y;
    if constexpr (F.frame) {
        turn_in_plane(r.turn[2], jx, jy);
        force_x += 2.0 * r.turn[2] * jy;
        force_y -= 2.0 * r.turn[2] * jx;
    }
}

//! First pass of the large-eddy model over [begin, end), at most eddy_block cells.
//! nu_t = (C_s dx)^2 |S_ij|, S_ij from the non-equilibrium stress of the cell itself, in closed form:
//!     tau_eff = (tau + sqrt(tau^2 + A/rho^2))/2,  A = 18 C_s^2 rho |(p_xx, 2 p_xy)|
//! Written with rho p, so that the roots wait for no division; 1/rho and 1/tau_eff = 2 rho/(rho tau + sqrt(rho^2 tau^2
//! + A)) share one. A pass of its own, because a division after two roots is a long wait: short iterations overlap.
//! Float roots with a Newton step, and roots run beside the collision of the cells before, were measured: slower.
template <Features F>
void find_eddy_stress(Slots<2> const& f, std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& r,
                      SolidRow const& s, EddyBlock& out)
{
    double const *const f0 = f[0], *const f1 = f[1], *const f2 = f[2], *const f3 = f[3], *const f4 = f[4],
                        *const f5 = f[5], *const f6 = f[6], *const f7 = f[7], *const f8 = f[8];
    double const* const fraction = s.fraction;
    double const tau = r.tau, term = r.smagorinsky_term, base = -0.25 * r.shear;
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        double const even1 = f1[x] + f3[x], even2 = f2[x] + f4[x], even5 = f5[x] + f7[x], even6 = f6[x] + f8[x];
        double const odd5 = f5[x] - f7[x], odd6 = f6[x] - f8[x];
        double const rho = 1.0 + (f0[x] + (even1 + even2) + (even5 + even6));
        double jx = f1[x] - f3[x] + (odd5 - odd6), jy = f2[x] - f4[x] + (odd5 + odd6);
        double force_x = 0.0, force_y = 0.0;
        if constexpr (F.force) take_half_force<F>(r, x, jx, jy, force_x, force_y);
        if constexpr (F.grains) {
            double const weight = s.weight[x], covered = weight * fraction[x], rate = weight * rho;
            jx = madd(rate, s.momentum[0][x], madd(-covered, jx, jx));
            jy = madd(rate, s.momentum[1][x], madd(-covered, jy, jy));
        }
        double normal = madd(rho, even1 - even2, madd(jy, jy, -jx * jx)), shear = madd(rho, even5 - even6, -jx * jy);
        if constexpr (F.force) {
            normal += jx * force_x - jy * force_y;
            shear += 0.5 * (jx * force_y + jy * force_x);
        }
        double const stress = std::sqrt(madd(normal, normal, 4.0 * (shear * shear)));
        double const rest = rho * tau, slow = rest + std::sqrt(madd(term, stress, rest * rest));
        double const both = 1.0 / (rho * slow);
        double const inverse_rho = slow * both;
        double rate = -0.5 * rho * both;
        if constexpr (F.grains) rate = fraction[x] > eddy_free ? base * inverse_rho : rate;
        out.inverse_density[x - begin] = inverse_rho;
        out.normal_change[x - begin] = rate * normal;
        out.shear_change[x - begin] = rate * shear;
    }
}

//! Collides the cells [begin, end) in place; with the large-eddy model, after its first pass.
//!
//! In moment space (Lallemand and Luo): m' = m + S - s (m + S/2 - m_eq), S the moments of Guo's force (Phys. Rev. E 65
//! (2002) 046308), so that the velocity holds half the force. Equilibrium: the second-order one.
//! Solids are such a force, -2 B (j - rho u_s), without Guo's even part, which is quadratic in u, and their cells are
//! more viscous (`open`, solid_weight.hpp). The body force acts on the whole cell: fluid at rest then stays at rest
//! under a disc too, and Solver gives the disc what the force on its share takes. Covered cells have no large-eddy
//! term: their stress is not that of a flow.
//!
//! Straight-line on purpose, and longer than the house rule: the compiler vectorises it as one loop.
template <Features F>
void collide_block(Slots<2> const& f, std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& relax,
                   SolidRow const& solid, EddyBlock const& eddy)
{
    double *const f0 = f[0], *const f1 = f[1], *const f2 = f[2], *const f3 = f[3], *const f4 = f[4], *const f5 = f[5],
                  *const f6 = f[6], *const f7 = f[7], *const f8 = f[8];
    Relaxation const r = relax;
    SolidRow const s = solid;
    double const energy_rate36 = -r.energy / 36, square_rate36 = -r.square / 36, shear_rate4 = -r.shear / 4;
    double const flux_rate6 = r.flux / 6;
#pragma omp simd
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        double const even1 = f1[x] + f3[x], odd1 = f1[x] - f3[x];
        double const even2 = f2[x] + f4[x], odd2 = f2[x] - f4[x];
        double const even5 = f5[x] + f7[x], odd5 = f5[x] - f7[x];
        double const even6 = f6[x] + f8[x], odd6 = f6[x] - f8[x];
        double const axes = even1 + even2, diagonals = even5 + even6;
        double const diagonal_x = odd5 - odd6, diagonal_y = odd5 + odd6;
        double const excess = f0[x] + axes + diagonals;  // rho - 1
        double const rho = 1.0 + excess;
        double jx = odd1 + diagonal_x, jy = odd2 + diagonal_y;
        double qx = madd(-2.0, odd1, diagonal_x), qy = madd(-2.0, odd2, diagonal_y);

        double force_x = 0.0, force_y = 0.0;
        if constexpr (F.force) take_half_force<F>(r, x, jx, jy, force_x, force_y);
        if constexpr (F.force) {
            qx -= 0.5 * force_x;
            qy -= 0.5 * force_y;
        }
        double total_x = force_x, total_y = force_y;  // on the fluid, the solids' included
        if constexpr (F.grains) {
            double const weight2 = 2.0 * s.weight[x], solid2 = weight2 * s.fraction[x];  // 2 B/eps, 2 B
            double const rate = weight2 * rho;
            double const push_x = madd(rate, s.momentum[0][x], -solid2 * jx),
                         push_y = madd(rate, s.momentum[1][x], -solid2 * jy);
            s.force_rate[x] = rate;
            s.force[0][x] = weight2 * jx;
            s.force[1][x] = weight2 * jy;
            jx += 0.5 * push_x;
            jy += 0.5 * push_y;
            qx -= 0.5 * push_x;
            qy -= 0.5 * push_y;
            total_x += push_x;
            total_y += push_y;
        }
        double inverse_rho;
        if constexpr (F.les)
            inverse_rho = eddy.inverse_density[x - begin];
        else
            inverse_rho = 1.0 / rho;
        double const ux = jx * inverse_rho, uy = jy * inverse_rho;
        double const kinetic = 3.0 * madd(jx, ux, jy * uy);

        // distances from equilibrium
        double energy = madd(2.0, diagonals + excess, madd(-4.0, f0[x], -axes)) - kinetic;
        double square = madd(4.0, f0[x], madd(-2.0, axes, diagonals - excess)) + kinetic;
        double work = 0, normal_work = 0, shear_work = 0;
        if constexpr (F.force) {
            work = 6.0 * (ux * force_x + uy * force_y);
            normal_work = 2.0 * (ux * force_x - uy * force_y);
            shear_work = ux * force_y + uy * force_x;
            energy += 0.5 * work;
            square -= 0.5 * work;
        }
        double normal_change, shear_change;
        if constexpr (F.les) {
            normal_change = eddy.normal_change[x - begin];
            shear_change = eddy.shear_change[x - begin];
        } else {
            normal_change = shear_rate4 * (madd(jy, uy, madd(-jx, ux, even1 - even2)) + 0.5 * normal_work);
            shear_change = shear_rate4 * (madd(-jx, uy, even5 - even6) + 0.5 * shear_work);
        }
        // changes of the moments, by the inverse's factors: e and eps/36, p/4, q/6
        double flux_rate = flux_rate6, energy_rate = energy_rate36, square_rate = square_rate36;
        if constexpr (F.grains) {
            double const open = s.open[x], shear_share = stiffened(r.shear, open) / r.shear;
            flux_rate = (1.0 / 6) * loosened(r.flux, open);
            energy_rate = (-1.0 / 36) * stiffened(r.energy, open);
            square_rate = (-1.0 / 36) * stiffened(r.square, open);
            normal_change *= shear_share;
            shear_change *= shear_share;
        }
        double flux_x = flux_rate * (qx + jx), flux_y = flux_rate * (qy + jy);
        double energy_change = energy_rate * energy, square_change = square_rate * square;
        if constexpr (F.force) {
            energy_change = madd(work, 1.0 / 36, energy_change);
            square_change = madd(work, -1.0 / 36, square_change);
            normal_change = madd(normal_work, 0.25, normal_change);
            shear_change = madd(shear_work, 0.25, shear_change);
        }
        if constexpr (F.force || F.grains) {
            flux_x = madd(total_x, 1.0 / 6, flux_x);
            flux_y = madd(total_y, 1.0 / 6, flux_y);
        }

        // back to populations
        double const diagonal = madd(2.0, energy_change, square_change);
        double const axis = madd(-2.0, square_change, -energy_change);
        double axis_x = flux_x, axis_y = flux_y;
        double corner_x = -0.5 * flux_x, corner_y = -0.5 * flux_y;
        if constexpr (F.force || F.grains) {
            axis_x = madd(total_x, 1.0 / 6, axis_x);
            axis_y = madd(total_y, 1.0 / 6, axis_y);
            corner_x = madd(total_x, 1.0 / 6, corner_x);
            corner_y = madd(total_y, 1.0 / 6, corner_y);
        }
        double const along1 = axis + normal_change, along2 = axis - normal_change;
        double const along5 = diagonal + shear_change, along6 = diagonal - shear_change;
        double const corner5 = corner_x + corner_y, corner6 = corner_y - corner_x;
        f0[x] = madd(4.0, square_change - energy_change, f0[x]);
        f1[x] += along1 + axis_x;
        f3[x] += along1 - axis_x;
        f2[x] += along2 + axis_y;
        f4[x] += along2 - axis_y;
        f5[x] += along5 + corner5;
        f7[x] += along5 - corner5;
        f6[x] += along6 + corner6;
        f8[x] += along6 - corner6;
    }
}

//! Collides the cells [begin, end) of one row in place.
template <Features F>
void collide(Slots<2> const& f, std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& relax,
             SolidRow const& solid)
{
    EddyBlock eddy;
    if constexpr (F.les) {
        for (std::ptrdiff_t x = begin; x < end; x += eddy_block) {
            std::ptrdiff_t const stop = std::min(x + eddy_block, end);
            find_eddy_stress<F>(f, x, stop, relax, solid, eddy);
            collide_block<F>(f, x, stop, relax, solid, eddy);
        }
    } else {
        collide_block<F>(f, begin, end, relax, solid, eddy);
    }
}

}  // namespace lbm
