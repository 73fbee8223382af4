#include <doctest/doctest.h>

#include "participants/dem/config.hpp"
#include "participants/dem/packed_contacts.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/solver.hpp"
#include "tests/participants/dem/scenes.hpp"

//! The packed loops against the plain ones, which are their oracle: not a bit may differ.
namespace {

using dem::Rolling;
using dem::Scheme;
using dem::Vec3;

//! Spheres that fall, turn, meet, slide and part in a box with a moving floor.
dem::Solver<3> tumbling(Rolling rolling, Scheme scheme, bool plain, bool ledger = false, int threads = 1)
{
    dem::ContactConfig c = unit::rolling_contact(0.3, rolling);
    c.normal_stiffness = 1e5;
    c.tangential_stiffness = 2e5 / 7.0;
    dem::Setup<3> s;
    s.gravity = {1.0, 0.5, -9.81};
    s.law = dem::contact_law(c);
    s.skin = 1e-3;
    s.plain = plain;
    s.threads = threads;
    s.features = {.friction = true, .rolling = rolling, .scheme = scheme, .ledger = ledger};
    auto const wall = [&](Vec3 point, Vec3 normal, Vec3 velocity) {
        dem::WallMotion<3> motion;
        motion.velocity = velocity;
        s.walls.push_back({.name = "w", .shape = dem::Plane<3>{point, normal}, .motion = motion, .law = s.law});
    };
    wall({}, {0, 0, 1}, {0.2, 0.0, 0.05});
    wall({}, {1, 0, 0}, {});
    wall({}, {0, 1, 0}, {});
    wall({0.05, 0, 0}, {-1, 0, 0}, {});
    wall({0, 0.05, 0}, {0, -1, 0}, {});
    s.walls.push_back({.name = "pillar",
                       .shape = dem::Cylinder<3>{{0.025, 0.025, 0.0}, {0, 0, 1}, 0.004, false},
                       .motion = {},
                       .law = s.law});
    dem::Random random(5);
    dem::Grains<3> g;
    for (int k = 0; k < 5 * 5 * 9 + 2; ++k) {
        auto const about = [&](double scale) { return random.uniform(-scale, scale); };
        Vec3 const centre{(k % 5 + 0.5) * 0.01 + about(5e-4), (k / 5 % 5 + 0.5) * 0.01 + about(5e-4),
                          (k / 25 + 0.5) * 0.01 + about(5e-4)};
        if (k % 25 == 12) continue;  // where the pillar is
        dem::Motion<3> motion{};
        motion.velocity = {about(1.0), about(1.0), about(1.0)};
        motion.spin = {about(100.0), about(100.0), about(100.0)};
        g.add(centre, random.uniform(3.5e-3, 4.5e-3), 2650.0, motion);
    }
    return {s, g};
}

bool same(dem::State<3> const& a, dem::State<3> const& b)
{
    for (std::size_t i = 0; i < a.grains.size(); ++i)
        if (a.grains.place[i].centre != b.grains.place[i].centre ||
            a.grains.motion[i].velocity != b.grains.motion[i].velocity ||
            a.grains.motion[i].spin != b.grains.motion[i].spin)
            return false;
    for (std::size_t w = 0; w < a.walls.size(); ++w)
        if (a.walls[w].force != b.walls[w].force || a.walls[w].history.friction != b.walls[w].history.friction ||
            a.walls[w].history.rolling != b.walls[w].history.rolling)
            return false;
    return a.pairs.history.friction == b.pairs.history.friction && a.pairs.history.rolling == b.pairs.history.rolling;
}

}  // namespace

TEST_CASE("packed: contacts four at a time are those one at a time, to the last bit")
{
    for (Scheme const scheme : {Scheme::predicted, Scheme::liggghts})
        for (Rolling const rolling : {Rolling::none, Rolling::constant, Rolling::elastic_plastic}) {
            if (scheme == Scheme::liggghts && rolling == Rolling::elastic_plastic) continue;  // not compiled
            CAPTURE(static_cast<int>(scheme));
            CAPTURE(static_cast<int>(rolling));
            dem::Solver<3> packed = tumbling(rolling, scheme, false), plain = tumbling(rolling, scheme, true);
            REQUIRE(dem::is_packed(packed.setup().features, 3));
            for (int n = 0; n < 4000; ++n) {
                packed.step(5e-6);
                plain.step(5e-6);
                if (n % 500 == 0) REQUIRE(same(packed.state(), plain.state()));
            }
            CHECK(same(packed.state(), plain.state()));
            CHECK(packed.state().rebuilds > 5);
        }
}

TEST_CASE("packed: the ledger, which is plain, does not change a bit")
{
    dem::Solver<3> packed = tumbling(Rolling::elastic_plastic, Scheme::predicted, false);
    dem::Solver<3> booked = tumbling(Rolling::elastic_plastic, Scheme::predicted, false, true);
    double const start = booked.energies().balance(), kinetic = booked.energies().kinetic();
    for (int n = 0; n < 4000; ++n) packed.step(5e-6), booked.step(5e-6);
    CHECK(same(packed.state(), booked.state()));
    CHECK(std::abs(booked.energies().wall_work) > 1e-3 * kinetic);
    // the ledger's order is that of the integrator; 5e-6 s is t_c/20 of these contacts
    CHECK(std::abs(booked.energies().balance() - start) < 1e-3 * kinetic);
}

TEST_CASE("packed: the number of threads changes no bit")
{
    for (Scheme const scheme : {Scheme::predicted, Scheme::liggghts}) {
        dem::Solver<3> one = tumbling(Rolling::constant, scheme, false);
        dem::Solver<3> two = tumbling(Rolling::constant, scheme, false, false, 2);
        dem::Solver<3> five = tumbling(Rolling::constant, scheme, false, false, 5);
        for (int n = 0; n < 3000; ++n) {
            one.step(5e-6), two.step(5e-6), five.step(5e-6);
            if (n % 500 == 0) REQUIRE(same(one.state(), two.state()));
        }
        CHECK(same(one.state(), two.state()));
        CHECK(same(one.state(), five.state()));
    }
}
