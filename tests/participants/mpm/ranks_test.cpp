#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "participants/mpm/checkpoint.hpp"
#include "participants/mpm/setup.hpp"
#include "participants/mpm/solver.hpp"
#include "tests/participants/mpm/full_domain.hpp"
#include "tests/support/contains.hpp"
#include "tests/support/thread_peers.hpp"

//! Points that several processes share get the bits of one.
namespace {

constexpr double pi = std::numbers::pi;

mpm::Law soil()
{
    mpm::Elasticity const e{1e6, 0.3};
    return mpm::MohrCoulomb{e, mpm::MohrCoulombSurface(e, {.friction_angle = 0.4})};
}

//! A column behind a gate that goes at 2 ms, and a block that falls on it; thin in space.
template <int D>
mpm::Config collapse(double cell = D == 2 ? 0.005 : 0.025)
{
    mpm::Config c;
    c.dimension = D;
    c.density = 1900;
    c.law = soil();
    c.shared_volume = true;
    c.cell = cell;
    c.gravity[D - 1] = -9.81;
    c.size = D == 2 ? std::array{0.6, 0.3, 0.0} : std::array{1.0, 0.2, 0.6};
    double const width = D == 2 ? 0.15 : 0.2;
    c.bodies.push_back({.low = {0, 0, 0}, .high = {width, D == 2 ? 0.1 : 0.2, 0.2}});
    c.bodies.push_back({.low = {0.02, D == 2 ? 0.11 : 0.04, 0.24},
                        .high = {0.07, D == 2 ? 0.16 : 0.14, 0.34},
                        .velocity = {0.4, D == 2 ? -2.3 : 0.2, D == 2 ? 0 : -2.3}});
    int const up = D - 1;
    c.walls = {{.axis = 0, .side = -1},
               {.axis = up, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.4},
               {0, 1, width, mpm::WallKind::rough, 0.2, 0.002}};
    if (D == 3) c.walls.insert(c.walls.end(), {{.axis = 1, .side = -1}, {1, 1, 0.2, mpm::WallKind::rough, 0.3}});
    return c;
}

//! A domain full of matter that streams through joined sides.
template <int D>
mpm::Config streaming(unit::Joined const& joined, int cells)
{
    return unit::full<D>(soil(), joined, cells, mpm::WallKind::rough, 0.3);
}

//! A block, and a ball that flies away from it until points lie too far apart, and comes back.
mpm::Config ball_that_comes_back()
{
    auto c = collapse<2>(0.01);
    c.law = mpm::LinearElastic{{1e6, 0.3}};
    c.gravity = {};
    c.size = {2.14, 2.14, 0};
    c.walls = {{0, 1, 2.14}, {1, 1, 2.14}};
    c.bodies = {{.low = {0.2, 0.2, 0}, .high = {0.38, 0.38, 0}, .velocity = {0.5, 0.3, 0}},
                {.low = {2.08, 2.08, 0}, .high = {2.1, 2.1, 0}, .velocity = {30, 30, 0}}};
    return c;
}

struct Scene
{
    char const* what;
    mpm::Config config;
    bool loads = false, grains = false, streams = false;
    int steps = 36;  // beyond the second sort
};

template <int D>
mpm::State<D> start(Scene const& scene)
{
    auto state = mpm::make_state<D>(scene.config);
    if (!scene.streams) return state;
    for (mpm::Point<D>& p : state.points) {
        p.matter.stress = -3000 * mpm::Mat3::Identity();
        for (int a = 0; a < D; ++a) {
            bool const joined = scene.config.walls[2 * static_cast<std::size_t>(a)].kind == mpm::WallKind::joined;
            p.velocity[a] = 0.4 * std::sin(2 * pi * p.place[(a + 1) % D] / scene.config.size[0]) + (joined ? 9 : 0);
        }
    }
    return state;
}

template <int D>
std::vector<mpm::Vec<D>> loads_at(std::size_t points, std::int64_t step)
{
    std::vector<mpm::Vec<D>> loads;
    for (std::size_t p = 0; p < points; ++p)
        loads.push_back(mpm::Vec<D>::Constant(0.2 * std::sin(static_cast<double>(p) + static_cast<double>(step))));
    return loads;
}

//! Two that roll into the column from the side and from above, apart from the points at first.
template <int D>
std::vector<mpm::Grain<D>> grains_at(double time)
{
    std::vector<mpm::Grain<D>> grains(2);
    grains[0].id = 7, grains[1].id = 3;
    grains[0].radius = 0.05, grains[1].radius = 0.04;
    grains[0].place[0] = D == 2 ? 0.202 : 0.26, grains[1].place[0] = 0.11;
    grains[0].place[D - 1] = 0.06, grains[1].place[D - 1] = D == 2 ? 0.142 : 0.25;
    grains[0].velocity[0] = -2, grains[1].velocity[D - 1] = -2;
    if constexpr (D == 3) grains[0].place[1] = grains[1].place[1] = 0.1;
    for (auto& g : grains) g.spin[0] = 20, g.place += time * g.velocity;
    return grains;
}

//! Sizes of what comes from other processes.
class MeasuredPeers final : public ranks::Peers
{
 public:
    explicit MeasuredPeers(ranks::Peers& peers) : peers_(peers) {}

    int rank() const override { return peers_.rank(); }
    int count() const override { return peers_.count(); }
    std::vector<ranks::Bytes> all_to_all(std::vector<ranks::Bytes> out) override
    {
        auto in = peers_.all_to_all(std::move(out));
        for (std::size_t p = 0; p < in.size(); ++p)
            if (static_cast<int>(p) != rank()) came.push_back(in[p].size());
        return in;
    }
    void start(std::span<ranks::Parcel> parcels) override { peers_.start(parcels); }
    void finish() override { peers_.finish(); }
    std::vector<double> numbers(double mine) override { return peers_.numbers(mine); }

    std::vector<std::size_t> came;  //!< bytes

 private:
    ranks::Peers& peers_;
};

//! All that partners, tables and pictures see.
using Trace = std::vector<double>;

template <int D>
void look(mpm::Solver<D> const& solver, bool first, Trace& trace)
{
    auto const& state = solver.state();
    if (!first) return;
    auto const add = [&](auto const& numbers) { trace.insert(trace.end(), numbers.begin(), numbers.end()); };
    auto const e = solver.energies();
    auto const& b = e.booked;
    add(std::array{e.kinetic, e.potential, e.elastic, b.plastic, b.sliding, b.damping, b.numerical, b.external_work,
                   b.field_work, solver.longest_step(), double(solver.nodes()), double(solver.light_nodes())});
    for (auto const& push : solver.grains().pushes()) add(push.impulse), add(push.angular);
    for (auto const& impulse : solver.grains().plate_impulses()) add(impulse);
    add(state.order);
    for (mpm::Point<D> const& p : state.points) {
        add(p.place), add(p.velocity), add(p.slope.reshaped()), add(p.matter.stress.reshaped());
        add(p.matter.gradient.reshaped());
        add(std::array{double(p.id), p.mass, p.volume, p.matter.ratio, p.matter.plastic_strain, p.matter.gap});
    }
}

template <int D>
void run(mpm::Solver<D>& solver, Scene const& scene, std::int64_t to, bool first, Trace& trace)
{
    for (std::int64_t k = solver.state().steps; k < to; ++k) {
        if (scene.loads) solver.set_loads(loads_at<D>(solver.count(), k));
        if (scene.grains) solver.set_grains(grains_at<D>(solver.time()));
        solver.step(0.9 * solver.longest_step());
        if (k % 23 == 0) look(solver, first, trace);
    }
    look(solver, first, trace);
}

template <int D>
mpm::Solver<D> solver_of(Scene const& scene, ranks::Peers* peers)
{
    mpm::Solver<D> solver(mpm::make_setup<D>(scene.config), start<D>(scene), peers);
    solver.set_friction(0.3);
    return solver;
}

template <int D>
Trace alone(Scene const& scene)
{
    Trace trace;
    auto solver = solver_of<D>(scene, nullptr);
    run(solver, scene, scene.steps / 2, true, trace);
    sluice::State kept;
    mpm::keep(solver, kept);
    mpm::restore(solver, kept);
    run(solver, scene, scene.steps, true, trace);
    for (auto const& push : solver.grains().pushes()) CHECK(push.impulse.norm() > 0);
    for (auto const& impulse : solver.grains().plate_impulses()) CHECK(impulse.norm() > 0);
    return trace;
}

//! The first process's trace. Halfway each goes on by some steps, goes back, and hands over to another solver.
template <int D>
Trace shared(Scene const& scene, int processes)
{
    return unit::of_first<Trace>(processes, [&](ranks::Peers& peers, Trace& mine) {
        bool const first = peers.rank() == 0;
        Trace dropped;
        sluice::State kept;
        {
            auto solver = solver_of<D>(scene, &peers);
            run(solver, scene, scene.steps / 2, first, mine);
            mpm::keep(solver, kept);
            run(solver, scene, scene.steps / 2 + 5, first, dropped);
            mpm::restore(solver, kept);
            sluice::State again;
            mpm::keep(solver, again);
            CHECK(again == kept);
        }
        auto solver = solver_of<D>(scene, &peers);
        mpm::restore(solver, kept);
        run(solver, scene, scene.steps, first, mine);
    });
}

template <int D>
void check(std::vector<Scene> const& scenes, std::vector<int> const& processes)
{
    unit::check_bits_of_one(scenes, processes, alone<D>, shared<D>);
}

}  // namespace

TEST_CASE("ranks: points in the plane that processes share get the bits of one")
{
    check<2>({{"collapse", collapse<2>(0.004), false, false, false, 70}}, {2, 5});
    auto usl = collapse<2>();
    usl.scheme = mpm::Scheme::usl, usl.affine = false, usl.flip = 0.95, usl.damping = 3;
    auto spline = collapse<2>();
    spline.basis = mpm::BasisKind::spline, spline.shared_volume = false;
    spline.law = mpm::LinearElastic{{1e6, 0.3}};
    auto turning = collapse<2>();
    turning.rotation = sluice::Rotation{{0.1, 2, 0}, {0, 0, 1}, 8, 0.003, true, true, true};
    check<2>({{"usl, damped", usl},
              {"loads", collapse<2>(), true},
              {"splines, elastic", spline},
              {"frame that starts to turn", turning}},
             {3});
}

TEST_CASE("ranks: so they do across joined sides, and as rings")
{
    using Joined = std::array<bool, 3>;
    for (Joined const& joined : {Joined{true}, Joined{true, true}})
        check<2>({{"joined sides", streaming<2>(joined, 30), !joined[1], false, true}}, {3});
    auto rings = streaming<2>({false, true}, 30);
    rings.symmetry = mpm::Symmetry::axial;
    check<2>({{"rings", rings, false, false, true}}, {3});
    check<3>({{"joined sides", streaming<3>({false, true, true}, 8), true, false, true}}, {4});
}

TEST_CASE("ranks: so they do in space")
{
    auto usl = collapse<3>();
    usl.scheme = mpm::Scheme::usl, usl.damping = 3;
    check<3>({{"collapse", collapse<3>()}, {"usl, loads", usl, true}}, {3});
}

TEST_CASE("ranks: so they do with grains and plates")
{
    auto tilted = collapse<2>();
    mpm::Plate<3> plate{.point = {0.152, 0, 0}, .normal = mpm::Vec3(-1, 0.3, 0).normalized(), .friction = 0.3};
    plate.motion.velocity = {-2, 0, 0};
    tilted.plates.push_back(plate);
    check<2>({{"grains and a plate", tilted, true, true}}, {3});
    auto coarse = collapse<2>();  // half a point's width is half a cell: faces lie on nodes, to rounding
    coarse.points = 1;
    coarse.bodies = {{.high = {0.15, 0.1, 0}}, {.low = {0, 0.1, 0}, .high = {0.06, 0.29, 0}}};
    coarse.walls.pop_back();
    coarse.plates = {{.point = {0.1505, 0, 0}, .normal = {-1, 0, 0}, .friction = 0.3}};
    coarse.plates[0].motion.velocity = {-1, 0, 0};
    check<2>({{"one point a cell", coarse, false, true}}, {2});
    check<3>({{"spheres", collapse<3>(), false, true}}, {3});
}

TEST_CASE("ranks: points that stream come to lie in chunks of others")
{
    Scene const scene{"streams", streaming<2>({true, false}, 30), false, false, true};
    auto const holders = [](mpm::State<2> const& state) {
        std::vector<std::size_t> chunk(state.points.size());
        for (std::size_t k = 0; k < chunk.size(); ++k)
            chunk[static_cast<std::size_t>(state.order[k])] = k / mpm::Shares::chunk;
        return chunk;
    };
    auto solver = solver_of<2>(scene, nullptr);
    solver.step(solver.longest_step());
    auto const before = holders(solver.state());
    while (solver.state().steps < 33) solver.step(solver.longest_step());
    auto const after = holders(solver.state());
    std::size_t moved = 0;
    for (std::size_t p = 0; p < before.size(); ++p) moved += before[p] != after[p];
    CHECK(moved > 100);
}

TEST_CASE("ranks: points far from each other, which go one at a time, get the bits of one process")
{
    auto far = collapse<2>();
    far.size = {4, 4, 0};
    far.bodies[0].high = {0.08, 0.08, 0};
    far.walls.clear();
    far.bodies[1] = {.low = {3.6, 3.6, 0}, .high = {3.65, 3.65, 0}, .velocity = {-0.1, 0.3, 0}};
    check<2>({{"far apart", far, false, false, false, 4}}, {2});
}

TEST_CASE("ranks: who looks at points changes nothing, in turns of both ways of a step")
{
    Scene const scene{"ball", ball_that_comes_back()};
    auto const go = [&](ranks::Peers* peers, std::int64_t looked_at, int steps) {
        Trace trace;
        auto solver = solver_of<2>(scene, peers);
        for (int k = 0; k < steps; ++k) {
            solver.step(0.5 * solver.longest_step());
            if (k % 32 == looked_at) solver.state();
        }
        look(solver, !peers || peers->rank() == 0, trace);
        return trace;
    };
    auto const check_two = [&](std::int64_t looked_at, int steps, Trace const& one) {
        unit::on_processes(2, [&](ranks::Peers& peers) {
            Trace const mine = go(&peers, looked_at, steps);
            CHECK((peers.rank() > 0 || mine == one));
        });
    };
    Trace const apart = go(nullptr, -1, 40);  // one at a time from step 32 on, which sorts
    CHECK(go(nullptr, 31, 40) == apart);
    check_two(-1, 40, apart);
    check_two(31, 40, apart);
    check_two(31, 300, go(nullptr, -1, 300));  // four at a time again
}

TEST_CASE("ranks: no points travel to a process that goes back to a checkpoint, but those in it")
{
    Scene const scene{"collapse", collapse<2>()};
    unit::on_processes(2, [&](ranks::Peers& peers) {
        MeasuredPeers measured(peers);
        auto solver = solver_of<2>(scene, &measured);
        sluice::State kept;
        mpm::keep(solver, kept);
        solver.step(solver.longest_step());
        measured.came.clear();
        mpm::restore(solver, kept);
        for (std::size_t const bytes : measured.came) CHECK((peers.rank() > 0 || bytes == 0));
    });
}

TEST_CASE("ranks: what the first process has much of reaches all, in pieces")
{
    for (std::size_t const size : {0, 1, 300, 301, 1000})
        unit::on_processes(3, [&](ranks::Peers& peers) {
            ranks::Bytes bytes;
            for (std::size_t k = 0; k < size; ++k) bytes.push_back(static_cast<std::byte>(k));
            MeasuredPeers measured(peers);
            CHECK(ranks::much_from_first(measured, peers.rank() == 0 ? bytes : ranks::Bytes{}, 300) == bytes);
            for (std::size_t const came : measured.came) CHECK(came <= 300);
        });
}

TEST_CASE("ranks: what goes wrong in one process ends all, with the words of one")
{
    auto const said = [](Scene const& scene, int processes, int steps) {
        std::vector<std::string> said(static_cast<std::size_t>(processes));
        auto const go = [&](ranks::Peers* peers) {
            try {
                auto solver = solver_of<2>(scene, processes > 1 ? peers : nullptr);
                if (scene.streams) solver.points().back().matter.ratio = -1;
                for (int k = 0; k < steps; ++k) {
                    if (scene.grains) solver.set_grains(grains_at<2>(0.03));
                    solver.step(solver.longest_step());
                }
            } catch (sluice::Error const& e) {
                said[static_cast<std::size_t>(peers->rank())] = e.what();
            }
        };
        unit::on_processes(processes, [&](ranks::Peers& peers) { go(&peers); });
        for (auto const& text : said) CHECK(text == said[0]);
        return said[0];
    };
    auto open = collapse<2>();
    open.walls.clear();
    open.bodies[0].velocity = {0, -1, 0};
    Scene const escape{"a point leaves", open}, inside{"a grain", collapse<2>(), false, true};
    Scene const flat{"J < 0", streaming<2>({true, false}, 30), false, false, true};
    for (auto const& [scene, reason] :
         {std::pair{escape, "has left the domain"}, {inside, "cells inside grain"}, {flat, "J = "}}) {
        auto const one = said(scene, 1, 70);
        CHECK_MESSAGE(contains(one, reason), one);
        CHECK(said(scene, 3, 70) == one);
    }
}

TEST_CASE("ranks: what processes cannot share is refused")
{
    auto const refused = [](mpm::Config const& c, int processes) {
        std::string text;
        try {
            unit::on_processes(processes, [&](ranks::Peers& peers) { mpm::make_solver<2>(c, &peers); });
        } catch (sluice::Error const& e) {
            text = e.what();
        }
        return text;
    };
    auto c = collapse<2>(0.004);
    CHECK(refused(c, 5).empty());
    CHECK(contains(refused(c, 6), "6 processes for 4375 points"));
    c.basis = mpm::BasisKind::cpdi;
    CHECK(contains(refused(c, 2), "2 processes with what goes one point at a time"));
}
