#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/base/error.hpp"
#include "participants/dem/random.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/mesh_scenes.hpp"
#include "tests/support/close_to.hpp"

//! Spheres in a silo of two meshes: what they weigh, and what is kept of their contacts.
using namespace unit;

namespace {

//! A tube of 12 sides from z = 0 to its height, its floor, and loose spheres in it.
dem::Solver<3> silo(bool ledger, int threads = 1)
{
    double const pi = std::numbers::pi, radius = 0.014, height = 0.12;
    Triangles tube, base;
    auto const at = [&](int k, double z) {
        return Vec3{radius * std::cos(2.0 * pi * k / 12), radius * std::sin(2.0 * pi * k / 12), z};
    };
    for (int k = 0; k < 12; ++k) {
        add_quad(tube, at(k, 0.0), at(k + 1, 0.0), at(k + 1, height), at(k, height));
        base.push_back({Vec3{}, at(k, 0.0), at(k + 1, 0.0)});
    }
    dem::Setup<3> s = sphere_setup(sphere_contact(0.4, dem::Rolling::elastic_plastic));
    s.features.ledger = ledger;
    s.threads = threads;
    add_wall(s, mesh_of(tube), "tube");
    add_wall(s, mesh_of(base), "base");
    dem::Random random(2);
    dem::Grains<3> g;
    for (int k = 0; k < 45; ++k) {
        double const angle = 2.0 * pi * (k % 3) / 3.0 + 0.3 * (k / 3);
        g.add({0.007 * std::cos(angle), 0.007 * std::sin(angle), 0.006 + 0.0105 * (k / 3)},
              random.uniform(0.0035, 0.005), density);
    }
    return {s, g};
}

}  // namespace

TEST_CASE("mesh: the walls of a settled silo bear its weight, and the ledger of its filling closes")
{
    dem::Solver<3> solver = silo(true);
    double weight = 0.0;
    for (double const mass : solver.grains().mass) weight += 9.81 * mass;
    double const start = solver.energies().balance(), potential = solver.energies().potential;
    for (int n = 0; n < 30000; ++n) solver.step(sphere_step);
    CHECK(std::abs(solver.energies().balance() - start) < 1e-4 * potential);
    settle(solver, 16000, 0.02);  // exp(-0.02 x 2700/s x 0.24 s) is 2e-6
    Vec3 const on_walls = solver.state().walls[0].force + solver.state().walls[1].force;
    CHECK(on_walls.z == close_to(weight).epsilon(1e-3));
    CHECK(std::hypot(on_walls.x, on_walls.y) < 1e-3 * weight);
    CHECK(solver.state().walls[0].force.z > 0.0);  // friction: the tube bears a part
}

TEST_CASE("mesh: a restored run continues bit for bit, and the number of threads changes no bit")
{
    for (bool const ledger : {false, true}) {
        dem::Solver<3> a = silo(ledger);
        for (int n = 0; n < 4000; ++n) a.step(sphere_step);
        auto const bytes = kept(a).encode();
        for (int n = 0; n < 4000; ++n) a.step(sphere_step);
        dem::Solver<3> b(a.setup(), {});
        b.restore(dem::kept_state<3>(sluice::State::decode(bytes, "state"), b.setup(), 45));
        for (int n = 0; n < 4000; ++n) b.step(sphere_step);
        CHECK(kept(a) == kept(b));
    }
    dem::Solver<3> one = silo(false), two = silo(false, 2);
    for (int n = 0; n < 6000; ++n) one.step(sphere_step), two.step(sphere_step);
    CHECK(kept(one) == kept(two));
}

TEST_CASE("mesh: a longer neighbour list and the ledger change no bit")
{
    dem::Solver<3> a = silo(false), booked = silo(true);
    dem::Setup<3> wide = a.setup();
    wide.skin *= 2.5;
    dem::Solver<3> far(wide, a.grains());
    for (int n = 0; n < 6000; ++n) a.step(sphere_step), booked.step(sphere_step), far.step(sphere_step);
    CHECK(a.state().rebuilds > far.state().rebuilds);
    for (std::size_t i = 0; i < a.grains().size(); ++i) {
        CHECK(a.grains().place[i].centre == far.grains().place[i].centre);
        CHECK(a.grains().place[i].centre == booked.grains().place[i].centre);
    }
}

TEST_CASE("mesh: a checkpoint whose facets are not those of the mesh is refused")
{
    dem::Solver<3> solver = silo(false);
    auto const good = kept(solver);
    dem::Setup<3> fewer = solver.setup();
    fewer.walls[0].shape = mesh_of(flat(1, 0.1));
    CHECK_NOTHROW(dem::kept_state<3>(good, solver.setup(), 45));
    CHECK_THROWS_AS(dem::kept_state<3>(good, fewer, 45), sluice::Error);
    fewer.walls[0].shape = dem::Plane<3>{{}, {0, 0, 1}};
    CHECK_THROWS_AS(dem::kept_state<3>(good, fewer, 45), sluice::Error);
}

TEST_CASE("mesh: a packing's records bring the friction back to its facet")
{
    dem::Solver<3> a = silo(false);
    for (int n = 0; n < 6000; ++n) a.step(sphere_step);
    auto const records = dem::records_of(a.state());
    dem::State<3> state = a.state();
    for (auto* history : {&state.pairs.history, &state.walls[0].history, &state.walls[1].history}) {
        std::fill(history->friction.begin(), history->friction.end(), Vec3{});
        std::fill(history->rolling.begin(), history->rolling.end(), Vec3{});
    }
    CHECK(dem::records_of(state).empty());
    dem::set_records<3>(state, records);
    CHECK(dem::records_of(state) == records);
    CHECK(std::any_of(records.begin(), records.end(), [](auto const& r) { return r.second >= 45 + 2; }));
}
