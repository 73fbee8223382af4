#include <doctest/doctest.h>

#include "participants/dem/config.hpp"
#include "participants/dem/packed_contacts.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/solver.hpp"
#include "tests/participants/dem/scenes.hpp"

//! The packed loops against the plain ones, which are their oracle: not a bit may differ.
namespace {

using dem::Elasticity;
using dem::Rolling;
using dem::Scheme;
using dem::Vec3;

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

//! Tumbling spheres with a ledger, and a dashpot along the contacts.
dem::Solver<3> booked(Elasticity elasticity, Rolling rolling, double tangential_damping, bool plain, int threads = 1)
{
    dem::Solver<3> const tumbling = unit::tumbling(rolling, Scheme::predicted, plain, true, threads, elasticity);
    dem::Setup<3> setup = tumbling.setup();
    auto const damp = [&](dem::ContactLaw& law) {
        law.tangential.damping = 2.0 * tangential_damping * std::sqrt(law.tangential.stiffness);
    };
    damp(setup.law);
    for (auto& wall : setup.walls) damp(wall.law);
    return {setup, tumbling.grains()};
}

}  // namespace

TEST_CASE("packed: contacts four at a time are those one at a time, to the last bit")
{
    for (Elasticity const elasticity : {Elasticity::linear, Elasticity::hertz})
        for (Scheme const scheme : {Scheme::predicted, Scheme::liggghts})
            for (Rolling const rolling : {Rolling::none, Rolling::constant, Rolling::elastic_plastic}) {
                if (scheme == Scheme::liggghts && rolling == Rolling::elastic_plastic) continue;  // not compiled
                CAPTURE(static_cast<int>(elasticity));
                CAPTURE(static_cast<int>(scheme));
                CAPTURE(static_cast<int>(rolling));
                dem::Solver<3> packed = unit::tumbling(rolling, scheme, false, false, 1, elasticity),
                               plain = unit::tumbling(rolling, scheme, true, false, 1, elasticity);
                REQUIRE(dem::is_packed(packed.setup().features, 3));
                for (int n = 0; n < 3000; ++n) {
                    packed.step(5e-6);
                    plain.step(5e-6);
                    if (n % 500 == 0) REQUIRE(same(packed.state(), plain.state()));
                }
                CHECK(same(packed.state(), plain.state()));
                CHECK(packed.state().rebuilds > 5);
            }
}

TEST_CASE("packed: the ledger does not change a bit, and closes")
{
    dem::Solver<3> packed = unit::tumbling(Rolling::elastic_plastic, Scheme::predicted, false);
    dem::Solver<3> booked = unit::tumbling(Rolling::elastic_plastic, Scheme::predicted, false, true);
    double const start = booked.energies().balance(), kinetic = booked.energies().kinetic();
    for (int n = 0; n < 4000; ++n) packed.step(5e-6), booked.step(5e-6);
    CHECK(same(packed.state(), booked.state()));
    CHECK(std::abs(booked.energies().wall_work) > 1e-3 * kinetic);
    // the ledger's order is that of the integrator; 5e-6 s is t_c/20 of these contacts
    CHECK(std::abs(booked.energies().balance() - start) < 1e-3 * kinetic);
}

TEST_CASE("packed: all that the ledger books is what it books one contact at a time, to the last bit")
{
    for (Elasticity const law : {Elasticity::linear, Elasticity::hertz})
        for (Rolling const rolling : {Rolling::none, Rolling::constant, Rolling::elastic_plastic}) {
            double const damping = rolling == Rolling::constant ? 0.0 : 0.2;
            CAPTURE(static_cast<int>(law));
            CAPTURE(static_cast<int>(rolling));
            dem::Solver<3> plain = booked(law, rolling, damping, true), packed = booked(law, rolling, damping, false),
                           shared = booked(law, rolling, damping, false, 3);
            for (int n = 0; n < 3000; ++n) {
                plain.step(5e-6), packed.step(5e-6), shared.step(5e-6);
                if (n % 500 != 0) continue;
                REQUIRE(unit::same_books(plain.state(), packed.state()));
                REQUIRE(unit::same_books(plain.state(), shared.state()));
            }
            CHECK(unit::same_books(plain.state(), packed.state()));
            CHECK(unit::same_books(plain.state(), shared.state()));
            dem::Booked const& b = plain.state().booked;
            CHECK(b.normal_dashpot > 0.0);
            CHECK(b.sliding > 0.0);
            CHECK(b.touch != 0.0);
            if (damping > 0.0) CHECK(b.tangential_dashpot > 0.0);
            CHECK((b.rolling > 0.0) == (rolling != Rolling::none));
        }
}

TEST_CASE("packed: the number of threads changes no bit")
{
    for (Scheme const scheme : {Scheme::predicted, Scheme::liggghts}) {
        dem::Solver<3> one = unit::tumbling(Rolling::constant, scheme, false);
        dem::Solver<3> two = unit::tumbling(Rolling::constant, scheme, false, false, 2);
        dem::Solver<3> five = unit::tumbling(Rolling::constant, scheme, false, false, 5);
        REQUIRE(two.state().pairs.ranges.size() == 2);
        REQUIRE(five.state().pairs.ranges.size() > 2);
        for (int n = 0; n < 3000; ++n) {
            one.step(5e-6), two.step(5e-6), five.step(5e-6);
            if (n % 500 == 0) REQUIRE(same(one.state(), two.state()));
        }
        CHECK(same(one.state(), two.state()));
        CHECK(same(one.state(), five.state()));
    }
}

TEST_CASE("threads: discs and spheres without friction, one contact at a time, are the same to the last bit")
{
    auto const check = [](auto start, double dt) {
        auto one = start;
        auto setup = start.setup();
        setup.threads = 3;
        std::remove_const_t<decltype(start)> three(setup, start.grains());
        REQUIRE(three.state().pairs.ranges.size() > 1);
        for (int n = 0; n < 3000; ++n) one.step(dt), three.step(dt);
        for (std::size_t i = 0; i < one.grains().size(); ++i) {
            REQUIRE(one.grains().place[i].centre == three.grains().place[i].centre);
            REQUIRE(one.grains().motion[i].velocity == three.grains().motion[i].velocity);
        }
        CHECK(one.state().pairs.history.friction == three.state().pairs.history.friction);
        CHECK(unit::same_books(one.state(), three.state()));
        CHECK(one.state().rebuilds > 1);
    };
    check(unit::box(false), unit::step);
    check(unit::box(true), unit::step);
    auto const rough = unit::tumbling(Rolling::none, Scheme::predicted, false, true);
    dem::Setup<3> smooth = rough.setup();
    smooth.features.friction = false;
    check(dem::Solver<3>(smooth, rough.grains()), 5e-6);
}

TEST_CASE("packed: ranges are all grains, and what reaches into them are the pairs of earlier ones")
{
    dem::Solver<3> solver = unit::tumbling(Rolling::constant, Scheme::predicted, false, false, 3);
    solver.steps(5e-6, 2000);
    auto const& pairs = solver.state().pairs;
    std::uint32_t next = 0;
    std::vector<std::uint32_t> reaches;
    for (dem::Range const& range : pairs.ranges) {
        CHECK(range.begin == next);
        CHECK(range.begin < range.end);
        CHECK(range.begin % dem::grains_booked == 0);
        next = range.end;
        for (std::uint32_t const slot : range.reaches) {
            CHECK(pairs.owner[slot] < range.begin);
            CHECK((pairs.other[slot] >= range.begin && pairs.other[slot] < range.end));
        }
        CHECK(std::ranges::is_sorted(range.reaches));
        reaches.insert(reaches.end(), range.reaches.begin(), range.reaches.end());
    }
    CHECK(next == solver.grains().size());
    auto const leaves = [&](std::uint32_t slot) {
        return std::ranges::any_of(pairs.ranges, [&](dem::Range const& range) {
            return pairs.owner[slot] < range.begin && pairs.other[slot] >= range.begin;
        });
    };
    std::size_t across = 0;
    for (std::uint32_t slot = 0; slot < pairs.other.size(); ++slot) across += leaves(slot);
    CHECK(across == reaches.size());
    CHECK(across > 20);
}
