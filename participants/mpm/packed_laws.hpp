#pragma once

#include "participants/mpm/laws.hpp"
#include "participants/mpm/packed_tensor.hpp"

//! The laws of laws.hpp for four points at a time.
namespace mpm {

struct PackedElastic
{
    explicit PackedElastic(LinearElastic const& law) : elasticity(law.elasticity) {}

    //! Of the trial makes the stress. Returns what it dissipated [J/m3].
    template <int D>
    Pack respond(PackStress<D>&, Pack /*pressure relieved*/, Pack& /*strain*/, Pack& /*gap*/) const
    {
        return Pack{};
    }
    static constexpr bool gaps = false;
    Elasticity elasticity;
};

//! The return to the surface in closed form: to a face, to the edges at its sides and, where flow keeps the volume, to
//! the tip. What is left, and any other corner of tension, takes the surface's own way, one point at a time.
class PackedMohrCoulomb
{
 public:
    explicit PackedMohrCoulomb(MohrCoulomb const& law)
        : elasticity(law.elasticity), surface_(law.surface), p_(law.surface.parameters())
    {
        double const sin_phi = std::sin(p_.friction_angle), sin_psi = std::sin(p_.dilation_angle);
        double const twice = 2 * elasticity.shear(), rest = elasticity.lame() * 2 * sin_psi;
        up_ = 1 + sin_phi, down_ = 1 - sin_phi;
        limit_ = 2 * p_.cohesion * std::cos(p_.friction_angle);
        tip_ = law.surface.tip();
        simple_tip_ = p_.dilation_angle == 0 && law.surface.tip_is_of_cone();
        high_ = rest + twice * (1 + sin_psi), middle_ = rest, low_ = rest - twice * (1 - sin_psi);
        own_ = up_ * high_ - down_ * low_;
        beside_low_ = up_ * high_ - down_ * middle_;
        beside_high_ = up_ * middle_ - down_ * low_;
    }

    static constexpr bool gaps = true;
    template <int D>
    Pack respond(PackStress<D>& s, Pack relieved, Pack& strain, Pack& gap) const
    {
        using sluice::packs::larger;
        PackPrincipal<D> const trial(s);
        Pack const s1 = trial.s1, s2 = trial.s2, s3 = trial.s3;
        Pack const tolerance = all(1e-13 * (1 + elasticity.bulk() / elasticity.shear())) *
                               (larger(larger(s1, -s1), larger(s3, -s3)) + all(limit_));
        Pack const excess = all(up_) * s1 - all(down_) * s3 - all(limit_);
        PackMask const yields = (excess > tolerance) | (s1 - all(tip_) > tolerance);
        Pack const lost = relieved * s.trace();
        if (!bits(yields)) return lost;
        Principals const out = back(s1, s2, s3, excess, tolerance, yields, gap);
        trial.set(s, out.s1, out.s2, out.s3, yields);
        Pack const d1 = s1 - out.s1, d2 = s2 - out.s2, d3 = s3 - out.s3, d = all(1.0 / 3) * (d1 + d2 + d3);
        double const per_shear = 1 / (2 * elasticity.shear());
        Pack const e1 = all(per_shear) * (d1 - d), e2 = all(per_shear) * (d2 - d), e3 = all(per_shear) * (d3 - d);
        Pack const e = all(1 / (3 * elasticity.bulk())) * d;
        strain += either(yields, sluice::packs::root(all(2.0 / 3) * (e1 * e1 + e2 * e2 + e3 * e3)), all(0));
        Pack const work = out.s1 * (e1 + e + relieved) + out.s2 * (e2 + e + relieved) + out.s3 * (e3 + e + relieved);
        return either(yields, work, lost);
    }

    Elasticity elasticity;

 private:
    struct Principals
    {
        Pack s1, s2, s3;
    };

    Principals back(Pack s1, Pack s2, Pack s3, Pack excess, Pack tolerance, PackMask yields, Pack& gap) const
    {
        Pack const m = excess * all(1 / own_);
        Principals out{s1 - m * all(high_), s2 - m * all(middle_), s3 - m * all(low_)};
        PackMask const under = out.s2<out.s3, over = out.s2> out.s1;
        PackMask done = excess > tolerance;
        if (bits((under | over) & yields)) {  // the edge where the middle one meets the lowest, or the highest
            Pack const other =
                either(under, all(up_) * s1 - all(down_) * s2, all(up_) * s2 - all(down_) * s3) - all(limit_);
            Pack const side = either(under, all(beside_low_), all(beside_high_));
            Pack const scale = all(1) / (all(own_ * own_) - side * side);
            Pack const first = scale * (all(own_) * excess - side * other);
            Pack const second = scale * (all(own_) * other - side * excess);
            Pack const e1 = s1 - first * all(high_) - second * either(under, all(high_), all(middle_));
            Pack const e2 = s2 - first * all(middle_) - second * either(under, all(low_), all(high_));
            Pack const e3 = s3 - first * all(low_) - second * either(under, all(middle_), all(low_));
            PackMask const edge = under | over;
            out = {either(edge, e1, out.s1), either(edge, e2, out.s2), either(edge, e3, out.s3)};
            done &= ~edge | ((first >= all(0)) & (second >= all(0)));
        }
        if (simple_tip_) {  // on faces the mean stress stays
            Pack const beyond = all(1.0 / 3) * (s1 + s2 + s3) - all(tip_);
            PackMask const tip = beyond > all(0);
            out = {either(tip, all(tip_), out.s1), either(tip, all(tip_), out.s2), either(tip, all(tip_), out.s3)};
            gap += either(tip & yields, beyond * all(1 / elasticity.bulk()), all(0));
            done |= tip;
        } else {
            done &= (out.s1 - all(tip_) <= tolerance) & (out.s1 >= out.s3);
        }
        unsigned left = bits(yields & ~done);
        for (int k = 0; left != 0; ++k, left >>= 1U) {
            if (!(left & 1U)) continue;
            auto const slow = surface_.bring_back({s1[k], s2[k], s3[k]});
            out.s1[k] = slow.stress[0], out.s2[k] = slow.stress[1], out.s3[k] = slow.stress[2];
            gap[k] += slow.opened;
        }
        return out;
    }

    MohrCoulombSurface const& surface_;
    MohrCoulombParameters p_;
    double up_, down_, limit_, tip_;
    bool simple_tip_;
    double high_, middle_, low_;             //!< stress that a multiplier of one takes from the first, second, third
    double own_, beside_low_, beside_high_;  //!< excess that it takes from its face, from those beside it
};

}  // namespace mpm
