#pragma once

#include "participants/mpm/packed_laws.hpp"
#include "participants/mpm/packed_passes.hpp"

namespace mpm::packed {

//! What the stress of a chunk's points did.
struct Deformed
{
    double work = 0, plastic = 0;  //!< [J]; plane: per metre
    double speed = 0;              //!< of the fastest wave over the fastest point [m/s]
    bool upright = true;           //!< J > 0, and a number
};

//! Gives an increment, `around` the axis that of rings, its cell's change of volume.
template <int D, bool rings>
[[gnu::always_inline]] inline void take_volume_of_cell(PackMat<D>& change, Pack& around, Pack mean)
{
    Pack const own = rings ? determinant(change) * around : determinant(change), one = all(1);
    PackMask const usable = (own > all(0)) & (mean > all(0));
    Pack const by = either(usable, mean / own, one);
    Pack scale;
    if constexpr (shared_axes<D, rings> == 2)
        scale = sluice::packs::root(by);
    else
        for (int lane = 0; lane < 4; ++lane) scale[lane] = std::cbrt(by[lane]);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) change(a, b) *= scale;
    if constexpr (rings) around *= scale;
}

//! v* = L x(n) = L (I + dt L)^-1 x(n+1); of a loose point the turn alone.
template <int D, bool gaps>
[[gnu::always_inline]] inline void carry_slope(PackedPoints<D>& p, std::size_t k, double dt)
{
    using C = PackedColumns<D>;
    PackMat<D> const slope = p.matrix_at(C::slope, k), moved = one_plus(slope, all(dt)), back = adjugate(moved);
    PackMat<D> now = product(slope, back);
    Pack const over = all(1) / determinant(moved, back);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) now(a, b) *= over;
    if constexpr (gaps) {
        PackMask const is_loose = p.at(C::gap, k) > all(loose<D>);
        for (int a = 0; a < D; ++a)
            for (int b = 0; b <= a; ++b) {
                Pack const turn = all(0.5) * (now(a, b) - now(b, a));
                now(a, b) = either(is_loose, turn, now(a, b));
                now(b, a) = either(is_loose, -turn, now(b, a));
            }
    }
    p.set(C::slope, k, now);
}

//! Strain and turn of the step about its middle (Increment in tensor.hpp), then the law.
template <int D, bool affine, bool shared, bool rings, class Law>
Deformed deform(PackedPoints<D>& p, Range points, double dt, Law const& law, Planes<D> const& nodes)
{
    using C = PackedColumns<D>;
    Pack work{}, plastic{}, fastest{};
    PackMask upright = all(0) == all(0);
    Pack const half = all(0.5);
    Pack const lame = all(law.elasticity.lame()), twice = all(2 * law.elasticity.shear());
    Pack const bulk = all(law.elasticity.bulk()), wave = all(law.elasticity.wave());
    for (std::size_t k = points.begin; k < points.end; k += 4) {
        PackMat<D> change = one_plus(p.matrix_at(C::change, k), all(1));
        Pack around = all(1);
        if constexpr (rings) around += p.at(C::hoop, k);
        if constexpr (shared) take_volume_of_cell<D, rings>(change, around, of_cells(p, k, nodes));
        if constexpr (rings) p.set(C::around, k, around * p.at(C::around, k));
        p.set(C::gradient, k, product(change, p.matrix_at(C::gradient, k)));
        if constexpr (affine) carry_slope<D, Law::gaps>(p, k, dt);
        Pack const before = p.at(C::ratio, k), ratio = before * determinant(change) * around;
        upright &= (ratio > all(0)) & (ratio < all(HUGE_VAL));
        p.set(C::ratio, k, ratio);
        // G = 2 (dF - I)(dF + I)^-1
        PackMat<D> sum = change, g = change;
        for (int a = 0; a < D; ++a) sum(a, a) += all(1), g(a, a) -= all(1);
        PackMat<D> const back = adjugate(sum);
        Pack const over = all(2) / determinant(sum, back);
        g = product(g, back);
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) g(a, b) *= over;
        PackStress<D> s = p.stress_at(k);
        Pack const trace = s.trace();
        turn(s, g);
        PackStress<D> const old = s;
        Pack volumetric = g(0, 0);
        for (int a = 1; a < D; ++a) volumetric += g(a, a);
        Pack hoop{};
        if constexpr (rings) hoop = all(2) * (around - all(1)) / (around + all(1)), volumetric += hoop;
        Pack pressing = lame * volumetric, relieved{}, gap{}, strain{};
        if constexpr (Law::gaps) {
            gap = p.at(C::gap, k), strain = p.at(C::strain, k);
            Pack const closing = sluice::packs::smaller(gap, -volumetric);
            PackMask const closes = (closing > all(0)) & (trace <= all(1e-13 * law.elasticity.youngs_modulus));
            Pack const closed = either(closes, closing, all(0));
            gap -= closed;
            pressing += bulk * closed;
            relieved = all(-1.0 / 3) * closed;
        }
        for (int a = 0; a < 3; ++a) s(a, a) += pressing;
        if constexpr (rings) s(2, 2) += twice * hoop;
        for (int a = 0; a < D; ++a) {
            s(a, a) += twice * g(a, a);
            for (int b = a + 1; b < D; ++b) s(a, b) += twice * half * (g(a, b) + g(b, a));
        }
        Pack const lost = law.respond(s, relieved, strain, gap);
        p.set(k, s);
        if constexpr (Law::gaps) p.set(C::gap, k, gap), p.set(C::strain, k, strain);
        Pack const volume = p.at(C::volume, k);
        plastic += volume * ratio * lost;
        Pack power{};
        if constexpr (rings) power = (old(2, 2) + s(2, 2)) * hoop;
        for (int a = 0; a < D; ++a) {
            power += (old(a, a) + s(a, a)) * g(a, a);
            for (int b = a + 1; b < D; ++b) power += (old(a, b) + s(a, b)) * (g(a, b) + g(b, a));
        }
        work += volume * (before + ratio) * power;
        PackVec<D> const v = p.vector_at(C::velocity, k);
        // fillers have no mass: not a number, which is not larger
        Pack const speed =
            sluice::packs::root(wave * (volume * ratio) / p.at(C::mass, k)) + sluice::packs::root(dot(v, v));
        fastest = sluice::packs::larger(speed, fastest);
    }
    double speed = 0;
    for (int lane = 0; lane < 4; ++lane) speed = std::max(speed, fastest[lane]);
    return {0.25 * sluice::packs::sum(work), sluice::packs::sum(plastic), speed, sluice::packs::bits(upright) == 15U};
}

}  // namespace mpm::packed
