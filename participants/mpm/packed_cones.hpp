#pragma once

#include "participants/mpm/laws.hpp"
#include "participants/mpm/packed_tensor.hpp"

//! Laws whose surface is a cone about the axis of equal stress, for four points at a time; as in drucker_prager.cpp.
namespace mpm {

//! What a trial stress returns to, by its two invariants.
struct PackedInvariants
{
    Pack mean, shear, opened;  //!< p, t [Pa], volume strain that tension made [-]
    PackMask plastic;
};

//! `bring_back(mean, shear)` says where a trial stress returns to. Returns what that dissipated [J/m3].
template <int D, class BringBack>
[[gnu::always_inline]] inline Pack yield(PackStress<D>& s, Pack relieved, Pack& strain, Pack& gap,
                                         Elasticity const& elasticity, BringBack&& bring_back)
{
    Pack const mean = all(1.0 / 3) * s.trace();
    Pack squares{};
    for (int a = 0; a < 3; ++a) squares = madd(s(a, a) - mean, s(a, a) - mean, squares);
    for (int a = 0; a < D; ++a)
        for (int b = a + 1; b < D; ++b) squares = madd(all(2) * s(a, b), s(a, b), squares);
    Pack const shear = sluice::packs::root(all(0.5) * squares);
    PackedInvariants const back = bring_back(mean, shear);
    Pack const lost = all(3) * relieved * mean;
    if (!bits(back.plastic)) return lost;
    PackMask const deviates = shear > all(0);
    Pack const left =
        either(back.plastic, either(deviates, back.shear / either(deviates, shear, all(1)), all(0)), all(1));
    Pack const now = either(back.plastic, back.mean, mean);
    for (int a = 0; a < 3; ++a) s(a, a) = madd(left, s(a, a) - mean, now);
    for (int a = 0; a < D; ++a)
        for (int b = a + 1; b < D; ++b) s(a, b) *= left;
    Pack const taken = shear - back.shear;
    strain += either(back.plastic, taken * all(1 / (std::sqrt(3.0) * elasticity.shear())), all(0));
    gap += either(back.plastic, back.opened, all(0));
    Pack const flow = relieved + (mean - back.mean) * all(1 / (3 * elasticity.bulk()));
    return either(back.plastic, madd(all(3) * back.mean, flow, back.shear * taken * all(1 / elasticity.shear())), lost);
}

class PackedDruckerPrager
{
 public:
    explicit PackedDruckerPrager(DruckerPrager const& law)
        : elasticity(law.elasticity),
          slope_(all(law.surface.slope())),
          flow_(law.surface.flow()),
          limit_(all(law.surface.limit())),
          tip_(all(law.surface.tip())),
          at_tip_(std::isfinite(law.surface.tip())
                      ? std::max(0.0, law.surface.limit() - law.surface.slope() * law.surface.tip())
                      : 0)
    {}

    static constexpr bool gaps = true;
    template <int D>
    Pack respond(PackStress<D>& s, Pack relieved, Pack& strain, Pack& gap) const
    {
        return yield(s, relieved, strain, gap, elasticity, [this](Pack mean, Pack shear) {
            using sluice::packs::larger, sluice::packs::smaller;
            Pack const rigid = all(elasticity.shear()), bulk = all(elasticity.bulk()), zero{};
            Pack const tolerance =
                all(1e-13 * (1 + elasticity.bulk() / elasticity.shear())) * (larger(mean, -mean) + shear + limit_);
            Pack const beyond = shear + slope_ * mean - limit_;
            PackMask const plastic = larger(beyond, mean - tip_) > tolerance;
            Pack const x = larger(zero, beyond) / (rigid + bulk * slope_ * all(flow_));
            Pack const p = mean - bulk * all(flow_) * x, t = shear - rigid * x;
            PackMask const cone = (t >= zero) & (p <= tip_);
            Pack const left = smaller(shear, all(at_tip_));
            Pack const opened = larger(zero, (mean - tip_) / bulk - all(flow_) * (shear - left) / rigid);
            return PackedInvariants{either(cone, p, tip_), either(cone, t, left), either(cone, zero, opened), plastic};
        });
    }

    Elasticity elasticity;

 private:
    Pack slope_;
    double flow_;
    Pack limit_, tip_;
    double at_tip_;  //!< shear stress on the cut-off [Pa]
};

class PackedMuOfI
{
 public:
    PackedMuOfI(MuOfI const& law, double dt)
        : elasticity(law.elasticity),
          static_(law.static_friction),
          limit_(law.limit_friction),
          scale_(dt * law.elasticity.shear() * law.inertial_number /
                 (std::sqrt(law.grain_density) * law.grain_diameter))
    {}

    static constexpr bool gaps = true;
    template <int D>
    Pack respond(PackStress<D>& s, Pack relieved, Pack& strain, Pack& gap) const
    {
        return yield(s, relieved, strain, gap, elasticity, [this](Pack mean, Pack trial) {
            using sluice::packs::larger, sluice::packs::root;
            Pack const zero{}, pressure = larger(zero, -mean);
            Pack const least = all(static_) * pressure, most = all(limit_) * pressure;
            Pack const scale = all(scale_) * root(pressure);
            Pack const sum = trial + most + scale, product = trial * most + scale * least;
            PackMask const flows = trial > least;
            Pack const below = sum + root(larger(zero, sum * sum - all(4) * product));
            Pack const shear = either(flows, all(2) * product / either(flows, below, all(1)), trial);
            Pack const opened = larger(zero, mean) * all(1 / elasticity.bulk());
            return PackedInvariants{-pressure, shear, opened, (shear < trial) | (mean > zero)};
        });
    }

    Elasticity elasticity;

 private:
    double static_, limit_, scale_;
};

}  // namespace mpm
