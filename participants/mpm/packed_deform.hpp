#pragma once

#include "participants/mpm/packed_laws.hpp"
#include "participants/mpm/packed_passes.hpp"

namespace mpm::packed {

//! What the stress of a chunk's points did.
struct Deformed
{
    double work = 0, plastic = 0;  //!< [J/m]
    double speed = 0;              //!< of the fastest wave over the fastest point [m/s]
    bool upright = true;           //!< J > 0, and a number
};

//! Strain and turn of the step about its middle (Increment in tensor.hpp), then the law.
template <bool affine, bool shared, class Law>
Deformed deform(PackedPoints& p, std::size_t begin, std::size_t end, double dt, Law const& law, Planes const& nodes)
{
    Pack work{}, plastic{}, fastest{};
    PackMask upright = all(0) == all(0);
    Pack const one = all(1), half = all(0.5);
    double const shear = law.elasticity.shear();
    Pack const lame = all(law.elasticity.lame()), twice = all(2 * shear), bulk = all(law.elasticity.bulk());
    Pack const wave = all(law.elasticity.wave());
    for (std::size_t k = begin; k < end; k += 4) {
        auto const at = [&](P::Column c) { return p[c] + k; };
        Pack xx = one + load(at(P::gxx)), xy = load(at(P::gxy)), yx = load(at(P::gyx)), yy = one + load(at(P::gyy));
        Pack det = xx * yy - xy * yx;
        if constexpr (shared) {
            Pack const mean = of_cells(p, k, nodes);
            PackMask const usable = (det > all(0)) & (mean > all(0));
            Pack const scale = sluice::packs::root(either(usable, mean / det, one));
            xx *= scale, xy *= scale, yx *= scale, yy *= scale;
            det *= scale * scale;
        }
        {  // deformation gradient
            Pack const fxx = load(at(P::fxx)), fxy = load(at(P::fxy)), fyx = load(at(P::fyx)), fyy = load(at(P::fyy));
            store(at(P::fxx), xx * fxx + xy * fyx), store(at(P::fxy), xx * fxy + xy * fyy);
            store(at(P::fyx), yx * fxx + yy * fyx), store(at(P::fyy), yx * fxy + yy * fyy);
        }
        if constexpr (affine) {  // v* = L x(n) = L (I + dt L)^-1 x(n+1)
            Pack const t = all(dt);
            Pack const lxx = load(at(P::lxx)), lxy = load(at(P::lxy)), lyx = load(at(P::lyx)), lyy = load(at(P::lyy));
            Pack const a = one + t * lxx, b = t * lxy, c = t * lyx, d = one + t * lyy, over = one / (a * d - b * c);
            Pack nxx = over * (lxx * d - lxy * c), nxy = over * (lxy * a - lxx * b);
            Pack nyx = over * (lyx * d - lyy * c), nyy = over * (lyy * a - lyx * b);
            if constexpr (Law::gaps) {
                PackMask const is_loose = load(at(P::gap)) > all(loose<2>);
                Pack const turn = half * (nxy - nyx);
                nxx = either(is_loose, Pack{}, nxx), nyy = either(is_loose, Pack{}, nyy);
                nxy = either(is_loose, turn, nxy), nyx = either(is_loose, -turn, nyx);
            }
            store(at(P::lxx), nxx), store(at(P::lxy), nxy), store(at(P::lyx), nyx), store(at(P::lyy), nyy);
        }
        Pack const before = load(at(P::ratio)), ratio = before * det;
        upright &= (ratio > all(0)) & (ratio < all(HUGE_VAL));
        store(at(P::ratio), ratio);
        // G = 2 (dF - I)(dF + I)^-1
        Pack const a = xx + one, d = yy + one, over = all(2) / (a * d - xy * yx);
        Pack const gxx = over * ((xx - one) * d - xy * yx), gyy = over * ((yy - one) * a - xy * yx);
        Pack const gxy = over * (xy * a - (xx - one) * xy), gyx = over * (yx * d - (yy - one) * yx);
        Pack const shearing = half * (gxy + gyx), spin = all(0.25) * (gxy - gyx), volumetric = gxx + gyy;
        Pack const norm = one / (one + spin * spin);
        Pack const cosine = (one - spin * spin) * norm, sine = all(2) * spin * norm;
        Pack const cos2 = cosine * cosine - sine * sine, sin2 = all(2) * cosine * sine;
        // the old stress, turned
        PackStress s{load(at(P::sxx)), load(at(P::syy)), load(at(P::szz)), load(at(P::sxy))};
        Pack const trace = s.xx + s.yy + s.zz;
        Pack const mean = half * (s.xx + s.yy), difference = half * (s.xx - s.yy);
        Pack const turned = cos2 * difference + sin2 * s.xy;
        s.xy = cos2 * s.xy - sin2 * difference;
        s.xx = mean + turned, s.yy = mean - turned;
        PackStress const old = s;
        Pack pressing = lame * volumetric, relieved{}, gap{}, strain{};
        if constexpr (Law::gaps) {
            gap = load(at(P::gap)), strain = load(at(P::strain));
            Pack const closing = sluice::packs::smaller(gap, -volumetric);
            PackMask const closes = (closing > all(0)) & (trace <= all(1e-13 * law.elasticity.youngs_modulus));
            Pack const closed = either(closes, closing, all(0));
            gap -= closed;
            pressing += bulk * closed;
            relieved = all(-1.0 / 3) * closed;
        }
        s.xx += pressing + twice * gxx, s.yy += pressing + twice * gyy, s.zz += pressing;
        s.xy += twice * shearing;
        Pack const lost = law.respond(s, relieved, strain, gap);
        store(at(P::sxx), s.xx), store(at(P::syy), s.yy), store(at(P::szz), s.zz), store(at(P::sxy), s.xy);
        if constexpr (Law::gaps) store(at(P::gap), gap), store(at(P::strain), strain);
        Pack const volume = load(at(P::volume));
        plastic += volume * ratio * lost;
        work += volume * (before + ratio) *
                ((old.xx + s.xx) * gxx + (old.yy + s.yy) * gyy + all(2) * (old.xy + s.xy) * shearing);
        Pack const vx = load(at(P::vx)), vy = load(at(P::vy));
        // fillers have no mass: not a number, which is not larger
        Pack const speed =
            sluice::packs::root(wave * (volume * ratio) / load(at(P::mass))) + sluice::packs::root(vx * vx + vy * vy);
        fastest = sluice::packs::larger(speed, fastest);
    }
    double speed = 0;
    for (int lane = 0; lane < 4; ++lane) speed = std::max(speed, fastest[lane]);
    return {0.25 * sluice::packs::sum(work), sluice::packs::sum(plastic), speed, sluice::packs::bits(upright) == 15U};
}

}  // namespace mpm::packed
