#pragma once

#include <type_traits>

#include "participants/lbm/cell_row.hpp"
#include "participants/lbm/collide_central.hpp"
#include "participants/lbm/still_cells.hpp"

namespace lbm {

//! The populations of a cell and of those after it in its row that V has room for, where they are in memory.
template <class V, class Stored>
struct CellInRow
{
    Slots<3, Stored> const& slots;
    std::ptrdiff_t at;

    [[gnu::always_inline]] V operator[](std::size_t q) const noexcept { return in_register(load<V>(slots[q] + at)); }
    [[gnu::always_inline]] void put(std::size_t q, V const& f) const noexcept
    {
        store(slots[q] + at, f);
        ask_ahead<3>(slots[q] + at);
    }
};

//! Of a pair of opposite directions, the second one after the first: f_q + f_-q and f_q - f_-q.
template <class V>
struct EvenOdd
{
    V even, odd;

    template <class Cell>
    [[gnu::always_inline]] EvenOdd(Cell const& f, std::size_t q) noexcept
    {
        V const one = f[q], other = f[q + 1];
        even = one + other;
        odd = one - other;
    }
};

//! Sums over a cell's populations: rho - 1, momentum, and if wanted of c c.
template <bool stress, class V>
struct Sums
{
    V excess, jx, jy, jz, xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

    template <class Cell>
    [[gnu::always_inline]] explicit Sums(Cell const& f) noexcept
    {
        EvenOdd<V> const x(f, 1), y(f, 3), z(f, 5), p(f, 7), m(f, 9), q(f, 11), n(f, 13), o(f, 15), l(f, 17);
        V const in_xy = p.even + m.even, in_xz = q.even + n.even, in_yz = o.even + l.even;
        excess = f[0] + ((x.even + y.even) + (z.even + in_xy)) + (in_xz + in_yz);
        jx = x.odd + (p.odd + m.odd) + (q.odd + n.odd);
        jy = y.odd + (p.odd - m.odd) + (o.odd + l.odd);
        jz = z.odd + (q.odd - n.odd) + (o.odd - l.odd);
        if constexpr (stress) {
            xx = x.even + in_xy + in_xz, yy = y.even + in_xy + in_yz, zz = z.even + in_xz + in_yz;
            xy = p.even - m.even, xz = q.even - n.even, yz = o.even - l.even;
        }
    }
};

//! The body force on a cell, and half of it to its momentum. `place`: the cell's x, in a frame that turns.
template <Features F, class V, class Force>
[[gnu::always_inline]] inline void take_half_force(Relaxation const& r, [[maybe_unused]] V const& place, V& jx, V& jy,
                                                   V& jz, Force& Fx, Force& Fy, Force& Fz) noexcept
{
    if constexpr (F.frame)
        Fx = r.force[0] + r.slope[0] * place, Fy = r.force[1] + r.slope[1] * place,
        Fz = r.force[2] + r.slope[2] * place;
    else
        Fx = r.force[0], Fy = r.force[1], Fz = r.force[2];
    jx = jx + 0.5 * Fx, jy = jy + 0.5 * Fy, jz = jz + 0.5 * Fz;
    if constexpr (F.frame) {
        turn_with_half(r.turn, jx, jy, jz);
        Fx = Fx - 2.0 * (r.turn[1] * jz - r.turn[2] * jy);
        Fy = Fy - 2.0 * (r.turn[2] * jx - r.turn[0] * jz);
        Fz = Fz - 2.0 * (r.turn[0] * jy - r.turn[1] * jx);
    }
}

//! Rate of the stress with the large-eddy model, from the stress without its trace.
template <class V>
[[gnu::always_inline]] inline V eddy_rate(Relaxation const& r, V const& inverse_rho, V const& xx, V const& yy,
                                          V const& zz, V const& xy, V const& xz, V const& yz) noexcept
{
    V const size = madd(xx, xx, madd(yy, yy, zz * zz)) + 2.0 * madd(xy, xy, madd(xz, xz, yz * yz));
    return 2.0 / (r.tau + root(madd(r.smagorinsky_term * inverse_rho, root(2.0 * size), r.tau * r.tau)));
}

//! The solids of cells, or none.
template <Features F, class V>
using SpaceSolids = std::conditional_t<F.still, StillCell<V>, SolidCell<3, V>>;

template <Features F, class V>
[[gnu::always_inline]] inline Rates<V> rates_of(Relaxation const& r, SpaceSolids<F, V> const& s) noexcept
{
    if constexpr (F.still)
        return s.rates;
    else if constexpr (F.grains)
        return rates_beside(r, s.open);
    else
        return {r.shear, r.energy, r.square, r.flux};
}

//! What a cell of D3Q19 is changed by. The populations are read for it, and once more when they are changed: what would
//! be kept of them meanwhile has no room in the registers, and stores are what the machine has least of.
template <bool frame, class V>
struct SpaceChange
{
    using Force = std::conditional_t<frame, V, double>;  // the same everywhere, or each cell's own
    V base, inverse_rho, jx, jy, jz;
    Force Fx{}, Fy{}, Fz{};
    V Gx, Gy, Gz, work;
    V along_x, along_y, along_z, shear_xy, shear_xz, shear_yz, bulk;
};

//! What the solids of a cell push it with, -2 B (j - rho u_s), B eased by inertia; it is told what bodies need of it.
template <class V>
[[gnu::always_inline]] inline std::array<V, 3> find_push(SolidCell<3, V>& s, V const& rho, V const& inverse_rho,
                                                         V const& jx, V const& jy, V const& jz) noexcept
{
    V const slip_x = madd(jx * inverse_rho, s.fraction, -1.0 * s.momentum[0]),  // times eps
        slip_y = madd(jy * inverse_rho, s.fraction, -1.0 * s.momentum[1]),
            slip_z = madd(jz * inverse_rho, s.fraction, -1.0 * s.momentum[2]);
    s.weight = eased(s.weight, s.fraction, s.ease * root(madd(slip_x, slip_x, madd(slip_y, slip_y, slip_z * slip_z))));
    V const weight2 = 2.0 * s.weight, solid2 = weight2 * s.fraction;  // 2 B/eps, 2 B
    s.force_rate = weight2 * rho;
    s.force = {weight2 * jx, weight2 * jy, weight2 * jz};
    return {madd(s.force_rate, s.momentum[0], -solid2 * jx), madd(s.force_rate, s.momentum[1], -solid2 * jy),
            madd(s.force_rate, s.momentum[2], -solid2 * jz)};
}

//! The collision of one cell of D3Q19, or of several at once; its first half, up to what changes.
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
template <Features F, class V, class Cell>
[[gnu::always_inline]] inline SpaceChange<F.frame, V> find_change(Cell const& f, Relaxation const& r,
                                                                  Rates<V> const& rates, SpaceSolids<F, V>& s,
                                                                  V const& place) noexcept
{
    constexpr bool split = F.les || F.split;
    SpaceChange<F.frame, V> c;
    auto& [base, inverse_rho, jx, jy, jz, Fx, Fy, Fz, Gx, Gy, Gz, work, along_x, along_y, along_z, shear_xy, shear_xz,
           shear_yz, bulk] = c;
    Sums<split, V> const sums(f);
    V const excess = sums.excess;
    V xx = sums.xx, yy = sums.yy, zz = sums.zz, xy = sums.xy, xz = sums.xz, yz = sums.yz;
    jx = sums.jx, jy = sums.jy, jz = sums.jz;
    V const rho = 1.0 + excess;
    inverse_rho = 1.0 / rho;
    if constexpr (F.force) take_half_force<F>(r, place, jx, jy, jz, Fx, Fy, Fz);
    Gx = Fx, Gy = Fy, Gz = Fz;  // force on the fluid, the solids' included
    if constexpr (F.still) {    // the other half of their force is in `pull`
        s.force = {s.push * jx, s.push * jy, s.push * jz};
        jx = s.left * jx, jy = s.left * jy, jz = s.left * jz;
    } else if constexpr (F.grains) {
        auto const [push_x, push_y, push_z] = find_push(s, rho, inverse_rho, jx, jy, jz);
        jx = jx + 0.5 * push_x, jy = jy + 0.5 * push_y, jz = jz + 0.5 * push_z;
        Gx = Gx + push_x, Gy = Gy + push_y, Gz = Gz + push_z;
    }
    V const ux = jx * inverse_rho, uy = jy * inverse_rho, uz = jz * inverse_rho;
    base = madd(-1.5, madd(jx, ux, madd(jy, uy, jz * uz)), excess);
    work = F.force ? 3.0 * (ux * Fx + uy * Fy + uz * Fz) : V{};

    // what the stress, less equilibrium, changes beyond the common rate of the even part
    if constexpr (split) {
        V const pressure = excess * (1.0 / 3);
        xx = madd(-jx, ux, xx - pressure), yy = madd(-jy, uy, yy - pressure), zz = madd(-jz, uz, zz - pressure);
        xy = madd(-jx, uy, xy), xz = madd(-jx, uz, xz), yz = madd(-jy, uz, yz);
        if constexpr (F.force) {
            xx = xx + ux * Fx, yy = yy + uy * Fy, zz = zz + uz * Fz;
            xy = xy + 0.5 * (ux * Fy + uy * Fx), xz = xz + 0.5 * (ux * Fz + uz * Fx),
            yz = yz + 0.5 * (uy * Fz + uz * Fy);
        }
        V const trace = xx + yy + zz, mean = trace * (1.0 / 3);
        V const dx = xx - mean, dy = yy - mean, dz = zz - mean;
        V shear_rate = rates.shear;
        if constexpr (F.les) {
            V const eddy = eddy_rate(r, inverse_rho, dx, dy, dz, xy, xz, yz);
            if constexpr (F.still)
                shear_rate = where_above(shear_rate, 0, shear_rate, eddy);
            else if constexpr (F.grains)
                shear_rate = where_above(s.fraction, eddy_free, shear_rate, eddy);
            else
                shear_rate = eddy;
        }
        V const more = 4.5 * (rates.square - shear_rate);
        along_x = more * dx, along_y = more * dy, along_z = more * dz;
        shear_xy = 2.0 * more * xy, shear_xz = 2.0 * more * xz, shear_yz = 2.0 * more * yz;
        bulk = (1.5 * (rates.square - rates.energy)) * trace;
    }
    return c;
}

//! The second half of the collision. `pull`: of solids that rest.
template <Features F, class V, class Cell>
[[gnu::always_inline]] inline void change(Cell const& f, SpaceChange<F.frame, V> const& c, Rates<V> const& rates,
                                          V const& pull) noexcept
{
    using Force = typename SpaceChange<F.frame, V>::Force;
    constexpr bool split = F.les || F.split;
    constexpr double axis = 1.0 / 18, diagonal = 1.0 / 36;
    using Momentum = MomentumShares<typename V::Number>;
    V const even_rate = split ? rates.square : rates.shear, flux_rate = rates.flux;
    auto const& [base, inverse_rho, jx, jy, jz, Fx, Fy, Fz, Gx, Gy, Gz, work, along_x, along_y, along_z, shear_xy,
                 shear_xz, shear_yz, bulk] = c;
    // even parts: sums of both populations, less equilibrium (f + S/2 - f_eq); S = w (9 c.u c.F - work)
    V rest = f[0];
    {
        V apart = madd(-1.0 / 3, base, rest);
        if constexpr (F.force) apart = madd(-1.0 / 6, work, apart);
        rest = madd(-1.0 * even_rate, apart, rest);
        if constexpr (F.force) rest = madd(-1.0 / 3, work, rest);
        if constexpr (split) rest = madd(-1.0 / 3, bulk, rest);
    }
    f.put(0, rest);
    V const minus_half_even = -0.5 * even_rate, minus_half_flux = -0.5 * flux_rate;
    V const square_by_rho = 4.5 * inverse_rho;
    // odd parts: f + S/2 - f_eq; what both populations gain
    auto const collide_pair = [&](std::size_t q, double weight, double share, V const& stress, V const& cj, V const& ck,
                                  Force const& cF, V const& cG) __attribute__((always_inline))
    {
        V const one = f[q], other = f[q + 1];
        V apart = madd(-2.0 * weight, madd(cj * square_by_rho, cj, base), one + other);
        V b = minus_half_flux * madd(-share, ck, one - other);
        if constexpr (F.force || (F.grains && !F.still)) b = madd(0.5 * share * (1.0 - 0.5 * flux_rate), cG, b);
        V gain = b, other_gain = -b;
        if constexpr (split) gain = madd(weight, stress, b), other_gain = madd(weight, stress, -b);
        if constexpr (F.force) {
            V const source = weight * ((9.0 * cF) * (cj * inverse_rho) - work);
            apart = apart + source, gain = gain + source, other_gain = other_gain + source;
        }
        f.put(q, one + madd(minus_half_even, apart, gain));
        f.put(q + 1, other + madd(minus_half_even, apart, other_gain));
    };
    auto const along_axis = [&](std::size_t q, auto const&... of) __attribute__((always_inline))
    {
        collide_pair(q, axis, Momentum::axis, of...);
    };
    auto const along_diagonal = [&](std::size_t q, auto const&... of) __attribute__((always_inline))
    {
        collide_pair(q, diagonal, Momentum::diagonal, of...);
    };
    V const kx = F.still ? pull * jx : jx, ky = F.still ? pull * jy : jy, kz = F.still ? pull * jz : jz;
    along_axis(1, along_x, jx, kx, Fx, Gx);
    along_axis(3, along_y, jy, ky, Fy, Gy);
    along_axis(5, along_z, jz, kz, Fz, Gz);
    along_diagonal(7, bulk - along_z + shear_xy, jx + jy, kx + ky, Fx + Fy, Gx + Gy);
    along_diagonal(9, bulk - along_z - shear_xy, jx - jy, kx - ky, Fx - Fy, Gx - Gy);
    along_diagonal(11, bulk - along_y + shear_xz, jx + jz, kx + kz, Fx + Fz, Gx + Gz);
    along_diagonal(13, bulk - along_y - shear_xz, jx - jz, kx - kz, Fx - Fz, Gx - Gz);
    along_diagonal(15, bulk - along_x + shear_yz, jy + jz, ky + kz, Fy + Fz, Gy + Gz);
    along_diagonal(17, bulk - along_x - shear_yz, jy - jz, ky - kz, Fy - Fz, Gy - Gz);
}

//! One cell of D3Q19, or several at once, in central moments (collide_central.hpp). As long as the other collision, for
//! the same reason.
template <Features F, class V, class Cell>
[[gnu::always_inline]] inline void collide_central(Cell const& f, Relaxation const& r, SolidCell<3, V>& s,
                                                   V const& place) noexcept
{
    constexpr bool force = F.force || F.grains;
    Sums<true, V> const sums(f);
    V const excess = sums.excess;
    V xx = sums.xx, yy = sums.yy, zz = sums.zz, xy = sums.xy, xz = sums.xz, yz = sums.yz;
    V jx = sums.jx, jy = sums.jy, jz = sums.jz;
    V const rho = 1.0 + excess, inverse_rho = 1.0 / rho, pressure = excess * (1.0 / 3), third = rho * (1.0 / 3);
    V Fx{}, Fy{}, Fz{};
    if constexpr (F.force) take_half_force<F>(r, place, jx, jy, jz, Fx, Fy, Fz);
    if constexpr (F.grains) {
        auto const [push_x, push_y, push_z] = find_push(s, rho, inverse_rho, jx, jy, jz);
        jx = jx + 0.5 * push_x, jy = jy + 0.5 * push_y, jz = jz + 0.5 * push_z;
        Fx = Fx + push_x, Fy = Fy + push_y, Fz = Fz + push_z;
    }
    V const ux = jx * inverse_rho, uy = jy * inverse_rho, uz = jz * inverse_rho;
    // raw second moments of a cell that moves with u, before the collision (with half of the force less) and after it
    V rx = madd(jx, ux, pressure), ry = madd(jy, uy, pressure), rz = madd(jz, uz, pressure);
    V rxy = jx * uy, rxz = jx * uz, ryz = jy * uz;
    xx = xx - rx, yy = yy - ry, zz = zz - rz, xy = xy - rxy, xz = xz - rxz, yz = yz - ryz;
    if constexpr (force) {
        V const wx = ux * Fx, wy = uy * Fy, wz = uz * Fz;
        V const wxy = 0.5 * (ux * Fy + uy * Fx), wxz = 0.5 * (ux * Fz + uz * Fx), wyz = 0.5 * (uy * Fz + uz * Fy);
        xx = xx + wx, yy = yy + wy, zz = zz + wz, xy = xy + wxy, xz = xz + wxz, yz = yz + wyz;
        rx = rx + wx, ry = ry + wy, rz = rz + wz, rxy = rxy + wxy, rxz = rxz + wxz, ryz = ryz + wyz;
    }
    using High = HighMoments<force, V>;
    struct Planes
    {
        High xy, xz, yz;
    };
    auto const planes = [&](V const& px, V const& py, V const& pz) __attribute__((always_inline))
    {
        V const kx = third + xx, ky = third + yy, kz = third + zz;
        return Planes{{rho, excess, ux, uy, kx, ky, xy, px, py},
                      {rho, excess, ux, uz, kx, kz, xz, px, pz},
                      {rho, excess, uy, uz, ky, kz, yz, py, pz}};
    };
    struct Beyond
    {
        std::array<V, 3> xy, xz, yz;
    } beyond;
    if constexpr (F.grains) {
        auto const apart = [&](std::size_t q, High const& maxwellian) __attribute__((always_inline))
        {
            EvenOdd<V> const plus(f, q), minus(f, q + 2);
            return maxwellian.to(plus.odd - minus.odd, plus.odd + minus.odd, plus.even + minus.even);
        };
        auto const maxwellian = planes(-Fx, -Fy, -Fz);
        beyond = {apart(7, maxwellian.xy), apart(11, maxwellian.xz), apart(15, maxwellian.yz)};
    }
    V mean = (xx + yy + zz) * (1.0 / 3);
    xx = xx - mean, yy = yy - mean, zz = zz - mean;
    V stress_left = V(1.0 - r.shear);
    if constexpr (F.grains) stress_left = 1.0 - stiffened(r.shear, s.open);
    if constexpr (F.les) {
        V const eddies = 1.0 - eddy_rate(r, inverse_rho, xx, yy, zz, xy, xz, yz);
        stress_left = F.grains ? where_above(s.fraction, eddy_free, stress_left, eddies) : eddies;
    }
    xx = stress_left * xx, yy = stress_left * yy, zz = stress_left * zz;
    xy = stress_left * xy, xz = stress_left * xz, yz = stress_left * yz;
    V left;
    if constexpr (F.grains) {
        left = left_by_solids(s.open);
        mean = left * mean;
        xx = xx + mean, yy = yy + mean, zz = zz + mean;
    }
    auto [in_xy, in_xz, in_yz] = planes(Fx, Fy, Fz);
    if constexpr (F.grains) {
        in_xy.add_left(beyond.xy, ux, uy, left);
        in_xz.add_left(beyond.xz, ux, uz, left);
        in_yz.add_left(beyond.yz, uy, uz, left);
    }
    xx = xx + rx, yy = yy + ry, zz = zz + rz;
    f.put(0, excess - (xx + yy + zz) + (in_xy.aabb + in_xz.aabb + in_yz.aabb));
    auto const put_axis = [&](std::size_t q, V const& even, V const& odd) __attribute__((always_inline))
    {
        f.put(q, 0.5 * (even + odd));
        f.put(q + 1, 0.5 * (even - odd));
    };
    put_axis(1, xx - (in_xy.aabb + in_xz.aabb), jx + 0.5 * Fx - (in_xy.abb + in_xz.abb));
    put_axis(3, yy - (in_xy.aabb + in_yz.aabb), jy + 0.5 * Fy - (in_xy.aab + in_yz.abb));
    put_axis(5, zz - (in_xz.aabb + in_yz.aabb), jz + 0.5 * Fz - (in_xz.aab + in_yz.aab));
    auto const put_corners = [&](std::size_t q, High const& high, V const& ab) __attribute__((always_inline))
    {
        Corners<V> const c(high, ab);
        f.put(q, c.even_plus + c.odd_plus);
        f.put(q + 1, c.even_plus - c.odd_plus);
        f.put(q + 2, c.even_minus + c.odd_minus);
        f.put(q + 3, c.even_minus - c.odd_minus);
    };
    put_corners(7, in_xy, xy + rxy);
    put_corners(11, in_xz, xz + rxz);
    put_corners(15, in_yz, yz + ryz);
}

//! Collides cells in whole registers, in place. x = 0 is the row's cell `first`.
template <Features F, class V, class Stored>
void collide_whole(Slots<3, Stored> const& slots, SolidRow<Stored> const& row, CellRows const& cells,
                   std::ptrdiff_t first, Relaxation const& relaxation)
{
    constexpr auto lanes = static_cast<std::ptrdiff_t>(V::count);
    Slots<3, Stored> const f = slots;
    Relaxation const r = relaxation;
    SolidRow<Stored> const solids = row;
    V place;
    auto const found_at = [&](std::ptrdiff_t at, SolidCell<3, V> & s) __attribute__((always_inline))
    {
        if constexpr (F.frame) place = counted_from<V>(static_cast<double>(first + at));
        return find_change<F, V>(CellInRow<V, Stored>{f, at}, r, rates_of<F, V>(r, s), s, place);
    };
    auto const change_at = [&](std::ptrdiff_t at, SpaceChange<F.frame, V> const& c, SolidCell<3, V> const& s)
        __attribute__((always_inline))
    {
        change<F, V>(CellInRow<V, Stored>{f, at}, c, rates_of<F, V>(r, s), V{});
    };
    if constexpr (F.central) {
        cells.each_register<lanes>([&](std::ptrdiff_t at) __attribute__((always_inline)) {
            SolidCell<3, V> s;
            if constexpr (F.grains) s = SolidCell<3, V>(solids, at);
            if constexpr (F.frame) place = counted_from<V>(static_cast<double>(first + at));
            collide_central<F, V>(CellInRow<V, Stored>{f, at}, r, s, place);
            if constexpr (F.grains) s.tell(solids, at);
        });
    } else if constexpr (F.les || F.split || F.grains) {  // so much is found that it would not stay in registers
        cells.each_register<lanes>([&](std::ptrdiff_t at) __attribute__((always_inline)) {
            SolidCell<3, V> s;
            if constexpr (F.grains) s = SolidCell<3, V>(solids, at);
            auto const found = found_at(at, s);
            if constexpr (F.grains) s.tell(solids, at);
            change_at(at, found, s);
        });
    } else {
        std::ptrdiff_t at = cells.begin, x = cells.begin + lanes;
        SolidCell<3, V> none;
        OnTheWay nothing, &way = cells.on_the_way ? *cells.on_the_way : nothing;
        way.reach(at);
        SpaceChange<F.frame, V> now = found_at(at, none);
        for (std::ptrdiff_t k = 0, row = 0; k < cells.count; ++k, row += cells.stride, x = cells.begin)
            for (; x < cells.end; x += lanes) {
                way.reach(row + x);
                SpaceChange<F.frame, V> const next = found_at(row + x, none);
                change_at(at, now, none);
                now = next, at = row + x;
            }
        change_at(at, now, none);
    }
}

//! Collides cells of D3Q19 in place, in numbers of V.
template <Features F, class V, class Stored>
void collide(AnySlots<3> const& slots, CellRows const& cells, Relaxation const& relaxation, AnySolidRow const& solid)
{
    in_whole_registers<3, F.grains, V>(
        typed<3, Stored>(slots), solid.typed<Stored>(), cells,
        [&](Slots<3, Stored> const& f, SolidRow<Stored> const& s, CellRows const& whole, std::ptrdiff_t first) {
            collide_whole<F, V>(f, s, whole, first, relaxation);
        });
}

}  // namespace lbm
