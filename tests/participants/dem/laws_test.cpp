#include <doctest/doctest.h>

#include <cmath>

#include "participants/dem/contact.hpp"
#include "participants/dem/restitution.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using dem::Vec3;

TEST_CASE("normal_force: spring and dashpot add up, with the reduced mass in the dashpot")
{
    dem::ContactLaw const law = dem::contact_law(unit::contact(0.5, 0.1));
    auto const s = dem::stiffness_at<dem::Elasticity::linear>(law, 1e-3, 1.0);
    CHECK(s.force == close_to(1e3));
    CHECK(s.energy == close_to(0.5));
    CHECK(s.normal == close_to(2.0 * 0.1 * 1e3));  // 2 alpha sqrt(kn)
    CHECK(law.normal.limited(-1.0) == 0.0);
}

TEST_CASE("normal_force: Hertz as Johnson (1985) has it, and its derivatives")
{
    dem::ContactConfig c;
    c.elasticity = dem::Elasticity::hertz;
    c.youngs_modulus = 70e9;
    c.poissons_ratio = 0.22;
    c.friction = 0.3;
    dem::ContactLaw const law = dem::contact_law(c);
    double const modulus = 70e9 / (2.0 * (1.0 - 0.22 * 0.22)), shear = 70e9 / (2.0 * 1.22) / (2.0 * (2.0 - 0.22));
    double const radius = 1e-3, overlap = 1e-6;
    auto const at = [&](double xi) { return dem::stiffness_at<dem::Elasticity::hertz>(law, xi, radius); };
    CHECK(at(overlap).force == close_to(4.0 / 3.0 * modulus * std::sqrt(radius) * std::pow(overlap, 1.5)));
    CHECK(at(overlap).tangential == close_to(8.0 * shear * std::sqrt(radius * overlap)));
    double const h = 1e-10;  // the energy's derivative is the force
    CHECK((at(overlap + h).energy - at(overlap - h).energy) / (2 * h) == close_to(at(overlap).force));
    CHECK(at(0.0).force == 0.0);
}

TEST_CASE("tangential_force: below the limit the spring is left alone")
{
    auto const r = dem::limited(1.0, 0.2, 5.0);
    CHECK(r.force == close_to(1.2));
    CHECK(r.spring == 1.0);
    CHECK_FALSE(r.slides);
}

TEST_CASE("tangential_force: in sliding spring and dashpot together are the limit, either way")
{
    for (double sign : {1.0, -1.0}) {
        auto const r = dem::limited(sign * 100.0, sign * 0.4, 5.0);
        CHECK(r.slides);
        CHECK(r.force == close_to(sign * 5.0));
        CHECK(r.spring + sign * 0.4 == close_to(sign * 5.0));
    }
    auto const r = dem::limited(Vec3{3.0, 4.0, 0.0}, Vec3{}, 1.0);
    CHECK(norm(r.force) == close_to(1.0));
    CHECK(r.force.y == close_to(0.8));
}

TEST_CASE("tangential_force: a contact that is not pressed carries nothing")
{
    CHECK(dem::limited(1.0, 0.1, 0.0).force == 0.0);
    CHECK(dem::limited(0.0, 0.0, 0.0).force == 0.0);
}

TEST_CASE("vec: a spring is turned into the new tangent plane with its length kept, and about the normal")
{
    Vec3 const spring{3.0, 0.0, 4.0}, normal{0.0, 0.0, 1.0};
    Vec3 const flat = dem::carried(spring, normal, 0.0);
    CHECK(norm(flat) == close_to(5.0));
    CHECK(dot(flat, normal) == 0.0);
    CHECK(flat.x == close_to(5.0));
    Vec3 const turned = dem::carried(Vec3{1.0, 0.0, 0.0}, normal, 1e-3);
    CHECK(turned.y == close_to(1e-3));
    CHECK(norm(turned) == close_to(1.0));
    CHECK(dem::carried(Vec3{0.0, 0.0, 1.0}, normal, 0.0) == Vec3{});
}

TEST_CASE("restitution: the damping ratio for a restitution is found again")
{
    for (double e : {0.2, 0.5, 0.787, 0.95, 1.0})
        for (bool const may_pull : {false, true})
            CHECK(dem::restitution(dem::damping_ratio_for(e, may_pull), may_pull) == close_to(e).epsilon(1e-9));
}

TEST_CASE("restitution: the tangential mode shortens the contact time when it is the stiffer one")
{
    CHECK(dem::contact_time(1e6, 2e5, 1e-3) == close_to(dem::contact_time(1e6, 0.0, 1e-3)));
    CHECK(dem::contact_time(1e6, 1e6, 1e-3) == close_to(dem::contact_time(3e6, 0.0, 1e-3)));
    CHECK(dem::contact_time(1e6, 1e6, 1e-3, 3) == close_to(dem::contact_time(3.5e6, 0.0, 1e-3)));
}
