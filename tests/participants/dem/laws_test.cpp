#include <doctest/doctest.h>

#include "participants/dem/normal_force.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/dem/tangential_force.hpp"

TEST_CASE("normal_force: spring and dashpot add up, with the reduced mass in the dashpot")
{
    dem::NormalForce const law = dem::make_normal_force(1e4, 0.1);
    CHECK(law(1e-3, 0.0, 2.0) == doctest::Approx(10.0));
    CHECK(law(0.0, 0.5, 2.0) == doctest::Approx(2.0 * 0.1 * 100.0 * 2.0 * 0.5));  // 2 alpha sqrt(kn m*) v
}

TEST_CASE("normal_force: never pulls")
{
    dem::NormalForce const law = dem::make_normal_force(1e4, 0.5);
    CHECK(law(1e-6, -10.0, 1.0) == 0.0);
    CHECK(law(0.0, -1.0, 1.0) == 0.0);
}

TEST_CASE("tangential_force: below the limit the spring is left alone")
{
    dem::TangentialForce const law = dem::make_tangential_force(1e4, 0.1, 0.5);
    auto const r = law(1e-4, 0.01, 10.0, 1.0);
    CHECK(r.force == doctest::Approx(1.0 + 2.0 * 0.1 * 100.0 * 0.01));
    CHECK(r.spring == 1e-4);
    CHECK_FALSE(r.slides);
}

TEST_CASE("tangential_force: in sliding spring and dashpot together are the limit, either way")
{
    dem::TangentialForce const law = dem::make_tangential_force(1e4, 0.1, 0.5);
    for (double sign : {1.0, -1.0}) {
        auto const r = law(sign * 1e-2, sign * 0.02, 10.0, 1.0);
        CHECK(r.slides);
        CHECK(r.force == doctest::Approx(sign * 5.0));
        CHECK(1e4 * r.spring + 2.0 * 0.1 * 100.0 * sign * 0.02 == doctest::Approx(sign * 5.0));
    }
}

TEST_CASE("tangential_force: a contact that is not pressed carries nothing")
{
    dem::TangentialForce const law = dem::make_tangential_force(1e4, 0.1, 0.5);
    CHECK(law(1e-4, 0.01, 0.0, 1.0).force == 0.0);
}

TEST_CASE("restitution: the damping ratio for a restitution is found again")
{
    for (double e : {0.2, 0.5, 0.787, 0.95, 1.0})
        CHECK(dem::restitution(dem::damping_ratio_for(e)) == doctest::Approx(e).epsilon(1e-9));
}

TEST_CASE("restitution: the tangential mode of a disc shortens the contact time when it is the stiffer one")
{
    CHECK(dem::contact_time(1e6, 2e5, 1e-3) == doctest::Approx(dem::contact_time(1e6, 0.0, 1e-3)));
    CHECK(dem::contact_time(1e6, 1e6, 1e-3) == doctest::Approx(dem::contact_time(3e6, 0.0, 1e-3)));
}
