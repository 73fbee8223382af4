#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "participants/dem/random.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/dem/setup.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/dem/scenes.hpp"

//! C08 (3): invariants of the solver alone; marks of the benchmark file C08_conservation.csv.
namespace {

using namespace scenes;

//! Discs of 1 to 1.8 mm on a jittered grid of `side` x `side` cells of 2.5 mm, velocities uniform in +-1 m/s.
dem::Grains<2> gas(int side, std::uint64_t seed)
{
    dem::Random random(seed);
    dem::Grains<2> g;
    double const cell = 2.5e-3;
    for (int i = 0; i < side * side; ++i) {
        double const radius = random.uniform(0.5e-3, 0.9e-3);
        double const x = (i % side) * cell + random.uniform(radius, cell - radius);
        double const y = (i / side) * cell + random.uniform(radius, cell - radius);
        double const vx = random.uniform(-1.0, 1.0), vy = random.uniform(-1.0, 1.0);
        g.add({x, y}, radius, 2650.0, {{vx, vy}, random.uniform(-1000.0, 1000.0)});
    }
    return g;
}

double const lightest_contact = dem::contact_time(1e6, 0.0, 0.5 * 2650.0 * std::numbers::pi * 0.5e-3 * 0.5e-3);

struct Momentum
{
    double x = 0.0, y = 0.0, angular = 0.0, scale = 0.0, angular_scale = 0.0;
};
Momentum momentum(dem::Grains<2> const& g)
{
    Momentum p;
    for (std::size_t i = 0; i < g.size(); ++i) {
        p.x += g.mass[i] * g.motion[i].velocity.x;
        p.y += g.mass[i] * g.motion[i].velocity.y;
        double const orbital = g.mass[i] * (g.place[i].centre.x * g.motion[i].velocity.y -
                                            g.place[i].centre.y * g.motion[i].velocity.x),
                     own = g.inertia[i] * g.motion[i].spin;
        p.angular += orbital + own;
        p.angular_scale += std::abs(orbital) + std::abs(own);
        p.scale += g.mass[i] * std::hypot(g.motion[i].velocity.x, g.motion[i].velocity.y);
    }
    return p;
}

//! Energy error of a frictionless, undamped gas of 14 x 14 + 4 = 200 discs in a box: at the end, and the largest.
struct Drift
{
    double end = 0.0, largest = 0.0;
};
Drift gas_drift(double steps_per_contact, int steps)
{
    dem::Setup<2> s = setup<2>({}, {}, 0.3e-3);
    double const width = 14 * 2.5e-3, height = width + 2.5e-3;
    add_wall(s, {0.0, 0.0}, {1.0, 0.0});
    add_wall(s, {0.0, 0.0}, {0.0, 1.0});
    add_wall(s, {width, 0.0}, {-1.0, 0.0});
    add_wall(s, {0.0, height}, {0.0, -1.0});
    dem::Grains<2> g = gas(14, 7);
    for (int k = 0; k < 4; ++k) g.add({(k + 0.5) * 2.5e-3, width + 1.25e-3}, 0.7e-3, 2650.0, {{0.5, -0.5}, 0.0});
    dem::Solver<2> solver(s, g);
    double const start = solver.energies().held();
    Drift d;
    for (int n = 1; n <= steps; ++n) {
        solver.step(lightest_contact / steps_per_contact);
        if (n % 100 == 0) d.largest = std::max(d.largest, std::abs(solver.energies().held() / start - 1.0));
    }
    d.end = std::abs(solver.energies().held() / start - 1.0);
    return d;
}

}  // namespace

TEST_CASE("C08: contacts with friction and damping keep momentum and angular momentum")
{
    verification::Stopwatch watch;
    dem::Setup<2> const s = setup<2>({.damping_ratio = 0.2, .tangential_damping = 0.2, .friction = 0.5}, {}, 0.3e-3);
    dem::Solver<2> solver(s, gas(10, 3));
    Momentum const before = momentum(solver.grains());
    for (int n = 0; n < 20000; ++n) solver.step(lightest_contact / 50.0);
    Momentum const after = momentum(solver.grains());
    double const linear = std::hypot(after.x - before.x, after.y - before.y) / before.scale;
    double const angular = std::abs(after.angular - before.angular) / before.angular_scale;
    CHECK(verification::report(
        {"C08", "momentum of 100 discs, 20000 steps", linear, 0.0, linear, 1e-13, watch.seconds()}));
    CHECK(verification::report(
        {"C08", "angular momentum of 100 discs, 20000 steps", angular, 0.0, angular, 1e-12, watch.seconds()}));
}

TEST_CASE("C08: an undamped, frictionless gas keeps its energy")
{
    verification::Stopwatch watch;
    Drift const d = gas_drift(50.0, 100000);
    CHECK(verification::report(
        {"C08", "energy of 200 discs after 1e5 steps, t_c/50", 1.0 + d.end, 1.0, d.end, 1e-3, watch.seconds()}));
    verification::Stopwatch slope_watch;
    double const coarse = gas_drift(25.0, 20000).largest, fine = gas_drift(100.0, 80000).largest;
    double const order = std::log(coarse / fine) / std::log(4.0);
    std::printf("C08   largest energy error in equal times: t_c/25 %.3e, t_c/100 %.3e\n", coarse, fine);
    CHECK(verification::report({"C08", "order of the energy error in dt (>= 1.7)", order, 2.0,
                                std::max(0.0, 2.0 - order), 0.3, slope_watch.seconds()}));
}

TEST_CASE("C08: the energy ledger of a damped, frictional collapse closes")
{
    verification::Stopwatch watch;
    dem::Config const config = column(300, 1.0);
    dem::Solver<2> solver = dem::make_solver<2>(config, dem::pour_packing<2>(config), dem::Ledger::on);
    dem::Energies const start = solver.energies();
    double worst = 0.0;
    while (solver.time() < 0.3) {
        for (int n = 0; n < 500; ++n) solver.step(config.step);
        worst = std::max(worst, std::abs(solver.energies().balance() / start.balance() - 1.0));
    }
    dem::Energies const e = solver.energies();
    std::printf(
        "C08   J: potential %.4e -> %.4e, kinetic %.1e, dashpots %.3e + %.3e, sliding %.3e, gate %.1e, touch %.1e\n",
        start.potential, e.potential, e.kinetic(), e.normal_dashpot, e.tangential_dashpot, e.sliding, e.removed_walls,
        e.touch);
    // benchmark: 1e-4; the tighter mark guards the bookkeeping
    CHECK(verification::report(
        {"C08", "ledger of a collapse, largest gap / initial energy", worst, 0.0, worst, 1e-6, watch.seconds()}));
    double const touch = std::abs(e.touch) / start.balance();
    CHECK(verification::report(
        {"C08", "of it booked as touch / initial energy", touch, 0.0, touch, 2e-4, watch.seconds()}));
}

TEST_CASE("C08: the energy ledger of a collapse of spheres with rolling resistance closes")
{
    std::string const text =
        "density: 2650\ndiameter: {min: 7.2e-3, max: 8.8e-3}\ncontact: {normal_stiffness: 1e5, damping_ratio: 0.08, "
        "friction: 0.3, rolling_friction: 0.05}\nwalls:\n  - {name: floor, point: [0, 0, 0], normal: [0, 0, 1]}\n"
        "  - {name: x, point: [0, 0, 0], normal: [1, 0, 0]}\n  - {name: y, point: [0, 0, 0], normal: [0, 1, 0]}\n"
        "column: {container: quarter, count: 100, aspect_ratio: 0.9}\n";
    auto const config = dem::read_config(sluice::read_yaml(text, "spheres.yaml"), 3, {0.0, 0.0, -9.81});
    auto const packing = dem::pour_packing<3>(config);
    // benchmark: 1e-4; the tighter marks guard the bookkeeping. The gap falls with the square of the step
    for (auto const& [step, name, mark] :
         {std::tuple{config.step, "t_c/50", 4e-6}, {0.5 * config.step, "t_c/100", 1e-6}}) {
        verification::Stopwatch watch;
        auto solver = dem::make_solver<3>(config, packing, dem::Ledger::on);
        double const start = solver.energies().balance();
        double worst = 0.0;
        while (solver.time() < 0.25) {
            for (int n = 0; n < 200; ++n) solver.step(step);
            worst = std::max(worst, std::abs(solver.energies().balance() / start - 1.0));
        }
        double const end = std::abs(solver.energies().balance() / start - 1.0);
        CHECK(solver.energies().rolling > 0.01 * start);
        CHECK(verification::report(
            {"C08", std::string("ledger of a collapse of spheres, ") + name + ", largest gap / initial energy", worst,
             0.0, worst, mark, watch.seconds()}));
        CHECK(verification::report(
            {"C08", std::string("the same at the end, ") + name, end, 0.0, end, 1e-6, watch.seconds()}));
    }
}
