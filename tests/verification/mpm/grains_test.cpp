#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "participants/mpm/setup.hpp"
#include "tests/support/verification.hpp"
#include "tests/verification/mpm/bars.hpp"

//! M11 to M14: rigid discs on the continuum. A disc moves as the discrete elements move it: velocity Verlet under the
//! mean load of a step; the continuum sees it extrapolated by the load of the step before (kinematics with lag 1, load
//! with lag 0).
namespace {

using verification::report;
using verification::Stopwatch;

constexpr double pi = std::numbers::pi;

struct Disc
{
    mpm::Grain<2> now{};
    double mass = 0;
    mpm::Vec<2> pull = mpm::Vec<2>::Zero();  //!< m/s2
    mpm::Push<2> last{};                     //!< over the step: N, N m

    double inertia() const { return 0.5 * mass * now.radius * now.radius; }
    double kinetic() const
    {
        return 0.5 * mass * now.velocity.squaredNorm() + 0.5 * inertia() * now.spin.squaredNorm();
    }
};

void step(mpm::Solver<2>& solver, Disc& disc, double dt)
{
    mpm::Vec<2> const was = disc.pull + disc.last.impulse / disc.mass;
    mpm::Grain<2> seen = disc.now;
    seen.velocity += dt * was;
    seen.spin += dt * disc.last.angular / disc.inertia();
    seen.place += dt * (disc.now.velocity + 0.5 * dt * was) - 0.5 * dt * seen.velocity;
    solver.set_grains({seen});
    solver.step(dt);
    disc.last = solver.grains().pushes()[0];
    disc.last.impulse /= dt;
    disc.last.angular /= dt;
    mpm::Vec<2> const is = disc.pull + disc.last.impulse / disc.mass;
    disc.now.place += dt * (disc.now.velocity + 0.5 * dt * is);
    disc.now.velocity += dt * is;
    disc.now.spin += dt * disc.last.angular / disc.inertia();
}

//! A block from (low, 0) to (high, height), rollers below.
mpm::Config block(double cell, double low, double high, double height, double width, double room)
{
    mpm::Config c;
    c.cell = cell;
    c.size = {width, height + room, 0};
    c.density = 1000;
    c.flip = 1;
    c.law = mpm::LinearElastic{{1e6, 0.3}};
    c.bodies.push_back({.low = {low, 0, 0}, .high = {high, height, 0}});
    c.walls.push_back({.axis = 1, .side = -1});
    return c;
}

//! Half of a block, the axis on the left wall, under a disc that is lowered by `depth` and held. Returns force [N/m],
//! the disc's way less that of the points at `below` under the surface [m], the closed form of that.
struct Pressed
{
    double force, approach, closed, width;
};
Pressed press(double cell, double radius, double depth, double below)
{
    double const size = 1, modulus = 1e6, nu = 0.3;
    auto c = block(cell, 0, size, size, size + 2 * cell, 4 * cell);
    c.damping = 60;
    c.walls.push_back({.axis = 0, .side = -1});
    auto solver = mpm::make_solver<2>(c);
    mpm::Grain<2> disc{.place = {0, size + radius}, .radius = radius};
    std::vector<std::size_t> marked;
    double start = 0;
    for (std::size_t p = 0; p < solver.state().points.size(); ++p) {
        auto const& at = solver.state().points[p].place;
        if (at[0] < 0.5 * cell && std::abs(at[1] - (size - below)) < 0.5 * cell) marked.push_back(p);
    }
    auto const height = [&] {
        double sum = 0;
        for (auto p : marked) sum += solver.state().points[p].place[1];
        return sum / static_cast<double>(marked.size());
    };
    start = height();
    double const lowering = 0.05, all = 0.25;  // s
    double force = 0, mean_from = 0.2, steps = 0;
    while (solver.time() < all) {
        double const dt = solver.longest_step();
        disc.velocity = {0, solver.time() < lowering ? -depth / lowering : 0};
        solver.set_grains({disc});
        solver.step(dt);
        disc.place += dt * disc.velocity;
        if (solver.time() < mean_from) continue;
        force += 2 * solver.grains().pushes()[0].impulse[1] / dt;
        ++steps;
    }
    force /= steps;
    double const plane = modulus / (1 - nu * nu), half = std::sqrt(4 * force * radius / (pi * plane));
    double const went = size + radius - disc.place[1];
    return {force, went - (start - height()),
            force / (pi * plane) *
                (2 * std::log(2 * below / half) - nu / (1 - nu) + 2 * std::log(2 * size / (2 * size - below))),
            half};
}

}  // namespace

TEST_CASE("M11: a disc pressed on an elastic block, by the force it takes")
{
    // Johnson, Contact Mechanics (1985), eq. 5.57 with 4.45: a = sqrt(4 P R / (pi E*)), and what lies between the
    // surface and a depth d >> a is compressed by P / (pi E*) (2 ln(2 d / a) - nu / (1 - nu)). A smooth rigid base at
    // the depth t is the plane of symmetry to a second load, whose stress on the axis is 2 P / (pi (2 t - z)) (ibid.,
    // eq. 2.22): 2 ln(2 t / (2 t - d)) more. Left out, of the order (d / t)^2 / 3 of that: the sides, 2 %.
    for (double const cell : {0.04, 0.02}) {
        Stopwatch watch;
        auto const p = press(cell, 1, 0.02, 0.24);
        auto const name = verification::named("compression, cells of %g m, a = %.2f cells", cell, p.width / cell);
        CHECK(report({"M11", name, p.approach, p.closed, std::abs(p.approach / p.closed - 1), 0.02, watch.seconds()}));
    }
}

TEST_CASE("M11: a disc comes to rest on an elastic block: the block bears its weight")
{
    for (double const cell : {0.05, 0.025}) {
        Stopwatch watch;
        auto c = block(cell, 0, 0.8, 0.4, 0.8, 0.4);
        c.damping = 30;
        for (int side : {-1, 1}) c.walls.push_back({.axis = 0, .side = side, .place = side < 0 ? 0 : 0.8});
        auto solver = mpm::make_solver<2>(c);
        solver.set_friction(0.3);
        Disc disc{.mass = 20};
        disc.now.radius = 0.1;
        disc.now.place = {0.4, 0.501};
        double borne = 0, since = 0;
        while (solver.time() < 2) {
            double const dt = solver.longest_step();
            disc.pull = mpm::Vec<2>(0, -9.81) - 60 * disc.now.velocity;
            step(solver, disc, dt);
            if (solver.time() < 1.8) continue;
            borne += dt * disc.last.impulse[1];
            since += dt;
        }
        double const weight = 9.81 * disc.mass, error = std::abs(borne / since / weight - 1);
        // at rest to what damping leaves: exp(-60 t / 2) of the impact
        CHECK(report({"M11", verification::named("force of a disc at rest, cells of %g m", cell), borne / since, weight,
                      error, 1e-4, watch.seconds()}));
        CHECK(std::abs(disc.now.velocity[1]) < 1e-4);
    }
}

TEST_CASE("M12: a block slides on a disc so large that it is an incline")
{
    // as M05: a = g (sin - mu cos), 2 %; gravity is that of an incline of 30 degrees, which it is turned by. Between
    // grid lines, wherever. Where tan 30 degrees < mu it stays:
    // less than 1 mm in 0.5 s; damped, or else it creeps as it shakes, on a wall of the grid as well.
    for (double const mu : {0.3, 0.7})
        for (double const cell : {0.05, 0.025}) {
            Stopwatch watch;
            double const angle = pi / 6, g = 9.81, radius = 1e4, base = 1.3 * cell;
            mpm::Config c = block(cell, 0.4, 1.2, 0.2, 3.2, 0.2);
            c.origin = {0, -2 * cell, 0};
            c.size[1] += 2 * cell;
            for (double* edge : {&c.bodies[0].low[1], &c.bodies[0].high[1]}) *edge += cell;
            c.walls.clear();
            c.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
            c.damping = mu > std::tan(angle) ? 50 : 0;
            c.geostatic = mpm::GeostaticConfig{.surface = 0.2 + cell, .k0 = 0};
            auto solver = mpm::make_solver<2>(c);
            for (auto& p : solver.points()) p.place[1] += 0.3 * cell;
            solver.set_friction(mu);
            std::vector<mpm::Grain<2>> const incline{{.place = {1.6, base - radius}, .radius = radius}};
            auto const x = [&] { return verification::mean(solver.state(), [](auto const& p) { return p.place[0]; }); };
            auto const speed = [&] {
                return verification::mean(solver.state(), [](auto const& p) { return p.velocity[0]; });
            };
            auto const until = [&](double end) {
                while (solver.time() < end) {
                    solver.set_grains(incline);
                    solver.step(solver.longest_step());
                }
            };
            double const start = x();
            until(0.5);
            double const gained = speed() / solver.time();
            double const closed = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
            auto const name = verification::named("mu = %g, cells of %g m: ", mu, cell);
            if (mu < std::tan(angle))
                CHECK(report({"M12", name + "acceleration", gained, closed, std::abs(gained / closed - 1), 0.02,
                              watch.seconds()}));
            else
                CHECK(report({"M12", name + "way", x() - start, 0, std::abs(x() - start), 1e-3, watch.seconds()}));
        }
}

TEST_CASE("M13: a disc laid on a moving block slips, then rolls")
{
    // Coulomb: M dv/dt = mu M g, I dw/dt = mu M g R, m_b dv_b/dt = -mu M g: rolls from v_b0 / (mu g (3 + M / m_b)) on,
    // then at v = mu g t. Mark of M05; for the speed, which a contact of less than a cell (a = 0.0107 m) raises by the
    // slope of its points: less by half with half the cell.
    double off[2];
    int k = 0;
    for (double const cell : {0.025, 0.0125}) {
        Stopwatch watch;
        double const mu = 0.2, g = 9.81, speed = 1;
        auto c = block(cell, 0.2, 1.8, 0.2, 4, 0.6);
        c.law = mpm::LinearElastic{{2e5, 0.3}};
        auto solver = mpm::make_solver<2>(c);
        Disc disc{.mass = 20};
        disc.now.radius = 0.1;
        disc.now.place = {1.2, 0.3};
        for (double const settled = 0.5; solver.time() < settled;) {  // without friction
            disc.pull = {0, -g - 60 * disc.now.velocity[1]};
            step(solver, disc, solver.longest_step());
        }
        disc.pull = {0, -g};
        solver.set_friction(mu);
        for (auto& p : solver.points()) p.velocity[0] += speed;
        double const laid = solver.time();
        double const heavy = 0.32 * 1000, rolls = speed / (mu * g * (3 + disc.mass / heavy));
        auto const slip = [&] {
            return verification::mean(solver.state(), [](auto const& p) { return p.velocity[0]; }) -
                   disc.now.velocity[0] - disc.now.spin[0] * disc.now.radius;
        };
        while (solver.time() - laid < 0.8 * rolls) step(solver, disc, solver.longest_step());
        double const t = solver.time() - laid;
        auto const now = [&](char const* what, double got, double closed, double scale) {
            CHECK(report({"M13", std::string(what) + verification::named(", cells of %g m", cell), got, closed,
                          std::abs(got - closed) / scale, 0.02, watch.seconds()}));
        };
        off[k++] = std::abs(disc.now.velocity[0] / (mu * g * t) - 1);
        now("slips: speed of its rim", disc.now.spin[0] * disc.now.radius, 2 * mu * g * t, 2 * mu * g * t);
        while (solver.time() - laid < 1.1 * rolls) step(solver, disc, solver.longest_step());
        now("rolls: slip, by the speed of the block", slip(), 0, speed);
    }
    CHECK(report({"M13", "slips: error of its speed with 8 cells, by that with 4", off[1] / off[0], 0.5,
                  off[1] / off[0], 0.5, 0}));
    CHECK(report({"M13", "slips: error of its speed with 8 cells", off[1], 0, off[1], 0.05, 0}));
}

TEST_CASE("M14: a disc hits a free block: momentum, energy")
{
    double rebound[3];
    int k = 0;
    for (double const cell : {0.05, 0.025, 0.0125}) {
        Stopwatch watch;
        auto c = block(cell, 0.2, 1, 0.4, 1.2, 0.6);
        c.origin = {0, -0.2, 0};
        c.size[1] = 1.2;
        c.walls.clear();
        auto solver = mpm::make_solver<2>(c);
        solver.set_friction(0.4);
        Disc disc{.mass = 40};
        disc.now.radius = 0.1;
        disc.now.place = {0.52, 0.502};
        disc.now.velocity = {0.2, -0.5};
        double const energy = disc.kinetic();
        mpm::Vec<2> const before = disc.mass * disc.now.velocity;
        double most = 0;
        while (solver.time() < 0.12) {
            step(solver, disc, solver.longest_step());
            auto const e = solver.energies();
            most = std::max(most, disc.kinetic() + e.kinetic + e.elastic);
        }
        mpm::Vec<2> after = disc.mass * disc.now.velocity;
        for (auto const& p : solver.state().points) after += p.mass * p.velocity;
        rebound[k++] = disc.now.velocity[1];
        CHECK(disc.last.impulse.norm() == 0);  // it has left
        // sums of some 1e4 products a step
        double const lost = (after - before).norm() / before.norm();
        CHECK(report(
            {"M14", verification::named("momentum, cells of %g m", cell), lost, 0, lost, 1e-12, watch.seconds()}));
        // gained: as M07, 1 %
        CHECK(report({"M14", verification::named("largest energy, cells of %g m", cell), most, energy,
                      std::max(0.0, most / energy - 1), 0.01, watch.seconds()}));
    }
    std::printf("      rebound %.5f %.5f %.5f m/s\n", rebound[0], rebound[1], rebound[2]);
    // first order at least
    double const change = std::abs(rebound[2] - rebound[1]), coarse = std::abs(rebound[1] - rebound[0]);
    CHECK(report({"M14", "speed of rebound, change from 16 to 32 cells by that from 8 to 16", change / coarse, 0.5,
                  change / coarse, 0.6, 0}));
}
