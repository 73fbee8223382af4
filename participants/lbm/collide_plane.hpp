#pragma once

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/collide_central.hpp"

namespace lbm {

//! What the large-eddy model makes of a cell.
template <class V>
struct Eddy
{
    V inverse_density{}, normal_change{}, shear_change{};  //!< changes of p_xx and p_xy by 1/tau_eff, over 4
};

//! The body force on a cell, and half of it to its momentum. `place`: the cell's x, in a frame that turns.
template <Features F, class V>
[[gnu::always_inline]] inline void take_half_force(Relaxation const& r, V const& place, V& jx, V& jy, V& force_x,
                                                   V& force_y) noexcept
{
    force_x = r.force[0];
    force_y = r.force[1];
    if constexpr (F.frame) {
        force_x = force_x + r.slope[0] * place;
        force_y = force_y + r.slope[1] * place;
    }
    jx = jx + 0.5 * force_x;
    jy = jy + 0.5 * force_y;
    if constexpr (F.frame) {
        turn_in_plane(r.turn[2], jx, jy);
        force_x = force_x + 2.0 * r.turn[2] * jy;
        force_y = force_y - 2.0 * r.turn[2] * jx;
    }
}

//! What the solids of a cell push it with, -2 B (j - rho u_s); it is told what bodies need of it.
template <class V>
[[gnu::always_inline]] inline std::array<V, 2> find_push(SolidCell<2, V>& s, V const& rho, V const& jx,
                                                         V const& jy) noexcept
{
    V const weight2 = 2.0 * s.weight, solid2 = weight2 * s.fraction;  // 2 B/eps, 2 B
    V const rate = weight2 * rho;
    s.force_rate = rate;
    s.force = {weight2 * jx, weight2 * jy};
    return {madd(rate, s.momentum[0], -solid2 * jx), madd(rate, s.momentum[1], -solid2 * jy)};
}

//! The large-eddy model: nu_t = (C_s dx)^2 |S_ij|, S_ij from the non-equilibrium stress of the cell itself, in closed
//! form:
//!     tau_eff = (tau + sqrt(tau^2 + A/rho^2))/2,  A = 18 C_s^2 rho |(p_xx, 2 p_xy)|
//! Written with rho p, so that the roots wait for no division, and 1/rho for neither: what else a cell does then has no
//! need to wait for this.
template <Features F, class V>
[[gnu::always_inline]] inline Eddy<V> find_eddy_stress(std::array<V, 9> const& f, Relaxation const& r,
                                                       SolidCell<2, V> const& s, V const& place) noexcept
{
    V const even1 = f[1] + f[3], even2 = f[2] + f[4], even5 = f[5] + f[7], even6 = f[6] + f[8];
    V const odd5 = f[5] - f[7], odd6 = f[6] - f[8];
    V const rho = 1.0 + (f[0] + (even1 + even2) + (even5 + even6));
    V jx = f[1] - f[3] + (odd5 - odd6), jy = f[2] - f[4] + (odd5 + odd6);
    V force_x, force_y;
    if constexpr (F.force) take_half_force<F>(r, place, jx, jy, force_x, force_y);
    if constexpr (F.grains) {
        V const covered = s.weight * s.fraction, rate = s.weight * rho, before_x = jx, before_y = jy;
        jx = madd(rate, s.momentum[0], madd(-covered, jx, jx));
        jy = madd(rate, s.momentum[1], madd(-covered, jy, jy));
        if constexpr (F.central) force_x = force_x + 2.0 * (jx - before_x), force_y = force_y + 2.0 * (jy - before_y);
    }
    V normal = madd(rho, even1 - even2, madd(jy, jy, -jx * jx)), shear = madd(rho, even5 - even6, -jx * jy);
    if constexpr (F.force || (F.grains && F.central)) {
        normal = normal + (jx * force_x - jy * force_y);
        shear = shear + 0.5 * (jx * force_y + jy * force_x);
    }
    V const stress = root(madd(normal, normal, 4.0 * shear * shear)), rest = rho * r.tau;
    V rate = -0.5 / (rest + root(madd(r.smagorinsky_term, stress, rest * rest)));
    V const inverse_rho = 1.0 / rho;
    if constexpr (F.grains) rate = where_above(s.fraction, eddy_free, -0.25 * r.shear * inverse_rho, rate);
    return {inverse_rho, rate * normal, rate * shear};
}

//! Collides one cell of D2Q9, or several at once; with the large-eddy model, given what it makes of the cell.
//!
//! In moment space (Lallemand and Luo): m' = m + S - s (m + S/2 - m_eq), S the moments of Guo's force (Phys. Rev. E 65
//! (2002) 046308), so that the velocity holds half the force. Equilibrium: the second-order one.
//! Solids are such a force, -2 B (j - rho u_s), without Guo's even part, which is quadratic in u, and their cells are
//! more viscous (`open`, solid_weight.hpp). The body force acts on the whole cell: fluid at rest then stays at rest
//! under a disc too, and Solver gives the disc what the force on its share takes. Covered cells have no large-eddy
//! term: their stress is not that of a flow.
//!
//! Straight-line on purpose, and longer than the house rule: one basic block of independent operations.
template <Features F, class V>
[[gnu::always_inline]] inline void collide_cell(std::array<V, 9>& f, Relaxation const& r, SolidCell<2, V>& s,
                                                V const& place, Eddy<V> const& eddy) noexcept
{
    auto& [f0, f1, f2, f3, f4, f5, f6, f7, f8] = f;
    V const even1 = f1 + f3, odd1 = f1 - f3;
    V const even2 = f2 + f4, odd2 = f2 - f4;
    V const even5 = f5 + f7, odd5 = f5 - f7;
    V const even6 = f6 + f8, odd6 = f6 - f8;
    V const axes = even1 + even2, diagonals = even5 + even6;
    V const diagonal_x = odd5 - odd6, diagonal_y = odd5 + odd6;
    V const excess = f0 + axes + diagonals;  // rho - 1
    V const rho = 1.0 + excess;
    V jx = odd1 + diagonal_x, jy = odd2 + diagonal_y;
    V qx = madd(-2.0, odd1, diagonal_x), qy = madd(-2.0, odd2, diagonal_y);

    V force_x, force_y;
    if constexpr (F.force) take_half_force<F>(r, place, jx, jy, force_x, force_y);
    if constexpr (F.force) {
        qx = qx - 0.5 * force_x;
        qy = qy - 0.5 * force_y;
    }
    V total_x = force_x, total_y = force_y;  // on the fluid, the solids' included
    if constexpr (F.grains) {
        auto const [push_x, push_y] = find_push(s, rho, jx, jy);
        jx = jx + 0.5 * push_x;
        jy = jy + 0.5 * push_y;
        qx = qx - 0.5 * push_x;
        qy = qy - 0.5 * push_y;
        total_x = total_x + push_x;
        total_y = total_y + push_y;
    }
    V const inverse_rho = F.les ? eddy.inverse_density : 1.0 / rho;
    V const ux = jx * inverse_rho, uy = jy * inverse_rho;
    V const kinetic = 3.0 * madd(jx, ux, jy * uy);

    // distances from equilibrium
    V energy = madd(2.0, diagonals + excess, madd(-4.0, f0, -axes)) - kinetic;
    V square = madd(4.0, f0, madd(-2.0, axes, diagonals - excess)) + kinetic;
    V work, normal_work, shear_work;
    if constexpr (F.force) {
        work = 6.0 * (ux * force_x + uy * force_y);
        normal_work = 2.0 * (ux * force_x - uy * force_y);
        shear_work = ux * force_y + uy * force_x;
        energy = energy + 0.5 * work;
        square = square - 0.5 * work;
    }
    V normal_change = eddy.normal_change, shear_change = eddy.shear_change;
    if constexpr (!F.les) {
        V const rate = -0.25 * r.shear;
        normal_change = rate * (madd(jy, uy, madd(-jx, ux, even1 - even2)) + 0.5 * normal_work);
        shear_change = rate * (madd(-jx, uy, even5 - even6) + 0.5 * shear_work);
    }
    // changes of the moments, by the inverse's factors: e and eps/36, p/4, q/6
    V flux_rate = r.flux / 6, energy_rate = -r.energy / 36, square_rate = -r.square / 36;
    if constexpr (F.grains) {
        V const shear_share = stiffened(r.shear, s.open) / r.shear;
        flux_rate = (1.0 / 6) * loosened(r.flux, s.open);
        energy_rate = (-1.0 / 36) * stiffened(r.energy, s.open);
        square_rate = (-1.0 / 36) * stiffened(r.square, s.open);
        normal_change = normal_change * shear_share;
        shear_change = shear_change * shear_share;
    }
    V flux_x = flux_rate * (qx + jx), flux_y = flux_rate * (qy + jy);
    V energy_change = energy_rate * energy, square_change = square_rate * square;
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
    V const diagonal = madd(2.0, energy_change, square_change);
    V const axis = madd(-2.0, square_change, -energy_change);
    V axis_x = flux_x, axis_y = flux_y;
    V corner_x = -0.5 * flux_x, corner_y = -0.5 * flux_y;
    if constexpr (F.force || F.grains) {
        using Shares = MomentumShares<typename V::Number>;
        axis_x = madd(total_x, 0.5 * Shares::axis, axis_x);
        axis_y = madd(total_y, 0.5 * Shares::axis, axis_y);
        corner_x = madd(total_x, Shares::diagonal, corner_x);
        corner_y = madd(total_y, Shares::diagonal, corner_y);
    }
    V const along1 = axis + normal_change, along2 = axis - normal_change;
    V const along5 = diagonal + shear_change, along6 = diagonal - shear_change;
    V const corner5 = corner_x + corner_y, corner6 = corner_y - corner_x;
    f0 = madd(4.0, square_change - energy_change, f0);
    f1 = f1 + (along1 + axis_x);
    f3 = f3 + (along1 - axis_x);
    f2 = f2 + (along2 + axis_y);
    f4 = f4 + (along2 - axis_y);
    f5 = f5 + (along5 + corner5);
    f7 = f7 + (along5 - corner5);
    f6 = f6 + (along6 + corner6);
    f8 = f8 + (along6 - corner6);
}

//! One cell of D2Q9, or several at once, in central moments. `eddy`: of the large-eddy model, whose changes are of
//! quarters of the stress. As long as collide_cell, for the same reason.
template <Features F, class V>
[[gnu::always_inline]] inline void collide_central(std::array<V, 9>& f, Relaxation const& r, SolidCell<2, V>& s,
                                                   V const& place, Eddy<V> const& eddy) noexcept
{
    constexpr bool force = F.force || F.grains;
    using High = HighMoments<force, V>;
    V const even1 = f[1] + f[3], even2 = f[2] + f[4], even5 = f[5] + f[7], even6 = f[6] + f[8];
    V const odd5 = f[5] - f[7], odd6 = f[6] - f[8], diagonals = even5 + even6;
    V const excess = f[0] + (even1 + even2) + diagonals, rho = 1.0 + excess;
    V jx = f[1] - f[3] + (odd5 - odd6), jy = f[2] - f[4] + (odd5 + odd6);
    V Fx{}, Fy{};
    if constexpr (F.force) take_half_force<F>(r, place, jx, jy, Fx, Fy);
    if constexpr (F.grains) {
        auto const [push_x, push_y] = find_push(s, rho, jx, jy);
        jx = jx + 0.5 * push_x, jy = jy + 0.5 * push_y;
        Fx = Fx + push_x, Fy = Fy + push_y;
    }
    V const inverse_rho = F.les ? eddy.inverse_density : 1.0 / rho;
    V const ux = jx * inverse_rho, uy = jy * inverse_rho;
    V xx = jx * ux, yy = jy * uy, xy = jx * uy;  // of what moves with u
    if constexpr (force) xx = xx + ux * Fx, yy = yy + uy * Fy, xy = xy + 0.5 * (ux * Fy + uy * Fx);
    V normal = even1 - even2 - (jx * ux - jy * uy), shear = even5 - even6 - jx * uy;  // the stress
    if constexpr (force) normal = normal + (ux * Fx - uy * Fy), shear = shear + 0.5 * (ux * Fy + uy * Fx);
    V const pressure = excess * (1.0 / 3);
    V third = rho * (1.0 / 3), left, trace;  // half of it, beyond a Maxwellian's
    std::array<V, 3> beyond;
    if constexpr (F.grains) {
        trace = madd(0.5, even1 + even2, diagonals) - pressure + 0.5 * (ux * (Fx - jx) + uy * (Fy - jy));
        High const maxwellian(rho, excess, ux, uy, third + trace + 0.5 * normal, third + trace - 0.5 * normal, shear,
                              -Fx, -Fy);
        beyond = maxwellian.to(odd5 + odd6, odd5 - odd6, diagonals);
        left = left_by_solids(s.open);
        trace = left * trace;
        third = third + trace, xx = xx + trace, yy = yy + trace;
    }
    if constexpr (F.les) {
        V const change = F.grains ? 4.0 / r.shear * stiffened(r.shear, s.open) : V(4.0);
        normal = madd(change, eddy.normal_change, normal), shear = madd(change, eddy.shear_change, shear);
    } else {
        V const stress_left = F.grains ? 1.0 - stiffened(r.shear, s.open) : V(1.0 - r.shear);
        normal = stress_left * normal, shear = stress_left * shear;
    }
    V const half = 0.5 * normal;
    High high(rho, excess, ux, uy, third + half, third - half, shear, Fx, Fy);
    if constexpr (F.grains) high.add_left(beyond, ux, uy, left);
    xx = xx + (pressure + half), yy = yy + (pressure - half), xy = xy + shear;
    V const along_x = jx + 0.5 * Fx - high.abb, along_y = jy + 0.5 * Fy - high.aab;
    Corners<V> const corners(high, xy);
    f[0] = excess - (xx + yy) + high.aabb;
    f[1] = 0.5 * (xx - high.aabb + along_x);
    f[3] = 0.5 * (xx - high.aabb - along_x);
    f[2] = 0.5 * (yy - high.aabb + along_y);
    f[4] = 0.5 * (yy - high.aabb - along_y);
    f[5] = corners.even_plus + corners.odd_plus;
    f[7] = corners.even_plus - corners.odd_plus;
    f[8] = corners.even_minus + corners.odd_minus;
    f[6] = corners.even_minus - corners.odd_minus;
}

//! A cell and those after it in its row that V has room for.
template <Features F, class V, class Stored>
struct PlaneCell
{
    std::array<V, 9> f;
    SolidCell<2, V> solid;
    V place;

    [[gnu::always_inline]] PlaneCell(Slots<2, Stored> const& slots, SolidRow<Stored> const& row, std::ptrdiff_t at,
                                     std::ptrdiff_t first) noexcept
    {
#pragma GCC unroll 9
        for (std::size_t q = 0; q < 9; ++q) f[q] = in_register(load<V>(slots[q] + at));
        if constexpr (F.grains) solid = SolidCell<2, V>(row, at);
        if constexpr (F.frame) place = counted_from<V>(static_cast<double>(first + at));
    }
    [[gnu::always_inline]] void put_back(Slots<2, Stored> const& slots, SolidRow<Stored> const& row,
                                         std::ptrdiff_t at) const noexcept
    {
#pragma GCC unroll 9
        for (std::size_t q = 0; q < 9; ++q) {
            store(slots[q] + at, f[q]);
            ask_ahead<2>(slots[q] + at);
        }
        if constexpr (F.grains) solid.tell(row, at);
    }
};

//! Collides cells in whole registers, in place. x = 0 is the row's cell `first`.
template <Features F, class V, class Stored>
void collide_whole(Slots<2, Stored> const& slots, SolidRow<Stored> const& row, CellRows const& cells,
                   std::ptrdiff_t first, Relaxation const& relaxation)
{
    Slots<2, Stored> const f = slots;
    Relaxation const r = relaxation;
    SolidRow<Stored> const s = row;
    cells.each_register<static_cast<std::ptrdiff_t>(V::count)>([&](std::ptrdiff_t at) __attribute__((always_inline)) {
        PlaneCell<F, V, Stored> cell(f, s, at, first);
        Eddy<V> eddy;
        if constexpr (F.les) eddy = find_eddy_stress<F>(cell.f, r, cell.solid, cell.place);
        if constexpr (F.central)
            collide_central<F, V>(cell.f, r, cell.solid, cell.place, eddy);
        else
            collide_cell<F, V>(cell.f, r, cell.solid, cell.place, eddy);
        cell.put_back(f, s, at);
    });
}

//! Collides cells of D2Q9 in place, in numbers of V.
template <Features F, class V, class Stored>
void collide(AnySlots<2> const& slots, CellRows const& cells, Relaxation const& relaxation, AnySolidRow const& solid)
{
    in_whole_registers<2, F.grains, V>(
        typed<2, Stored>(slots), solid.typed<Stored>(), cells,
        [&](Slots<2, Stored> const& f, SolidRow<Stored> const& s, CellRows const& whole, std::ptrdiff_t first) {
            collide_whole<F, V>(f, s, whole, first, relaxation);
        });
}

}  // namespace lbm
