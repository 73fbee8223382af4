#include "participants/mpm/laws.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/close_to.hpp"

namespace {

using mpm::Increment;
using mpm::Mat3;
using mpm::Matter;
using mpm::Vec3;

constexpr double degree = std::numbers::pi / 180;

Mat3 rotation(double angle, Vec3 const& axis)
{
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

//! Applies an increment of the deformation gradient.
template <class Law>
double deform(Law const& law, Matter& m, Mat3 const& change)
{
    m.gradient = change * m.gradient;
    m.ratio *= change.determinant();
    return law.respond(m, Increment(change));
}

Mat3 random_symmetric(std::mt19937& random, double size)
{
    std::normal_distribution<double> normal(0, size);
    Mat3 a;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) a(i, j) = a(j, i) = normal(random);
    return a;
}

mpm::Elasticity const soil{1e7, 0.3};

}  // namespace

TEST_CASE("increment: a rotation has no strain and turns by itself, whatever its angle")
{
    for (double angle : {1e-6, 0.01, 1.0, 3.0}) {
        Mat3 const r = rotation(angle, {1, 2, -0.5});
        Increment const step(r);
        CHECK(step.strain.norm() < 1e-13);
        CHECK((step.turn - r).norm() < 1e-13);
        CHECK(step.ratio == close_to(1));
    }
}

TEST_CASE("increment: a stretch is its logarithm to third order")
{
    Mat3 stretch = Mat3::Identity();
    stretch(0, 0) = 1.01;
    CHECK(std::abs(Increment(stretch).strain(0, 0) - std::log(1.01)) < 1e-6 / 12);  // x^3/12
    CHECK((Increment(stretch).turn - Mat3::Identity()).norm() == 0);
}

TEST_CASE("principal: values in order, directions orthogonal, the tensor again")
{
    std::mt19937 random(3);
    for (int k = 0; k < 2000; ++k) {
        Mat3 a = random_symmetric(random, 1e5);
        if (k % 2) a(0, 2) = a(2, 0) = a(1, 2) = a(2, 1) = 0;  // plane strain
        if (k % 10 == 1) a(0, 1) = a(1, 0) = 0;
        if (k % 20 == 1) a(0, 0) = a(1, 1) = a(2, 2);
        auto const p = mpm::principal(a);
        CHECK(p.value[0] >= p.value[1]);
        CHECK(p.value[1] >= p.value[2]);
        CHECK((p.tensor(p.value) - a).norm() < 1e-9);
        CHECK((p.direction.transpose() * p.direction - Mat3::Identity()).norm() < 1e-13);
    }
}

TEST_CASE("linear elastic: a turn by 360 degrees brings the stress back")
{
    mpm::LinearElastic const law{soil};
    Matter m;
    m.stress << -100, 30, 5, 30, 50, 0, 5, 0, 20;
    Mat3 const start = m.stress;
    for (int k = 0; k < 360; ++k) deform(law, m, rotation(degree, {0.3, 0, 1}));
    CHECK((m.stress - start).norm() < 360 * 1e-15 * soil.youngs_modulus);  // rounding of the strain, times E
    CHECK(m.ratio == close_to(1));
}

TEST_CASE("linear elastic: confined compression is the logarithm of the stretch")
{
    mpm::LinearElastic const law{soil};
    Matter m;
    Mat3 stretch = Mat3::Identity();
    int const steps = 1000;
    stretch(1, 1) = std::pow(0.5, 1.0 / steps);
    for (int k = 0; k < steps; ++k) deform(law, m, stretch);
    CHECK(m.stress(1, 1) == close_to(soil.wave() * std::log(0.5)).epsilon(1e-6));
    CHECK(m.stress(0, 0) == close_to(soil.lame() * std::log(0.5)).epsilon(1e-6));
}

TEST_CASE("neo-hookean: stress is the derivative of its energy, and turns with the body")
{
    mpm::NeoHookean const law{soil};
    std::mt19937 random(5);
    for (int k = 0; k < 100; ++k) {
        Matter m;
        Mat3 const start = Mat3::Identity() + random_symmetric(random, 0.1);
        deform(law, m, start);
        Mat3 const direction = random_symmetric(random, 1);
        double const h = 1e-6;
        Matter more = m, less = m;
        deform(law, more, Mat3::Identity() + h * direction);
        deform(law, less, Mat3::Identity() - h * direction);
        double const power = (more.ratio * law.energy(more) - less.ratio * law.energy(less)) / (2 * h);
        CHECK(power == close_to(m.ratio * mpm::contract(m.stress, direction)).epsilon(1e-5));
        Matter turned = m;
        Mat3 const r = rotation(1.3, {1, 1, 3});
        deform(law, turned, r);
        CHECK((turned.stress - r * m.stress * r.transpose()).norm() < 1e-9 * soil.youngs_modulus);
    }
}

namespace {

mpm::MohrCoulombParameters parameters(double phi, double psi, double cohesion, double tension)
{
    return {phi * degree, psi * degree, cohesion, tension};
}

double tip(double phi, double cohesion)
{
    return cohesion / std::tan(phi * degree);
}

}  // namespace

TEST_CASE("mohr-coulomb: a million trials end on or within the surface, once")
{
    struct Case
    {
        double phi, psi, cohesion, tension;
    };
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, 1);
    int plastic = 0, all = 0;
    for (Case const c : {Case{30, 0, 1e4, tip(30, 1e4)}, Case{23, 0, 0, 0}, Case{35, 10, 5e3, 2e3}, Case{40, 40, 0, 0},
                         Case{0, 0, 1e4, HUGE_VAL}, Case{0, 0, 1e4, 1e3}, Case{45, 5, 1e4, 0}, Case{1, 1, 10, 100},
                         Case{60, 0, 1e3, 100}, Case{20, 20, 1e5, 1e5}}) {
        mpm::MohrCoulombSurface const surface(soil, parameters(c.phi, c.psi, c.cohesion, c.tension));
        for (int k = 0; k < 100000; ++k) {
            double const size = std::pow(10, 2 + 4 * std::generate_canonical<double, 30>(random));
            double const mean = size * normal(random) * (k % 3);
            Vec3 trial(mean + size * normal(random), mean + size * normal(random), mean + size * normal(random));
            if (k % 7 == 0) trial[1] = trial[0];  // corners
            if (k % 11 == 0) trial[2] = trial[1];
            std::sort(trial.data(), trial.data() + 3, std::greater<>());
            auto const back = surface.bring_back(trial);
            double const scale = trial.cwiseAbs().maxCoeff() + c.cohesion;
            ++all;
            plastic += back.plastic;
            // to rounding of what is added up: trial stresses, times a few
            if (!(surface.excess(back.stress) <= 1e-11 * scale)) FAIL("phi ", c.phi, " trial ", trial.transpose());
            if (back.plastic != (surface.excess(trial) > 1e-11 * scale) &&
                std::abs(surface.excess(trial)) > 1e-11 * scale)
                FAIL("elastic and plastic mixed up");
            if (!back.plastic) CHECK((back.stress - trial).norm() == 0);
            if (back.stress[0] < back.stress[1] - 1e-10 * scale || back.stress[1] < back.stress[2] - 1e-10 * scale)
                FAIL("order lost");
            auto const again = surface.bring_back(back.stress);
            if ((again.stress - back.stress).norm() > 1e-10 * scale) FAIL("a second return moves it");
        }
    }
    CHECK(all == 1000000);
    CHECK(plastic > all / 4);
    CHECK(plastic < all);
}

TEST_CASE("mohr-coulomb: with associated flow the return is the nearest point in the energy norm")
{
    mpm::MohrCoulombSurface const surface(soil, parameters(25, 25, 1e4, tip(25, 1e4)));
    std::mt19937 random(11);
    std::normal_distribution<double> normal(0, 3e4);
    auto const distance = [](Vec3 const& a, Vec3 const& b) {
        Mat3 const difference = (a - b).asDiagonal();
        return soil.energy(difference);
    };
    for (int k = 0; k < 2000; ++k) {
        Vec3 trial(normal(random), normal(random), normal(random));
        std::sort(trial.data(), trial.data() + 3, std::greater<>());
        auto const back = surface.bring_back(trial);
        double const least = distance(trial, back.stress);
        for (int other = 0; other < 50; ++other) {
            Vec3 const near = back.stress + 0.3 * Vec3(normal(random), normal(random), normal(random));
            Vec3 sorted = near;
            std::sort(sorted.data(), sorted.data() + 3, std::greater<>());
            if (surface.excess(sorted) > 0) continue;
            CHECK(distance(trial, near) >= least * (1 - 1e-10));
        }
    }
}

TEST_CASE("mohr-coulomb: what tension opened closes before pressure comes back")
{
    mpm::MohrCoulomb const law{soil, mpm::MohrCoulombSurface(soil, parameters(23, 0, 0, 0))};
    Matter m;
    auto const stretched = [](double by) -> Mat3 { return std::exp(by) * Mat3::Identity(); };
    for (int k = 0; k < 100; ++k) deform(law, m, stretched(1e-4));
    CHECK(m.stress.norm() < 1e-9 * soil.youngs_modulus * 1e-4);
    CHECK(m.gap == close_to(0.03).epsilon(1e-6));
    for (int k = 0; k < 100; ++k) deform(law, m, stretched(-1e-4));
    CHECK(m.gap < 1e-9);
    CHECK(m.stress.norm() < 1e-7 * soil.youngs_modulus);
    deform(law, m, stretched(-1e-4));
    CHECK(m.stress(0, 0) == close_to(-3 * soil.bulk() * 1e-4).epsilon(1e-3));
}

TEST_CASE("mohr-coulomb: dissipation is never negative, and stress turns with the body")
{
    mpm::MohrCoulomb const law{soil, mpm::MohrCoulombSurface(soil, parameters(30, 5, 1e3, 500))};
    std::mt19937 random(13);
    Matter m, turned;
    Mat3 const r = rotation(0.7, {1, -1, 2});
    for (int k = 0; k < 5000; ++k) {
        Mat3 const change = Mat3::Identity() + random_symmetric(random, 2e-4);
        double const lost = deform(law, m, change);
        CHECK(lost >= -1e-9 * soil.youngs_modulus * 1e-4);
        CHECK(deform(law, turned, r * change * r.transpose()) == close_to(lost).epsilon(1e-6).scale(1.0));
        CHECK((turned.stress - r * m.stress * r.transpose()).norm() < 1e-8 * soil.youngs_modulus * 1e-3);
    }
    CHECK(m.plastic_strain > 0.1);
}

TEST_CASE("drucker-prager: trials end on or within the surface, once, and nothing is gained")
{
    std::mt19937 random(11);
    std::normal_distribution<double> normal(0, 1);
    int plastic = 0;
    for (auto const cone : {mpm::Cone::plane_strain, mpm::Cone::compression, mpm::Cone::extension})
        for (double const phi : {0.0, 1.0, 30.0, 60.0})
            for (double const cohesion : {0.0, 1e4})
                for (double const psi : {0.0, phi}) {
                    if (phi == 0 && cohesion == 0) continue;
                    mpm::DruckerPragerParameters p{phi * degree, psi * degree, cohesion, HUGE_VAL, cone};
                    double const tip = mpm::DruckerPragerSurface(soil, p).tip();
                    for (double const cut : {1.0, 0.4}) {
                        p.tension = std::isfinite(tip) ? cut * tip : 1e3;
                        mpm::DruckerPrager const law{soil, mpm::DruckerPragerSurface(soil, p)};
                        for (int k = 0; k < 5000; ++k) {
                            double const size = std::pow(10, 2 + 4 * std::generate_canonical<double, 30>(random));
                            double const mean = size * normal(random), shear = size * std::abs(normal(random));
                            auto const back = law.surface.bring_back(mean, shear);
                            double const scale = std::abs(mean) + shear + cohesion;
                            plastic += back.plastic;
                            // to rounding of what is added up: trial stresses, times a few
                            if (!(law.surface.excess(back.mean, back.shear) <= 1e-11 * scale))
                                FAIL("phi ", phi, " trial ", mean, ", ", shear);
                            auto const again = law.surface.bring_back(back.mean, back.shear);
                            CHECK(std::abs(again.mean - back.mean) + std::abs(again.shear - back.shear) <=
                                  1e-10 * scale);
                            CHECK(back.shear <= shear);
                            CHECK(back.opened >= 0);
                            Matter m;
                            m.stress = mean * Mat3::Identity();
                            m.stress(0, 1) = m.stress(1, 0) = shear;
                            double const lost = law.respond(m, mpm::Increment(Mat3::Identity()));
                            CHECK(lost >= -1e-10 * scale * scale / soil.youngs_modulus);
                        }
                    }
                }
    CHECK(plastic > 10000);
}
