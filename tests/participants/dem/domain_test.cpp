#include "participants/dem/domain.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/domain_runs.hpp"
#include "tests/participants/dem/domain_scenes.hpp"

//! Grains shared out among processes (threads here): the bits are those of one.
using unit::alone, unit::collapse, unit::own_ids, unit::shared, unit::without_sums;

namespace {

template <int D>
dem::Vec<D> momentum(dem::Grains<D> const& g)
{
    dem::Vec<D> sum{};
    for (std::size_t i = 0; i < g.size(); ++i) sum += g.mass[i] * g.motion[i].velocity;
    return sum;
}

}  // namespace

TEST_CASE("domain: a collapse of discs is the same to the last bit on 1, 2, 3 and 5 processes")
{
    int const steps = 8000;
    auto const start = collapse();
    auto const one = alone(start, steps, unit::step);
    REQUIRE(one.rebuilds > 20);
    for (int const processes : {1, 2, 3, 5}) {
        CAPTURE(processes);
        auto const many = shared(start, processes, steps, unit::step);
        CHECK(without_sums(many.whole) == without_sums(one));
        for (std::size_t w = 0; w < one.walls.size(); ++w)
            CHECK(norm(many.whole.walls[w].force - one.walls[w].force) <= 1e-13 * norm(one.walls[w].force));
        if (processes == 1) continue;
        CHECK(many.migrated > 0);
        CHECK(many.slab_moves > 0);
        for (auto const owned : many.owned) CHECK(std::abs(double(owned) - 144.0 / processes) < 0.25 * 144 / processes);
    }
}

TEST_CASE("domain: the ledger's sums are those of one process to rounding")
{
    int const steps = 8000;
    auto const start = collapse(true);
    auto const one = alone(start, steps, unit::step);
    auto const whole = shared(start, 3, steps, unit::step).whole;
    CHECK(without_sums(whole) == without_sums(one));
    auto const ours = dem::energies(start.setup(), whole), theirs = dem::energies(start.setup(), one);
    REQUIRE(theirs.sliding > 0.0);
    REQUIRE(theirs.wall_work != 0.0);
    REQUIRE(theirs.removed_walls > 0.0);
    double const scale = theirs.lost();
    for (auto const part : {&dem::Energies::normal_dashpot, &dem::Energies::tangential_dashpot, &dem::Energies::sliding,
                            &dem::Energies::removed_walls, &dem::Energies::touch, &dem::Energies::wall_work})
        CHECK(std::abs(ours.*part - theirs.*part) < 1e-12 * scale);
    CHECK(ours.kinetic() == theirs.kinetic());
    CHECK(ours.elastic() == theirs.elastic());
}

TEST_CASE("domain: tumbling spheres are the same to the last bit, with each law of rolling and order of a step")
{
    using dem::Rolling, dem::Scheme;
    int const steps = 3000;
    double const dt = 1e-5;
    for (Scheme const scheme : {Scheme::predicted, Scheme::liggghts})
        for (Rolling const rolling : {Rolling::none, Rolling::constant, Rolling::elastic_plastic}) {
            if (scheme == Scheme::liggghts && rolling == Rolling::elastic_plastic) continue;  // not compiled
            CAPTURE(static_cast<int>(scheme));
            CAPTURE(static_cast<int>(rolling));
            auto const start = unit::tumbling(rolling, scheme, false);
            auto const one = alone(start, steps, dt);
            REQUIRE(one.rebuilds > 20);
            for (int const processes : {2, 3}) {
                auto const many = shared(start, processes, steps, dt);
                CHECK(without_sums(many.whole) == without_sums(one));
                CHECK(many.migrated > 0);
            }
        }
}

TEST_CASE("domain: threads within processes, and a frame that is spun up, change no bit either")
{
    auto const start = unit::tumbling(dem::Rolling::constant, dem::Scheme::predicted, false);
    dem::Setup<3> setup = start.setup();
    setup.frame.emplace(sluice::Rotation{{0.01, 0.3, 0}, {0, 0.6, 0.8}, 20.0, 0.02, true, true, true});
    dem::Solver<3> const spun(setup, start.grains());
    setup.threads = 2;
    dem::Solver<3> const threaded(setup, start.grains());
    auto const one = without_sums(alone(spun, 3000, 1e-5));
    CHECK(without_sums(shared(spun, 2, 3000, 1e-5).whole) == one);
    CHECK(without_sums(shared(threaded, 2, 3000, 1e-5).whole) == one);
}

TEST_CASE("domain: sizes of a factor of 20, a large sphere crosses slabs thinner than itself")
{
    dem::Setup<3> s = unit::tumbling(dem::Rolling::none, dem::Scheme::predicted, false).setup();
    s.walls.resize(1);
    s.gravity = {};
    s.skin = 2e-4;
    dem::Random random(2);
    dem::Grains<3> g;
    for (int k = 0; k < 400; ++k) {
        double const at = 1.5e-3;
        g.add({(k % 20 + 2) * at, (k / 20 % 5 + 1) * at, (k / 100 + 1) * at}, random.uniform(5e-4, 6e-4), 2650.0);
    }
    dem::Motion<3> flying{};
    flying.velocity = {8.0, 0.0, 0.0};
    g.add({-0.012, 3e-3, 0.011}, 0.01, 2650.0, flying);
    dem::Solver<3> const start(s, g);
    auto const one = alone(start, 2500, 2e-6);
    REQUIRE(one.grains.place[400].centre.x > 0.02);
    CHECK(without_sums(shared(start, 5, 2500, 2e-6).whole) == without_sums(one));
}

TEST_CASE("domain: mass, number and momentum of a gas that crosses the borders stay, the energy as with one process")
{
    dem::Setup<2> s = unit::setup(0.5, {0.0, 0.0});
    dem::Solver<2> const start(s, unit::loose(14, 3, 1.0));
    double mass = 0.0, speed = 0.0;
    for (std::size_t i = 0; i < start.grains().size(); ++i) {
        mass += start.grains().mass[i];
        speed += start.grains().mass[i] * norm(start.grains().motion[i].velocity);
    }
    auto const many = shared(start, 3, 5000, unit::step);
    REQUIRE(many.migrated > 0);
    double mass_after = 0.0;
    std::set<std::int64_t> ids;
    for (std::size_t i = 0; i < many.whole.grains.size(); ++i) {
        mass_after += many.whole.grains.mass[i];
        ids.insert(many.whole.grains.id[i]);
    }
    CHECK(ids.size() == 196);
    CHECK(mass_after == mass);
    CHECK(norm(momentum(many.whole.grains) - momentum(start.grains())) < 1e-13 * speed);
    CHECK(dem::kinetic_energy(many.whole.grains) == dem::kinetic_energy(alone(start, 5000, unit::step).grains));
}

TEST_CASE("domain: a checkpoint of two processes goes on with one and with three, as if nobody had stopped")
{
    auto const start = collapse(true);
    auto const through = alone(start, 8000, unit::step);
    sluice::State of_first, of_other;
    unit::on_processes(2, [&](ranks::Peers& peers) {
        dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(start.setup(), {});
        solver.share_out(peers);
        for (int n = 0; n < 4123; ++n) solver.step(unit::step);
        (peers.rank() == 0 ? of_first : of_other) = unit::kept(solver.whole());
    });
    auto const state = dem::kept_state<2>(of_first, start.setup(), 144);
    CHECK(without_sums(state) == without_sums(alone(start, 4123, unit::step)));
    dem::Solver<2> one(start.setup(), {});
    one.restore(state);
    CHECK(without_sums(alone(one, 8000 - 4123, unit::step)) == without_sums(through));
    dem::State<2> three;
    unit::on_processes(3, [&](ranks::Peers& peers) {
        bool const root = peers.rank() == 0;
        dem::Solver<2> solver(start.setup(), {});
        solver.share_out(peers);
        solver.restore(dem::kept_state<2>(root ? of_first : of_other, start.setup(), root ? 144 : 0));
        for (int n = 4123; n < 8000; ++n) solver.step(unit::step);
        auto const whole = solver.whole();
        if (root) three = whole;
    });
    CHECK(without_sums(three) == without_sums(through));
    double const lost = dem::energies(start.setup(), through).balance();
    CHECK(std::abs(dem::energies(start.setup(), three).balance() - lost) < 1e-12 * std::abs(lost));
}

TEST_CASE("domain: the same processes give the same bits again, sums included")
{
    CHECK(unit::kept(shared(collapse(true), 3, 4000, unit::step).whole) ==
          unit::kept(shared(collapse(true), 3, 4000, unit::step).whole));
}

TEST_CASE("domain: processes without grains, and a run without any")
{
    dem::Setup<2> const s = unit::setup(0.5, {0.0, 0.0});
    dem::Grains<2> g;
    g.add({0.0, 0.0}, 1e-3, unit::density, {{1.0, 0.0}, 0.0});
    g.add({2.5e-3, 1e-4}, 1e-3, unit::density, {{-1.0, 0.0}, 3.0});
    dem::Solver<2> const start(s, g);
    auto const many = shared(start, 5, 3000, unit::step);
    CHECK(without_sums(many.whole) == without_sums(alone(start, 3000, unit::step)));
    CHECK(many.whole.grains.motion[0].velocity.x < 0.0);  // they met
    auto const none = shared(dem::Solver<2>(s, {}), 3, 10, unit::step).whole;
    CHECK(none.grains.size() == 0);
    CHECK(none.steps == 10);
}

TEST_CASE("domain: a disc flies through the slabs of four processes and pushes what rests there")
{
    dem::Setup<2> const s = unit::setup(0.5, {0.0, 0.0});
    dem::Grains<2> g;
    for (int k = 0; k < 40; ++k) g.add({k * 2.2e-3, 1.9e-3}, 1e-3, unit::density);
    g.add({-1e-2, 0.0}, 1e-3, unit::density, {{4.0, 0.0}, 0.0});
    dem::Solver<2> const start(s, g);
    std::vector<std::set<int>> owners(4);  // by process: whether it ever had the flyer
    dem::State<2> whole;
    unit::on_processes(4, [&](ranks::Peers& peers) {
        dem::Solver<2> solver = peers.rank() == 0 ? start : dem::Solver<2>(s, {});
        solver.share_out(peers);
        for (int n = 0; n < 15000; ++n) {
            solver.step(unit::step);
            if (n % 50 == 0 && own_ids(solver).contains(40)) owners[static_cast<std::size_t>(peers.rank())].insert(n);
        }
        auto const all = solver.whole();
        if (peers.rank() == 0) whole = all;
    });
    for (auto const& times : owners) CHECK(!times.empty());
    CHECK(without_sums(whole) == without_sums(alone(start, 15000, unit::step)));
}

TEST_CASE("domain: what ends a run of one process ends one of many, in the same words")
{
    dem::Setup<2> const s = unit::setup(0.5, {0.0, 0.0});
    dem::Grains<2> g;
    for (int k = 0; k < 8; ++k) g.add({k * 3e-3, 0.0}, 1e-3, unit::density);
    g.motion[6].velocity = {600.0, 0.0};
    dem::Solver<2> const fast(s, g);
    CHECK_THROWS_WITH_AS(shared(fast, 3, 1, unit::step), doctest::Contains("dem: grain 6 moves by more than"),
                         sluice::Error);
    dem::Setup<2> other = s;
    other.sleep = {.speed = 1e-5, .time = 1e-3};
    CHECK_THROWS_WITH_AS(shared(dem::Solver<2>(other, {}), 1, 1, unit::step),
                         doctest::Contains("that may sleep cannot be shared"), sluice::Error);
}

TEST_CASE("slabs: as many centres in each, across the longest axis, also where some lie in layers")
{
    for (int const processes : {1, 2, 3, 7}) {
        CAPTURE(processes);
        dem::Slabs<3> slabs, layered;
        unit::on_processes(processes, [&](ranks::Peers& peers) {
            std::vector<dem::Vec3> own;  // process p has every p-th of 10 000
            dem::Random random(1);
            for (int k = 0; k < 10000; ++k) {
                double const a = random.uniform(0, 1), b = random.uniform(0, 1);
                if (k % processes == peers.rank()) own.push_back({0.2 * a, b * b, 0.1});
            }
            auto const found = dem::even_slabs<3>(peers, own);
            for (auto& centre : own) centre.y = 0.3;
            auto const same = dem::even_slabs<3>(peers, own);
            if (peers.rank() == 0) slabs = found, layered = same;
        });
        CHECK(slabs.axis == (processes == 0 ? 0 : 1));
        CHECK(layered.axis == 0);
        REQUIRE(slabs.bounds.size() == static_cast<std::size_t>(processes - 1));
        for (int k = 1; k < processes;
             ++k)  // a part k/n of b^2 lies below (k/n)^2; sampling spreads by 0.5 %, thrice that
            CHECK(std::abs(std::sqrt(slabs.bounds[static_cast<std::size_t>(k - 1)]) - double(k) / processes) < 0.015);
    }
}

TEST_CASE("slabs: owner and neighbours of a point")
{
    dem::Slabs<2> const slabs{.axis = 1, .bounds = {1.0, 2.0, 2.0, 3.0}};  // slab 2 is empty
    CHECK(slabs.owner({9.0, -5.0}) == 0);
    CHECK(slabs.owner({9.0, 1.0}) == 1);
    CHECK(slabs.owner({9.0, 2.0}) == 3);
    CHECK(slabs.owner({9.0, 3.5}) == 4);
    CHECK(slabs.near({0.0, 1.5}, 0.4) == std::pair(1, 1));
    CHECK(slabs.near({0.0, 1.5}, 0.6) == std::pair(0, 3));
    CHECK(slabs.near({0.0, 1.5}, 9.0) == std::pair(0, 4));
}
