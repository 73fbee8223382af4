#pragma once

#include <type_traits>

#include "participants/lbm/cell_row.hpp"

namespace lbm {

//! Collides one cell of D3Q19, or several at once, given its populations.
//!
//! By pairs of opposite directions, even part (f_q + f_-q)/2 and odd part (f_q - f_-q)/2 apart: with one rate for each
//! this is TRT (Ginzburg, Verhaeghe and d'Humieres, Commun. Comput. Phys. 3 (2008) 427), with equal ones BGK. `split`:
//! the stress has the rate of the viscosity, its trace that of the bulk viscosity, what is left of the even part (three
//! moments of fourth order) a third one: MRT in moments that are orthogonal with the weights w_q, in which the stress
//! is projected by w_q 9/2 (c c - I/3). All is f' = f + S - s (f + S/2 - f_eq), S Guo's force, as in the plane
//! (collide_plane.hpp). Solids are such a force, -2 B (j - rho u_s), without Guo's even part, which is quadratic in u,
//! and their cells are more viscous (`open`, solid_weight.hpp). Large eddies: tau_eff = (tau + sqrt(tau^2 + 18 sqrt(2)
//! C_s^2 |P|/rho))/2, P the stress without its trace.
//!
//! Straight-line on purpose, and longer than the house rule: one basic block of independent operations.
template <Features F, class V>
[[gnu::always_inline]] inline void collide_cell(std::array<V, 19>& f, Relaxation const& r, SolidCell<3, V>& s,
                                                V const& place) noexcept
{
    using Force = std::conditional_t<F.frame, V, double>;  // the same everywhere, or each cell's own
    constexpr bool split = F.les || F.split;
    constexpr double axis = 1.0 / 18, diagonal = 1.0 / 36;
    auto& [f0, fx, gx, fy, gy, fz, gz, fxy, gxy, fyx, gyx, fxz, gxz, fzx, gzx, fyz, gyz, fzy, gzy] = f;
    auto const stiff = [&](double rate) __attribute__((always_inline))
    {
        if constexpr (F.grains)
            return stiffened(rate, s.open);
        else
            return rate;
    };
    auto const even_rate = stiff(split ? r.square : r.shear);
    auto const loose = [&](double rate) __attribute__((always_inline))
    {
        if constexpr (F.grains)
            return loosened(rate, s.open);
        else
            return rate;
    };
    auto const flux_rate = loose(r.flux);
    Force Fx{}, Fy{}, Fz{};
    if constexpr (F.frame)
        Fx = r.force[0] + r.slope[0] * place, Fy = r.force[1] + r.slope[1] * place,
        Fz = r.force[2] + r.slope[2] * place;
    else if constexpr (F.force)
        Fx = r.force[0], Fy = r.force[1], Fz = r.force[2];

    V const ex = fx + gx, ey = fy + gy, ez = fz + gz;
    V const exy = fxy + gxy, eyx = fyx + gyx, exz = fxz + gxz, ezx = fzx + gzx, eyz = fyz + gyz, ezy = fzy + gzy;
    V const ox = fx - gx, oy = fy - gy, oz = fz - gz;
    V const oxy = fxy - gxy, oyx = fyx - gyx, oxz = fxz - gxz, ozx = fzx - gzx, oyz = fyz - gyz, ozy = fzy - gzy;
    V const excess = f0 + ((ex + ey) + (ez + (exy + eyx))) + ((exz + ezx) + (eyz + ezy));  // rho - 1
    V const rho = 1.0 + excess, inverse_rho = 1.0 / rho;
    V jx = ox + (oxy + oyx) + (oxz + ozx), jy = oy + (oxy - oyx) + (oyz + ozy), jz = oz + (oxz - ozx) + (oyz - ozy);
    if constexpr (F.force) jx = jx + 0.5 * Fx, jy = jy + 0.5 * Fy, jz = jz + 0.5 * Fz;
    if constexpr (F.frame) {
        turn_with_half(r.turn, jx, jy, jz);
        Fx = Fx - 2.0 * (r.turn[1] * jz - r.turn[2] * jy);
        Fy = Fy - 2.0 * (r.turn[2] * jx - r.turn[0] * jz);
        Fz = Fz - 2.0 * (r.turn[0] * jy - r.turn[1] * jx);
    }
    V Gx = Fx, Gy = Fy, Gz = Fz;  // force on the fluid, the solids' included
    if constexpr (F.grains) {
        V const slip_x = madd(jx * inverse_rho, s.fraction, -1.0 * s.momentum[0]),  // times eps
            slip_y = madd(jy * inverse_rho, s.fraction, -1.0 * s.momentum[1]),
                slip_z = madd(jz * inverse_rho, s.fraction, -1.0 * s.momentum[2]);
        s.weight =
            eased(s.weight, s.fraction, s.ease * root(madd(slip_x, slip_x, madd(slip_y, slip_y, slip_z * slip_z))));
        V const weight2 = 2.0 * s.weight, solid2 = weight2 * s.fraction;  // 2 B/eps, 2 B
        s.force_rate = weight2 * rho;
        s.force = {weight2 * jx, weight2 * jy, weight2 * jz};
        V const push_x = madd(s.force_rate, s.momentum[0], -solid2 * jx),
                push_y = madd(s.force_rate, s.momentum[1], -solid2 * jy),
                push_z = madd(s.force_rate, s.momentum[2], -solid2 * jz);
        jx = jx + 0.5 * push_x, jy = jy + 0.5 * push_y, jz = jz + 0.5 * push_z;
        Gx = Gx + push_x, Gy = Gy + push_y, Gz = Gz + push_z;
    }
    V const ux = jx * inverse_rho, uy = jy * inverse_rho, uz = jz * inverse_rho;

    // even parts: sums of both populations, less equilibrium (f + S/2 - f_eq); S = w (9 c.u c.F - work)
    V const base = madd(-1.5, madd(jx, ux, madd(jy, uy, jz * uz)), excess);
    V const work = F.force ? 3.0 * (ux * Fx + uy * Fy + uz * Fz) : V{};
    auto const source = [&](double weight, V cu, Force cF) __attribute__((always_inline))
    {
        return weight * ((9.0 * cF) * cu - work);
    };
    auto const apart = [&](V even, double weight, V cj, V cu, Force cF) __attribute__((always_inline))
    {
        V const distance = madd(-2.0 * weight, madd(4.5 * cj, cu, base), even);
        if constexpr (F.force)
            return distance + source(weight, cu, cF);
        else
            return distance;
    };
    V n0 = madd(-1.0 / 3, base, f0);
    if constexpr (F.force) n0 = madd(-1.0 / 6, work, n0);
    V const nx = apart(ex, axis, jx, ux, Fx), ny = apart(ey, axis, jy, uy, Fy), nz = apart(ez, axis, jz, uz, Fz);
    V const nxy = apart(exy, diagonal, jx + jy, ux + uy, Fx + Fy),
            nyx = apart(eyx, diagonal, jx - jy, ux - uy, Fx - Fy),
            nxz = apart(exz, diagonal, jx + jz, ux + uz, Fx + Fz),
            nzx = apart(ezx, diagonal, jx - jz, ux - uz, Fx - Fz),
            nyz = apart(eyz, diagonal, jy + jz, uy + uz, Fy + Fz),
            nzy = apart(ezy, diagonal, jy - jz, uy - uz, Fy - Fz);

    // what the stress changes beyond the common rate of the even part
    V along_x{}, along_y{}, along_z{}, shear_xy{}, shear_xz{}, shear_yz{}, bulk{};
    if constexpr (split) {
        V const xx = nx + (nxy + nyx) + (nxz + nzx), yy = ny + (nxy + nyx) + (nyz + nzy),
                zz = nz + (nxz + nzx) + (nyz + nzy);
        V const xy = nxy - nyx, xz = nxz - nzx, yz = nyz - nzy;
        V const trace = xx + yy + zz, mean = trace * (1.0 / 3);
        V const dx = xx - mean, dy = yy - mean, dz = zz - mean;
        V shear_rate = stiff(r.shear);
        if constexpr (F.les) {
            V const size = madd(dx, dx, madd(dy, dy, dz * dz)) + 2.0 * madd(xy, xy, madd(xz, xz, yz * yz));
            V const eddy =
                2.0 / (r.tau + root(madd(r.smagorinsky_term * inverse_rho, root(2.0 * size), r.tau * r.tau)));
            if constexpr (F.grains)
                shear_rate = where_above(s.fraction, eddy_free, shear_rate, eddy);
            else
                shear_rate = eddy;
        }
        V const more = 4.5 * (even_rate - shear_rate);
        along_x = more * dx, along_y = more * dy, along_z = more * dz;
        shear_xy = 2.0 * more * xy, shear_xz = 2.0 * more * xz, shear_yz = 2.0 * more * yz;
        bulk = (1.5 * (even_rate - stiff(r.energy))) * trace;
    }

    auto const even = -0.5 * even_rate;
    f0 = madd(2.0 * even, n0, f0);
    if constexpr (F.force) f0 = madd(-1.0 / 3, work, f0);
    if constexpr (split) f0 = madd(-1.0 / 3, bulk, f0);
    // odd parts: f + S/2 - f_eq; what both populations gain
    auto const collide_pair = [&](V & one, V & other, double weight, V apart_even, V stress, V difference, V cj, V cu,
                                  Force cF, V cG) __attribute__((always_inline))
    {
        V a = even * apart_even;
        if constexpr (split) a = madd(weight, stress, a);
        if constexpr (F.force) a = a + source(weight, cu, cF);
        V b = -flux_rate * madd(-3.0 * weight, cj, 0.5 * difference);
        if constexpr (F.force || F.grains) b = madd(3.0 * weight * (1.0 - 0.5 * flux_rate), cG, b);
        one = one + (a + b);
        other = other + (a - b);
    };
    collide_pair(fx, gx, axis, nx, along_x, ox, jx, ux, Fx, Gx);
    collide_pair(fy, gy, axis, ny, along_y, oy, jy, uy, Fy, Gy);
    collide_pair(fz, gz, axis, nz, along_z, oz, jz, uz, Fz, Gz);
    collide_pair(fxy, gxy, diagonal, nxy, bulk - along_z + shear_xy, oxy, jx + jy, ux + uy, Fx + Fy, Gx + Gy);
    collide_pair(fyx, gyx, diagonal, nyx, bulk - along_z - shear_xy, oyx, jx - jy, ux - uy, Fx - Fy, Gx - Gy);
    collide_pair(fxz, gxz, diagonal, nxz, bulk - along_y + shear_xz, oxz, jx + jz, ux + uz, Fx + Fz, Gx + Gz);
    collide_pair(fzx, gzx, diagonal, nzx, bulk - along_y - shear_xz, ozx, jx - jz, ux - uz, Fx - Fz, Gx - Gz);
    collide_pair(fyz, gyz, diagonal, nyz, bulk - along_x + shear_yz, oyz, jy + jz, uy + uz, Fy + Fz, Gy + Gz);
    collide_pair(fzy, gzy, diagonal, nzy, bulk - along_x - shear_yz, ozy, jy - jz, uy - uz, Fy - Fz, Gy - Gz);
}

//! Collides the cell x of a row and those after it that V has room for, in place. x = 0 is the row's cell `first`.
template <Features F, class V, class Stored>
[[gnu::always_inline]] inline void collide_at(Slots<3, Stored> const& slots, std::ptrdiff_t x, std::ptrdiff_t first,
                                              Relaxation const& r, SolidRow const& row) noexcept
{
    std::array<V, 19> f;
    SolidCell<3, V> s;
    V place;
#pragma GCC unroll 19
    for (std::size_t q = 0; q < 19; ++q) f[q] = load<V>(slots[q] + x);
    if constexpr (F.grains) s = SolidCell<3, V>(row, x);
    if constexpr (F.frame) place = counted_from<V>(static_cast<double>(first + x));
    collide_cell<F, V>(f, r, s, place);
#pragma GCC unroll 19
    for (std::size_t q = 0; q < 19; ++q) store(slots[q] + x, f[q]);
    if constexpr (F.grains) s.tell(row, x);
}

//! How far ahead lines are asked for: nineteen streams are more than the machine follows by itself.
inline constexpr std::ptrdiff_t lines_ahead = 6;

//! Collides the cells [begin, end) of a row, whole registers, in place. Behind its end the next row begins in memory.
template <Features F, class V, class Stored>
void collide_whole(Slots<3, Stored> const& slots, SolidRow const& row, std::ptrdiff_t begin, std::ptrdiff_t end,
                   std::ptrdiff_t first, Relaxation const& relaxation)
{
    constexpr auto lanes = static_cast<std::ptrdiff_t>(V::count);
    constexpr auto cells_a_line = static_cast<std::ptrdiff_t>(64 / sizeof(Stored));
    Slots<3, Stored> const f = slots;
    Relaxation const r = relaxation;
    SolidRow const s = row;
    for (std::ptrdiff_t x = begin; x < end; x += lanes) {
        if ((x - begin) % cells_a_line == 0)
#pragma GCC unroll 19
            for (std::size_t q = 0; q < 19; ++q) __builtin_prefetch(f[q] + x + lines_ahead * cells_a_line, 1);
        collide_at<F, V>(f, x, first, r, s);
    }
}

//! Collides the cells [begin, end) of one row of D3Q19 in place, in numbers of V.
template <Features F, class V, class Stored>
void collide(AnySlots<3> const& slots, std::ptrdiff_t begin, std::ptrdiff_t end, Relaxation const& relaxation,
             SolidRow const& solid)
{
    in_whole_registers<3, F.grains, V>(
        typed<3, Stored>(slots), solid, begin, end,
        [&](Slots<3, Stored> const& f, SolidRow const& s, std::ptrdiff_t from, std::ptrdiff_t to,
            std::ptrdiff_t first) { collide_whole<F, V>(f, s, from, to, first, relaxation); });
}

}  // namespace lbm
