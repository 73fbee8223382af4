#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/verification/mpm/bars.hpp"
#include "tests/verification/mpm/elements.hpp"

//! M04 for Drucker and Prager, and for a friction that grows with the rate: closed forms.
using namespace verification;

namespace {

using mpm::Mat3;

constexpr double degree = std::numbers::pi / 180;

mpm::DruckerPrager cone_of(double phi, double psi, double cohesion, mpm::Cone cone)
{
    mpm::Elasticity const e{1e7, 0.3};
    return {e, mpm::DruckerPragerSurface(e, {phi * degree, psi * degree, cohesion, HUGE_VAL, cone})};
}

struct Failed
{
    double stress, flow;  //!< axial [Pa], compression > 0; d(volume strain)/d(axial strain)
};

//! Compressed along y (or pulled: `by` < 0) under a pressure along x, and along z if not in plane strain.
Failed compressed(mpm::DruckerPrager const& law, double pressure, double by, bool plane)
{
    mpm::Matter m;
    m.stress = -pressure * Mat3::Identity();
    double volume = 0;
    Mat3 axial = Mat3::Zero();
    axial(1, 1) = -by;
    for (int k = 0; k < 3000; ++k) {
        double const before = m.ratio, lateral = hold(law, m, axial, 0, -pressure, !plane);
        m.ratio = before;
        volume = -by + (plane ? 1 : 2) * lateral;  // of the step
    }
    return {-m.stress(1, 1), volume / -by};
}

}  // namespace

//! The cone for plane strain fails where Mohr and Coulomb's hexagon does, once plastic flow has set the stress across,
//! and dilates as it: s1 = s3 K + 2 c sqrt(K), K = (1 + sin phi)/(1 - sin phi), d ev / d e1 = -2 sin psi / (1 - sin
//! psi). Those through its edges do in triaxial compression and extension. Marks as for Mohr and Coulomb: 1e-6, 1e-3.
TEST_CASE("M04: Drucker-Prager at failure, in plane strain and triaxial")
{
    struct Row
    {
        double phi, psi, cohesion, pressure;
    };
    for (Row const& r : {Row{30, 0, 1e4, 1e5}, Row{35, 10, 5e3, 5e4}, Row{23, 23, 0, 1e4}}) {
        Stopwatch const watch;
        double const sin = std::sin(r.phi * degree), K = (1 + sin) / (1 - sin);
        double const high = r.pressure * K + 2 * r.cohesion * std::sqrt(K);
        double const low = (r.pressure - 2 * r.cohesion * std::sqrt(K)) / K;
        auto const plane =
            compressed(cone_of(r.phi, r.psi, r.cohesion, mpm::Cone::plane_strain), r.pressure, 1e-4, true);
        auto const outer =
            compressed(cone_of(r.phi, r.psi, r.cohesion, mpm::Cone::compression), r.pressure, 1e-4, false);
        auto const inner =
            compressed(cone_of(r.phi, r.psi, r.cohesion, mpm::Cone::extension), r.pressure, -1e-4, false);
        double const sin_psi = std::sin(r.psi * degree), flow = -2 * sin_psi / (1 - sin_psi);
        std::string const name = named("Drucker-Prager, phi = %.0f, psi = %.0f: ", r.phi, r.psi);
        auto const check = [&](char const* what, double value, double reference) {
            CHECK(report({"M04", name + what, value, reference, relative(value, reference), 1e-6, watch.seconds()}));
        };
        check("plane strain [Pa]", plane.stress, high);
        check("compression [Pa]", outer.stress, high);
        check("extension [Pa]", inner.stress, low);
        CHECK(report({"M04", name + "dilation in plane strain", plane.flow, flow, std::abs(plane.flow - flow), 1e-3,
                      watch.seconds()}));
    }
}

TEST_CASE("M04: Drucker-Prager pulled beyond the tip, or the cut-off, stays there")
{
    Stopwatch const watch;
    mpm::Elasticity const e{1e7, 0.3};
    for (double const cut : {1.0, 0.3}) {
        double const tip = cone_of(30, 10, 1e4, mpm::Cone::plane_strain).surface.tip();
        mpm::DruckerPrager const law{
            e, mpm::DruckerPragerSurface(e, {30 * degree, 10 * degree, 1e4, cut * tip, mpm::Cone::plane_strain})};
        mpm::Matter m;
        m.stress.diagonal() << -1e4, -2e4, -1e4;
        for (int k = 0; k < 200; ++k) law.respond(m, mpm::Increment(1.001 * Mat3::Identity()));
        double const off = std::abs(m.stress.trace() / 3 / (cut * tip) - 1);
        CHECK(report({"M04", named("Drucker-Prager: mean stress pulled, %.1f of the tip [Pa]", cut),
                      m.stress.trace() / 3, cut * tip, off, 1e-6, watch.seconds()}));
        CHECK(law.surface.excess(m.stress.trace() / 3, 0) <= 1e-9 * tip);
    }
}

//! Simple shear at a rate under a pressure: t/p = mu(I). The flow keeps the volume, hence the pressure. Mark: a turn by
//! the elastic shear leaves 1e-5 of stress behind; 1e-4.
TEST_CASE("M04: mu(I) in steady shear")
{
    mpm::MuOfI const law{{1e7, 0.3}, 0.38, 0.64, 0.279, 1e-3, 2500};
    for (double const pressure : {100.0, 1e3})
        for (double const inertia : {1e-3, 0.03, 0.3, 3.0}) {
            Stopwatch const watch;
            double const rate = inertia / (law.grain_diameter * std::sqrt(law.grain_density / pressure));
            mpm::Matter m;
            m.stress = -pressure * Mat3::Identity();
            Mat3 change = Mat3::Identity();
            change(0, 1) = 1e-6;
            for (int k = 0; k < 3000; ++k) law.respond(m, mpm::Increment(change, change(0, 1) / rate));
            double const got = -m.stress(0, 1) / (m.stress.trace() / 3);
            double const mu = 0.38 + (0.64 - 0.38) / (1 + 0.279 / inertia);
            CHECK(report({"M04", named("mu(I): t/p in shear, I = %g, p = %g Pa", inertia, pressure), got, mu,
                          relative(got, mu), 1e-4, watch.seconds()}));
        }
    mpm::Matter m;  // below mu_s it bears shear as a solid
    m.stress = -1e3 * Mat3::Identity();
    Mat3 change = Mat3::Identity();
    change(0, 1) = 1e-6;
    for (int k = 0; k < 90; ++k) law.respond(m, mpm::Increment(change, 1e-3));
    CHECK(m.plastic_strain == 0);
    double const elastic = 90e-6 * law.elasticity.shear();
    CHECK(std::abs(m.stress(0, 1) - elastic) < 1e-3 * elastic);
    for (int k = 0; k < 100; ++k) law.respond(m, mpm::Increment(1.001 * Mat3::Identity(), 1e-3));
    CHECK(m.stress.norm() == 0);
    CHECK(m.gap > 0.09);
}
