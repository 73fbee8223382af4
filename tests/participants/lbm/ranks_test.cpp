#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/lbm/slab_cost.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/bent_channel.hpp"
#include "tests/participants/lbm/unit_config.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"
#include "tests/support/thread_peers.hpp"

//! A lattice that several processes share gives the bits of one. Lattice units.
namespace {

template <int D>
lbm::Config config(std::array<double, 3> const& size)
{
    auto c = unit_config<D>(size, 0.02);
    c.acceleration = {1e-6, -2e-6, D == 3 ? 3e-6 : 0.0};
    return c;
}

lbm::Solid ball(std::array<double, 3> const& centre, double radius)
{
    lbm::Solid solid;
    solid.name = "ball";
    solid.centre = centre;
    solid.radius = radius;
    return solid;
}

//! Bodies that move across the lattice, in all directions, some across its sides; from step 5 to 24 there is one
//! more, which comes first.
template <int D>
struct Bodies
{
    std::vector<double> position, velocity, spin, radius;
    std::vector<std::uint64_t> id;

    Bodies(lbm::Config const& c, double size, int step)
    {
        constexpr std::size_t most = 4;
        for (std::size_t i = step < 5 || step > 24 ? 1 : 0; i < most; ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                double const v = 0.03 * std::cos(1.7 * static_cast<double>(i) + 2.1 * static_cast<double>(k));
                double const start = c.size[k] * (0.04 + 0.3 * static_cast<double>(i));
                position.push_back(start + v * step);
                velocity.push_back(v);
            }
            for (std::size_t k = 0; k < lbm::spins<D>; ++k) spin.push_back(0.002 * static_cast<double>(i + k));
            radius.push_back(size * (1.6 + 0.4 * static_cast<double>(i)));
            id.push_back(7 * (most - i));
        }
    }
    lbm::BodiesView view() const { return {position, velocity, spin, radius, id}; }
};

//! Points of a bed that sinks through the lattice, in its middle and across its lowest side.
template <int D>
struct Points
{
    std::vector<double> position, velocity, volume;
    std::vector<std::int64_t> id;

    Points(lbm::Config const& c, int step)
    {
        constexpr int most = 300;
        double const pi = 3.14159;
        for (int i = step < 10 ? 3 : 0; i < most; ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                double const share = std::fmod(0.1 + 0.618034 * i * (1 + 0.3 * static_cast<double>(k)), 1.0);
                double const v = k == D - 1 ? -0.03 : 0.01 * std::sin(pi * share);
                position.push_back(c.size[k] * (k == D - 1 ? 0.6 * share : share) + v * step);
                velocity.push_back(v);
            }
            volume.push_back(0.3 + 0.1 * std::sin(i));
            id.push_back(1000 - i);
        }
    }
};

//! All that partners and pictures see of a run: loads of every step, and now and then measures and pictures.
using Trace = std::vector<double>;

template <int D>
void look(lbm::Solver<D>& solver, bool first, Trace& trace)
{
    auto const add = [&](auto const& numbers) { trace.insert(trace.end(), numbers.begin(), numbers.end()); };
    add(std::array{solver.mass(), solver.max_speed()});
    add(solver.momentum());
    auto const energies = solver.energies();
    add(std::array{energies.kinetic, energies.enstrophy});
    std::vector<std::array<double, D>> places;
    for (int k = 0; k < 20; ++k) {
        std::array<double, D> place;
        for (std::size_t axis = 0; axis < D; ++axis) place[axis] = solver.config().size[axis] * k / 19.0;
        places.push_back(place);
    }
    for (auto const& sample : solver.samples(places)) {
        add(sample.velocity);
        add(std::array{sample.pressure, sample.solid_fraction});
    }
    for (int const coarsen : {1, 3}) {
        auto const fields = solver.fields(coarsen, {.q_criterion = true});
        if (!first) continue;
        for (auto const& values :
             {fields.velocity, fields.pressure, fields.vorticity, fields.solid_fraction, fields.q_criterion})
            add(values);
    }
}

constexpr int steps = 30, middle = 15, window = 5;

struct Scene
{
    std::string what;
    lbm::Config config;
    double bodies = 1;  //!< their size; 0: there are none
};

template <int D>
void run(lbm::Solver<D>& solver, Scene const& scene, int from, int to, bool first, Trace& trace)
{
    auto const add = [&](std::span<double const> numbers) {
        trace.insert(trace.end(), numbers.begin(), numbers.end());
    };
    for (int k = from; k < to; ++k) {
        if (scene.bodies > 0) {
            Bodies<D> const bodies(scene.config, scene.bodies, k);
            solver.set_bodies(bodies.view());
        }
        if (scene.config.phase && k % window == 0) {
            Points<D> const points(scene.config, k);
            solver.set_phase({points.id, points.position, points.velocity, points.volume}, window);
        }
        solver.step();
        if (scene.config.phase && k % window == window - 1) add(solver.phase_force());
        add(solver.loads().force);
        add(solver.loads().torque);
        add(solver.solid_loads().force);
        add(solver.solid_loads().torque);
        add(solver.taken_along());
        if (k % 9 == 4) look(solver, first, trace);
    }
}

template <int D>
void set_flow(lbm::Solver<D>& solver)
{
    solver.set_state([](std::array<double, D> const& at) {
        lbm::PointState<D> state;
        for (std::size_t k = 0; k < D; ++k) state.velocity[k] = 0.02 * std::sin(0.3 * at[(k + 1) % D] + 0.7);
        state.pressure = 1e-3 * std::cos(0.2 * at[0] + 0.4 * at[1]);
        return state;
    });
}

template <int D>
Trace alone(Scene const& scene)
{
    Trace trace;
    lbm::Solver<D> solver(scene.config);
    set_flow(solver);
    run(solver, scene, 0, steps, true, trace);
    return trace;
}

//! The first process's trace. Halfway each process goes back by some steps, with populations under way, and then hands
//! over to another solver.
template <int D>
Trace shared(Scene const& scene, int processes)
{
    return unit::of_first<Trace>(processes, [&](ranks::Peers& peers, Trace& mine) {
        bool const first = peers.rank() == 0;
        Trace dropped;
        sluice::State kept, later;
        std::vector<double> extra;
        if (scene.bodies > 0 && processes != 3) {  // three: even slabs
            Bodies<D> const bodies(scene.config, scene.bodies, 0);
            extra = lbm::cost_of_bodies<D>(scene.config, bodies.view());
        }
        {
            lbm::Solver<D> solver(scene.config, &peers, extra);
            set_flow(solver);
            run(solver, scene, 0, middle, first, mine);
            solver.keep(kept);
            run(solver, scene, middle, middle + window, first, dropped);
            solver.restore(kept);
            run(solver, scene, middle, middle + window, first, mine);
            solver.keep(later);
        }
        lbm::Solver<D> solver(scene.config, &peers, lbm::extra_of(later));
        solver.restore(later);
        run(solver, scene, middle + window, steps, first, mine);
    });
}

std::vector<Scene> plane_scenes()
{
    std::vector<Scene> scenes;
    auto box = config<2>({30, 24, 0});
    box.walls[lbm::upper_y].velocity = {0.05, 0, 0};
    scenes.push_back({"closed box under a lid", box});
    auto periodic = config<2>({30, 24, 0});
    for (std::size_t k = 0; k < 2; ++k) periodic.set_periodic(k);
    periodic.precision = lbm::Precision::float32;
    scenes.push_back({"periodic, in floats", periodic});
    periodic.surface = lbm::Surface::forced;
    scenes.push_back({"the same, forced", periodic});
    periodic.surface = lbm::Surface::interpolated;
    periodic.lightest_grain = 0.2;
    scenes.push_back({"the same, interpolated and light", periodic});
    box.surface = lbm::Surface::interpolated;
    scenes.push_back({"closed box, interpolated, in a crowd", box, 2.4});
    auto channel = config<2>({40, 22, 0});
    channel.walls[lbm::left] = {.kind = lbm::Border::inflow, .velocity = {0.05, 0, 0}, .parabola = true};
    channel.walls[lbm::right] = {.kind = lbm::Border::pressure, .absorbing = true};
    channel.solids = {ball({15, 9, 0}, 4)};
    scenes.push_back({"channel", channel});
    channel.surface = lbm::Surface::interpolated;
    scenes.push_back({"channel, interpolated", channel});
    auto shaft = config<2>({20, 30, 0});
    shaft.walls[lbm::left].kind = lbm::Border::slip;
    shaft.walls[lbm::lower_y] = {.kind = lbm::Border::inflow, .velocity = {0, 0.05, 0}};
    shaft.walls[lbm::upper_y] = {.kind = lbm::Border::pressure, .absorbing = true};
    scenes.push_back({"shaft with a side without friction", shaft});
    auto bent = config<2>({160, 120, 0});
    bent.solids = bent_channel_solids();
    scenes.push_back({"bent channel in deep solid", bent});
    auto turning = config<2>({26, 24, 0});
    turning.rotation = sluice::Rotation{.point = {3, 40, 0}, .rate = 1e-3};
    turning.hydrostatic = true;
    turning.smagorinsky = 0.1;
    scenes.push_back({"in a frame that turns", turning});
    for (bool const matter : {true, false}) {
        auto bed = config<2>({24, 26, 0});
        if (!matter) bed.set_periodic(1);
        bed.phase =
            lbm::PhaseConfig{.diameter = 0.3, .solid_density = 2.65, .spread = matter ? 2 : 1, .matter = matter};
        scenes.push_back({matter ? "bed of matter" : "bed of grains, periodic", bed});
    }
    return scenes;
}

std::vector<Scene> scenes_in_space()
{
    std::vector<Scene> scenes;
    auto periodic = config<3>({14, 12, 16});
    for (std::size_t k = 0; k < 3; ++k) periodic.set_periodic(k);
    periodic.collision = lbm::Operator::trt;
    scenes.push_back({"periodic", periodic});
    periodic.surface = lbm::Surface::forced;
    scenes.push_back({"the same, forced", periodic});
    periodic.surface = lbm::Surface::interpolated;
    scenes.push_back({"the same, interpolated, in a crowd", periodic, 1.6});
    periodic.set_periodic(2, false);
    periodic.precision = lbm::Precision::float32;
    periodic.lightest_grain = 0.2;
    scenes.push_back({"between walls, in floats, interpolated and light", periodic});
    auto duct = config<3>({12, 14, 18});
    duct.walls[lbm::lower_z] = {.kind = lbm::Border::inflow, .velocity = {0, 0, 0.04}, .parabola = true};
    duct.walls[lbm::upper_z] = {.kind = lbm::Border::pressure};
    duct.walls[lbm::lower_y].kind = lbm::Border::slip;
    duct.solids = {ball({5, 6, 9}, 3)};
    duct.precision = lbm::Precision::float32;
    scenes.push_back({"duct", duct});
    auto basin = config<3>({26, 24, 30});
    basin.solids = {block({0, 0, 0}, {26, 24, 14.5}), block({12, 0, 14}, {26, 24, 30})};
    scenes.push_back({"basin in deep solid", basin});
    auto bed = config<3>({10, 8, 18});
    bed.phase = lbm::PhaseConfig{.law = lbm::Drag::di_felice, .diameter = 0.3, .solid_density = 2.65};
    bed.precision = lbm::Precision::float32;
    scenes.push_back({"bed", bed, 0});
    return scenes;
}

template <int D>
void check(std::vector<Scene> const& scenes, std::vector<int> const& processes)
{
    unit::check_bits_of_one(scenes, processes, alone<D>, shared<D>);
}

}  // namespace

TEST_CASE("ranks: a lattice in the plane that processes share gives the bits of one")
{
    check<2>(plane_scenes(), {1, 2, 3, 20});
}

TEST_CASE("ranks: a lattice in space that processes share gives the bits of one")
{
    check<3>(scenes_in_space(), {1, 2, 3, 7});
}

TEST_CASE("ranks: slabs weigh layers by what bodies in them cost")
{
    auto c = config<2>({20, 40, 0});
    std::vector<double> const position{10, 6, 10, 14}, none(4), spin(2), radius{4, 4};
    lbm::BodiesView const bodies{position, none, spin, radius, {}};
    auto const cost = lbm::cost_of_bodies<2>(c, bodies);
    REQUIRE(cost.size() == 40);
    auto const sum = [&](std::size_t begin, std::size_t end) {
        return std::accumulate(cost.begin() + static_cast<std::ptrdiff_t>(begin),
                               cost.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    };
    CHECK(sum(2, 10) == close_to(sum(10, 18)).epsilon(1e-12));
    CHECK(sum(0, 2) + sum(18, 40) == 0);
    // discs of 50 cells cost several times as much as so many of fluid; chords at half cells: an area within 5 %
    CHECK(sum(0, 40) > 2 * 50 * 2 * 0.95);
    lbm::Layout const whole(c.cells());
    lbm::Slabs const plain(whole, 1, 2, {}), weighed(whole, 1, 2, cost);
    CHECK(plain.begin(1) == 20);
    auto const work = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        return 20.0 * static_cast<double>(end - begin) +
               sum(static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
    };
    double const largest = *std::max_element(cost.begin(), cost.end()) + 20;
    CHECK(std::abs(work(0, weighed.begin(1)) - work(weighed.begin(1), 40)) <= largest);
    c.set_periodic(1);
    std::vector<double> const at_side{10, 0.5}, one_spin(1), one_radius{4};
    auto const across = lbm::cost_of_bodies<2>(c, {at_side, std::span(none).first(2), one_spin, one_radius, {}});
    CHECK(across[39] == close_to(across[1]).epsilon(1e-12));
    CHECK(across[39] > 0);
}

TEST_CASE("ranks: a state of a lattice that was shared out otherwise is refused")
{
    unit::on_processes(2, [](ranks::Peers& peers) {
        auto const c = config<2>({9, 12, 0});
        sluice::State kept;
        lbm::Solver<2> plain(c, &peers);
        lbm::Solver<2>(c, &peers, std::vector<double>(12, 1.0)).keep(kept);
        CHECK_THROWS_WITH_AS(plain.restore(kept), doctest::Contains("shared out otherwise"), sluice::Error);
        CHECK_THROWS_WITH_AS(lbm::Solver<2>(c, &peers, std::vector<double>(11)),
                             doctest::Contains("the cost of 11 layers of cells for a lattice of 12"), sluice::Error);
    });
}

TEST_CASE("ranks: what processes cannot share is refused")
{
    auto const refused = [](lbm::Config const& c, int processes) {
        std::string text;
        try {
            unit::on_processes(processes, [&](ranks::Peers& peers) { lbm::Solver<2> const solver(c, &peers); });
        } catch (sluice::Error const& e) {
            text = e.what();
        }
        return text;
    };
    auto c = config<2>({9, 6, 0});
    CHECK(refused(c, 6).empty());
    CHECK(contains(refused(c, 7), "7 processes for a lattice of 6 layers of cells along y"));
}
