#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/kept_populations.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Fluid in a frame that turns. Lattice units.
namespace {

template <int D>
lbm::Config config(std::array<double, 3> const& size)
{
    auto c = unit_config<D>(size, 0.05);
    for (std::size_t k = 0; k < D; ++k) c.set_periodic(k);
    return c;
}

struct Kind
{
    lbm::Operator collision;
    double smagorinsky;
};
constexpr std::array<Kind, 6> kinds = {{{lbm::Operator::bgk, 0},
                                        {lbm::Operator::trt, 0},
                                        {lbm::Operator::mrt, 0},
                                        {lbm::Operator::mrt, 0.1},
                                        {lbm::Operator::central, 0},
                                        {lbm::Operator::central, 0.1}}};

//! Some bodies at rest, so that both kernels run.
template <int D>
void put_bodies(lbm::Solver<D>& solver, double x)
{
    std::vector<double> position(D, 9.3), rest(D, 0.0), spin(lbm::spins<D>, 0.0), radius{3.1};
    position[0] = x;
    solver.set_bodies({position, rest, spin, radius});
}

template <int D>
double largest_difference(lbm::Solver<D>& a, lbm::Solver<D>& b)
{
    auto const one = populations_of(a), other = populations_of(b);
    double worst = 0;
    for (std::size_t k = 0; k < one.size(); ++k) worst = std::max(worst, std::abs(one[k] - other[k]));
    return worst;
}

template <int D>
void check_that_a_frame_at_rest_changes_nothing()
{
    for (Kind const& kind : kinds) {
        auto c = config<D>({24, 18, D == 3 ? 18.0 : 0.0});
        c.collision = kind.collision;
        c.smagorinsky = kind.smagorinsky;
        c.acceleration = {1e-5, -2e-5, D == 3 ? 1.5e-5 : 0.0};
        lbm::Solver<D> still(c);
        c.rotation = sluice::Rotation{.point = {3, 4, 5}, .rate = 0};
        c.hydrostatic = true;
        lbm::Solver<D> framed(c);
        for (int k = 0; k < 40; ++k)
            for (auto* solver : {&still, &framed}) {
                put_bodies(*solver, 12.1);
                solver->step();
            }
        CHECK(largest_difference(still, framed) < 1e-14);
        for (std::size_t k = 0; k < D; ++k) CHECK(std::abs(still.loads().force[k] - framed.loads().force[k]) < 1e-12);
    }
}

}  // namespace

TEST_CASE("frame: one that turns at no rate changes nothing, in the plane and in space, in every operator, with bodies")
{
    check_that_a_frame_at_rest_changes_nothing<2>();
    check_that_a_frame_at_rest_changes_nothing<3>();
}

TEST_CASE("frame: Coriolis' force alone turns a uniform flow by twice the frame's angle and keeps its speed")
{
    // R11; the half force makes each step a rotation: to rounding, in every operator
    double const rate = 0.01;
    for (Kind const& kind : kinds) {
        auto c = config<2>({8, 8});
        c.collision = kind.collision;
        c.smagorinsky = kind.smagorinsky;
        c.rotation = sluice::Rotation{.rate = rate};
        lbm::Solver<2> solver(c);
        solver.set_state([](auto const&) {
            return lbm::PointState<2>{.velocity = {0.05, 0}, .pressure = 0, .gradient = {}};
        });
        for (int k = 0; k < 100; ++k) solver.step();
        lbm::Fields const f = solver.fields();
        CHECK(std::abs(f.velocity[0] - 0.05 * std::cos(2 * rate * 100)) < 1e-13);
        CHECK(std::abs(f.velocity[1] + 0.05 * std::sin(2 * rate * 100)) < 1e-13);

        auto d = config<3>({8, 6, 6});
        d.collision = kind.collision;
        d.smagorinsky = kind.smagorinsky;
        d.rotation = sluice::Rotation{.direction = {0, 0.6, 0.8}, .rate = rate};
        lbm::Solver<3> space(d);
        space.set_state([](auto const&) {
            return lbm::PointState<3>{.velocity = {0.05, 0.03, 0.04}, .pressure = 0, .gradient = {}};
        });
        for (int k = 0; k < 100; ++k) space.step();
        lbm::Fields const g = space.fields();
        // along the axis 0.05 of it stays; across x turns toward n x e_x = (0, 0.8, -0.6), by the negative angle
        double const a = 2 * rate * 100;
        CHECK(std::abs(g.velocity[0] - 0.05 * std::cos(a)) < 1e-13);
        CHECK(std::abs(g.velocity[1] - (0.03 - 0.05 * 0.8 * std::sin(a))) < 1e-13);
        CHECK(std::abs(g.velocity[2] - (0.04 + 0.05 * 0.6 * std::sin(a))) < 1e-13);
    }
}

TEST_CASE("frame: a free disc of the fluid's density goes round with it")
{
    // both turn by 2 w dt a step; staggered, the disc is a step late: within one and a half,
    // once the jerk of its appearance (whose dU is not known) is over
    // its start
    double const rate = 0.01, speed = 0.05, radius = 5.2, mass = 3.14159265358979 * radius * radius;
    auto c = config<2>({32, 32});
    c.collision = lbm::Operator::trt;
    c.rotation = sluice::Rotation{.rate = rate};
    lbm::Solver<2> solver(c);
    solver.set_state([&](auto const&) {
        return lbm::PointState<2>{.velocity = {speed, 0}, .pressure = 0, .gradient = {}};
    });
    std::vector<double> position{16.2, 15.7}, velocity{speed, 0.0}, spin{0.0};
    std::vector<double> const radii{radius};
    double const turn_x = std::cos(2 * rate), turn_y = -std::sin(2 * rate);
    int const steps = 500;
    for (int k = 0; k < steps; ++k) {
        for (std::size_t i = 0; i < 2; ++i) position[i] += 0.5 * velocity[i];
        velocity = {turn_x * velocity[0] - turn_y * velocity[1], turn_y * velocity[0] + turn_x * velocity[1]};
        for (std::size_t i = 0; i < 2; ++i) position[i] += 0.5 * velocity[i];
        solver.set_bodies({position, velocity, spin, radii});
        solver.step();
        for (std::size_t i = 0; i < 2; ++i) velocity[i] += solver.loads().force[i] / mass;
        spin[0] += solver.loads().torque[0] / (0.5 * mass * radius * radius);
        double const angle = 2 * rate * (k + 1);
        if (k < 50) continue;
        CHECK(std::hypot(velocity[0] - speed * std::cos(angle), velocity[1] + speed * std::sin(angle)) <
              3 * rate * speed);
    }
    CHECK(std::abs(spin[0] * radius) < 3 * rate * speed);
}

TEST_CASE("frame: the centrifugal field with gravity on the lattice: at rest, with its pressure, and buoyancy")
{
    // rotation about (0, -200), a = w^2 r; a closed box; p = rho w^2 r^2/2 to the square of what it compresses
    auto c = config<2>({20, 30});
    for (std::size_t k = 0; k < 2; ++k) c.set_periodic(k, false);
    double const rate = 5e-4;
    c.rotation = sluice::Rotation{.point = {10, -200, 0}, .rate = rate};
    c.hydrostatic = true;
    auto const head = [&](double x, double y) {
        double const dx = x - 10, dy = y + 200;
        return 0.5 * rate * rate * (dx * dx + dy * dy - 215 * 215);
    };
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        return lbm::PointState<2>{.velocity = {}, .pressure = head(at[0], at[1]), .gradient = {}};
    });
    for (int k = 0; k < 6000; ++k) {
        put_bodies(solver, 9.7);
        solver.step();
    }
    lbm::Fields const f = solver.fields();
    auto const pressure = [&](std::size_t x, std::size_t y) { return f.pressure[y * 20 + x]; };
    double const drop = head(10.5, 29.5) - head(10.5, 0.5);
    CHECK(drop > 1e-3);
    CHECK(std::abs((pressure(10, 29) - pressure(10, 0)) / drop - 1) < 0.01);
    CHECK(std::abs(((pressure(0, 20) - pressure(10, 20)) - (head(0.5, 20.5) - head(10.5, 20.5))) / drop) < 1e-4);
    CHECK(solver.max_speed() < 1e-6);
    // buoyancy: the fluid's weight at the disc's centre, upward here: toward the axis
    double const mass = 3.14159265358979 * 3.1 * 3.1, weight = mass * rate * rate * (9.3 + 200);
    CHECK(std::abs(solver.loads().force[1] / -weight - 1) < 0.01);
}

TEST_CASE("frame: one that is brought to its rate pushes the fluid round, and a run that was kept goes on bit for bit")
{
    auto c = config<3>({10, 10, 6});
    for (std::size_t k = 0; k < 2; ++k) c.set_periodic(k, false);
    c.rotation = sluice::Rotation{.point = {5, 5, 0}, .rate = 1e-3, .ramp = 200, .coriolis = false};
    lbm::Solver<3> whole(c);
    for (int k = 0; k < 60; ++k) whole.step();
    sluice::State kept;
    whole.keep(kept);
    for (int k = 0; k < 60; ++k) whole.step();
    lbm::Solver<3> resumed(c);
    resumed.restore(kept);
    for (int k = 0; k < 60; ++k) resumed.step();
    CHECK(populations_of(whole) == populations_of(resumed));
    // Euler's force is against the turn: left of the axis (x < 5) the fluid goes up, right of it down
    lbm::Fields const f = whole.fields();
    auto const up = [&](std::size_t x) { return f.velocity[3 * (5 * 10 + x) + 1]; };
    CHECK(up(2) > 1e-6);
    CHECK(up(7) < -1e-6);
}
