#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/verification/mpm/bars.hpp"
#include "tests/verification/mpm/elements.hpp"

using namespace verification;

namespace {

using mpm::Mat3;

struct Soil
{
    double phi, cohesion, psi, pressure, modulus, poisson;  //!< degrees, Pa
};

mpm::MohrCoulomb law_of(Soil const& s)
{
    double const degree = std::numbers::pi / 180, tan = std::tan(s.phi * degree);
    mpm::Elasticity const e{s.modulus, s.poisson};
    return {e, mpm::MohrCoulombSurface(e, {s.phi * degree, s.psi * degree, s.cohesion, s.cohesion / tan})};
}

}  // namespace

//! M04: one element of Mohr-Coulomb soil in plane strain (file M04_mohr_coulomb_element.csv, closed forms). Marks: 1e-6
//! of stresses for an implicit return; 1e-3 elsewhere.
TEST_CASE("M04: Mohr-Coulomb in biaxial compression, at failure and beyond")
{
    struct Row
    {
        Soil soil;
        double first, second, strain, flow;  //!< of the file: s1, s2 [Pa], axial strain at yield, d ev / d e1
    };
    // of the file: phi, c, psi, s3, E, nu and what follows from them
    for (Row const& row :
         {Row{{30, 1e4, 0, 1e5, 1e7, 0.3}, 334641.0162, 170392.3048, 0.02135233247, 0},
          Row{{23, 0, 0, 1e4, 1.98e6, 0.23}, 22826.22982, 12950.03286, 0.006135213265, 0},
          Row{{35, 5e3, 10, 5e4, 2e7, 0.2}, 203718.4379, 80743.68758, 0.007378485018, -0.4202766255}}) {
        Stopwatch const watch;
        auto const law = law_of(row.soil);
        mpm::Matter m;
        m.stress = -row.soil.pressure * Mat3::Identity();
        double strain = 0, lateral = 0, worst = 0;
        auto const compress = [&](double by) {
            Mat3 axial = Mat3::Zero();
            axial(1, 1) = -by;
            lateral += std::log1p(hold(law, m, axial, 0, -row.soil.pressure));
            strain -= std::log1p(-by);
        };
        double const fine = 1e-7 * row.strain;  // near yield, which is known to a step
        while (m.plastic_strain == 0 && strain < 1) compress(strain < 0.999 * row.strain ? 1e-3 * row.strain : fine);
        double const first = -m.stress(1, 1), second = -m.stress(2, 2), yielded = strain;
        lateral = 0;
        while (strain < 11 * yielded) {
            compress(1e-2 * row.strain);
            worst = std::max(worst, relative(-m.stress(1, 1), row.first));
        }
        double const flow = (strain - yielded - lateral) / (strain - yielded);  // compression > 0
        std::string const name = named("phi = %.0f: ", row.soil.phi);
        CHECK(report(
            {"M04", name + "s1 at failure [Pa]", first, row.first, relative(first, row.first), 1e-6, watch.seconds()}));
        CHECK(report({"M04", name + "s2 at failure [Pa]", second, row.second, relative(second, row.second), 1e-6,
                      watch.seconds()}));
        CHECK(report({"M04", name + "axial strain at yield", yielded, row.strain, relative(yielded, row.strain), 1e-6,
                      watch.seconds()}));
        CHECK(report({"M04", name + "s1 over ten more yield strains", worst, 0, worst, 1e-6, watch.seconds()}));
        CHECK(report({"M04", name + "volume strain by axial strain", flow, row.flow, std::abs(flow - row.flow), 1e-3,
                      watch.seconds()}));
    }
}

//! The closed form is of small strain; a finite turn leaves stress behind by s/2G. Pressures are a hundredth of the
//! file's.
TEST_CASE("M04: Mohr-Coulomb in simple shear under constant pressure")
{
    for (auto const& [soil, ratio, tangent] :
         {std::tuple{Soil{30, 0, 0, 1e3, 1e7, 0.3}, 0.5, 0.5773502692},
          std::tuple{Soil{23, 0, 0, 1e2, 1.98e6, 0.23}, 0.3907311285, 0.4244748162},
          std::tuple{Soil{35, 0, 10, 5e2, 2e7, 0.2}, 0.6273465537, 0.7002075382}}) {  // c = 0: t/s is of the friction
        Stopwatch const watch;
        auto const law = law_of(soil);
        mpm::Matter m;
        m.stress = -soil.pressure * Mat3::Identity();
        Mat3 shear = Mat3::Zero();
        shear(0, 1) = 1e-6;
        for (int k = 0; k < 4000; ++k) hold(law, m, shear, 1, -soil.pressure);
        double const got = m.stress(0, 1) / soil.pressure;
        CHECK(report({"M04", named("phi = %.0f, psi = %.0f: t/s in simple shear", soil.phi, soil.psi), got, ratio,
                      relative(got, ratio), 1e-3, watch.seconds()}));
        CHECK(std::abs(got - tangent) > 0.01);
    }
}

TEST_CASE("M04: Mohr-Coulomb pulled beyond the tip stays there, and is finite")
{
    Stopwatch const watch;
    Soil const soil{30, 1e4, 0, 1e5, 1e7, 0.3};
    auto const law = law_of(soil);
    mpm::Matter m;
    m.stress = -soil.pressure * Mat3::Identity();
    for (int k = 0; k < 200; ++k) law.respond(m, mpm::Increment(1.001 * Mat3::Identity()));
    double const tip = soil.cohesion / std::tan(soil.phi * std::numbers::pi / 180);
    double const off = (m.stress - tip * Mat3::Identity()).norm() / tip;
    CHECK(report({"M04", "stress at the tip, c cot(phi) [Pa]", m.stress(0, 0), tip, off, 1e-6, watch.seconds()}));
}
