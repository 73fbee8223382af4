#include <doctest/doctest.h>

#include <cmath>

#include "participants/dem/domain.hpp"
#include "tests/participants/dem/domain_runs.hpp"
#include "tests/participants/dem/domain_scenes.hpp"
#include "tests/participants/dem/mesh_scenes.hpp"

//! Grains on meshes shared out among processes (threads here): the bits are those of one.
using unit::alone, unit::shared, unit::without_sums;

namespace {

//! Spheres that tumble over hills of triangles that move.
dem::Solver<3> over_hills(bool ledger)
{
    auto const tumbling = unit::tumbling(dem::Rolling::elastic_plastic, dem::Scheme::predicted, false, ledger);
    dem::Setup<3> setup = tumbling.setup();
    dem::Random random(4);
    setup.walls[0].shape =
        unit::mesh_of(unit::sheet(24, 0.08, {}, [&](double, double) { return random.uniform(-1e-3, 0.0); }));
    return {setup, tumbling.grains()};
}

//! Discs that fall on a floor of segments, up and down.
dem::Solver<2> on_segments()
{
    auto const falling = unit::box();
    dem::Setup<2> setup = falling.setup();
    std::vector<std::array<dem::Vec2, 2>> segments;
    for (int k = -4; k < 40; ++k)
        segments.push_back(
            {dem::Vec2{k * 7e-4, k % 2 == 0 ? 0.0 : -4e-4}, dem::Vec2{(k + 1) * 7e-4, k % 2 == 0 ? -4e-4 : 0.0}});
    setup.walls[0].shape = unit::mesh_of(segments);
    return {setup, falling.grains()};
}

}  // namespace

TEST_CASE("domain: grains on a mesh are the same to the last bit on 2, 3 and 5 processes")
{
    auto const check = [](auto const& start, int steps, double dt) {
        int pressed = 0;  // steps in which grains do so
        auto const one = alone(start, steps, dt,
                               [&](auto const& solver, int) { pressed += norm(solver.state().walls[0].force) > 0.0; });
        REQUIRE(one.rebuilds > 15);
        REQUIRE(pressed > steps / 10);
        for (int const processes : {2, 3, 5}) {
            CAPTURE(processes);
            auto const many = shared(start, processes, steps, dt);
            CHECK(without_sums(many.whole) == without_sums(one));
            CHECK(many.migrated > 0);
            auto const& force = one.walls[0].force;
            CHECK(norm(many.whole.walls[0].force - force) <= 1e-12 * norm(force));
        }
    };
    SUBCASE("spheres, triangles that move")
    {
        check(over_hills(false), 3000, 1e-5);
    }
    SUBCASE("discs, segments")
    {
        check(on_segments(), 8000, unit::step);
    }
}

TEST_CASE("domain: the ledger of grains on a mesh is that of one process to rounding")
{
    auto const start = over_hills(true);
    auto const one = alone(start, 2000, 1e-5), many = shared(start, 3, 2000, 1e-5).whole;
    CHECK(without_sums(many) == without_sums(one));
    auto const ours = dem::energies(start.setup(), many), theirs = dem::energies(start.setup(), one);
    REQUIRE(theirs.rolling > 0.0);
    for (auto const part : {&dem::Energies::normal_dashpot, &dem::Energies::sliding, &dem::Energies::rolling,
                            &dem::Energies::touch, &dem::Energies::wall_work})
        CHECK(std::abs(ours.*part - theirs.*part) < 1e-12 * theirs.lost());
    CHECK(ours.elastic() == theirs.elastic());
}
