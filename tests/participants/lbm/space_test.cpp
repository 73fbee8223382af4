#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "participants/lbm/solver.hpp"
#include "participants/lbm/sphere_volume.hpp"
#include "tests/participants/lbm/distance.hpp"
#include "tests/participants/lbm/kept_populations.hpp"
#include "tests/participants/lbm/plain_space.hpp"
#include "tests/participants/lbm/unit_config.hpp"
#include "tests/support/close_to.hpp"

//! D3Q19 with spheres.
namespace {

constexpr double pi = std::numbers::pi;

struct Scene
{
    char const* name;
    lbm::Operator collision;
    double smagorinsky, force;
    std::array<bool, 3> periodic;
    bool spheres;
};

lbm::Config config(Scene const& s)
{
    lbm::Config c;
    c.dimension = 3;
    c.cell = c.step = c.density = 1;
    c.size = {21, 17, 14};
    c.viscosity = 0.02;
    c.collision = s.collision;
    c.smagorinsky = s.smagorinsky;
    c.acceleration = {s.force, -0.5 * s.force, 0.25 * s.force};
    for (std::size_t k = 0; k < 3; ++k) c.set_periodic(k, s.periodic[k]);
    if (!s.periodic[2]) c.walls[lbm::upper_z].velocity = {0.04, 0.02, 0};
    if (!s.periodic[1]) c.walls[lbm::lower_y].velocity = {0.02, 0, -0.01};
    if (!s.periodic[0]) c.walls[lbm::right].velocity = {0, -0.02, 0.01};
    c.threads = 2;
    return c;
}

//! Three spheres; two overlap, one turns about all axes and has a core; across the sides where these are periodic.
std::vector<lbm::Body<3>> spheres_at(int step, bool periodic)
{
    double const t = step;
    double const x = periodic ? 20.3 : 16.0, z = periodic ? 0.4 : 5.2;
    return {{{6.3 + 0.02 * t, 8.1 - 0.01 * t, 6.7}, 3.4, {0.02, -0.01, 0}, {0.002, -0.001, 0.003}},
            {{11.2 + 0.02 * t, 8.9, 7.1 + 0.01 * t}, 2.6, {0.02, 0, 0.01}, {0, 0.004, 0}},
            {{x, 11.8, z}, 2.2, {0, 0, 0}, {0.01, 0, 0}}};
}

//! Spheres as arrays.
struct Arrays
{
    std::vector<double> position, velocity, spin, radius;

    explicit Arrays(std::vector<lbm::Body<3>> const& spheres)
    {
        for (auto const& s : spheres) {
            position.insert(position.end(), s.centre.begin(), s.centre.end());
            velocity.insert(velocity.end(), s.velocity.begin(), s.velocity.end());
            spin.insert(spin.end(), s.spin.begin(), s.spin.end());
            radius.push_back(s.radius);
        }
    }
    lbm::BodiesView view() const { return {position, velocity, spin, radius}; }
};

//! Largest differences after 60 steps.
Distance from_plain(Scene const& scene, lbm::Precision precision)
{
    lbm::Config c = config(scene);
    c.precision = precision;
    lbm::Solver<3> fast(c);
    PlainSpace plain(c);
    sluice::Team team(1);
    lbm::Layout const layout(c.cells());
    lbm::Domain<3> const domain(layout, nullptr);
    lbm::Coverage<3> coverage(domain, scene.periodic);
    fast.set_state([](std::array<double, 3> const& at) {
        auto const [x, y, z] = at;
        return lbm::PointState<3>{
            .velocity = {0.03 * std::sin(0.3 * y), 0.02 * std::cos(0.2 * x + 0.5 * z), 0.02 * std::sin(0.4 * x * y)},
            .pressure = 1e-3 * std::sin(0.1 * x * y + z),
            .gradient = {}};
    });
    auto const start = populations_of(fast);
    std::copy(start.begin(), start.end(), plain.populations().begin());
    double worst_load = 0, largest_load = 0;
    for (int step = 0; step < 60; ++step) {
        auto const spheres = scene.spheres ? spheres_at(step, scene.periodic[0]) : std::vector<lbm::Body<3>>{};
        Arrays const arrays(spheres);
        coverage.update(spheres, team);
        fast.set_bodies(arrays.view());
        fast.step();
        plain.step(spheres, coverage);
        for (std::size_t i = 0; i < spheres.size(); ++i)
            for (std::size_t k = 0; k < 6; ++k) {
                double const got = k < 3 ? fast.exchange().force[3 * i + k] : fast.exchange().torque[3 * i + k - 3];
                worst_load = std::max(worst_load, std::abs(got - plain.loads()[i][k]));
                largest_load = std::max(largest_load, std::abs(got));
            }
    }
    Distance const found = distance(populations_of(fast), plain.populations(), worst_load);
    CHECK(found.largest > 1e-4);
    if (scene.spheres) CHECK(largest_load > 1e-3);
    return found;
}

void check(Scene const& scene)
{
    INFO(std::string(scene.name));
    Distance const exact = from_plain(scene, lbm::Precision::float64);
    CHECK(exact.population < 1e-13);
    CHECK(exact.load < 1e-11);
    check_floats(from_plain(scene, lbm::Precision::float32), 60);
}

}  // namespace

TEST_CASE("space: equals the plain lattice in every feature set, with and without moving spheres")
{
    using enum lbm::Operator;
    check({"trt, periodic", trt, 0, 0, {true, true, true}, false});
    check({"bgk force, channel", bgk, 0, 1e-5, {true, true, false}, false});
    check({"mrt, box", mrt, 0, 0, {false, false, false}, false});
    check({"mrt force, y walls", mrt, 0, 1e-5, {true, false, true}, false});
    check({"trt les, box", trt, 0.15, 0, {false, false, false}, false});
    check({"mrt les force, x walls", mrt, 0.15, 1e-5, {false, true, true}, false});
    check({"trt spheres, periodic", trt, 0, 0, {true, true, true}, true});
    check({"trt spheres force, box", trt, 0, 1e-5, {false, false, false}, true});
    check({"mrt spheres, periodic", mrt, 0, 0, {true, true, true}, true});
    check({"mrt les spheres force, channel", mrt, 0.15, 1e-5, {true, true, false}, true});
    check({"central spheres, periodic", central, 0, 0, {true, true, true}, true});
    check({"central les spheres force, box", central, 0.15, 1e-5, {false, false, false}, true});
}

TEST_CASE("space: the fractions of a sphere are those of its cells, and add up to its volume")
{
    sluice::Team team(1);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (double const radius : {0.3, 1.0, 2.5, 4.7, 9.2}) {
        lbm::Layout const layout({32, 30, 28});
        lbm::Domain<3> const domain(layout, nullptr);
        lbm::Coverage<3> coverage(domain, {});
        lbm::Body<3> const sphere{{15 + uniform(random), 14 + uniform(random), 13 + uniform(random)}, radius, {}};
        coverage.update(std::vector{sphere}, team);
        double sum = 0, worst = 0;
        std::vector<double> fraction(32 * 30 * 28, 0.0);
        auto const [begin, end] = coverage.of_body(0);
        for (std::size_t k = begin; k < end; ++k) {
            auto const& s = coverage.strips()[k];
            for (std::ptrdiff_t x = 0; x < s.count; ++x) {
                sum += s.fraction(x);
                fraction[static_cast<std::size_t>(s.row * 32 + s.begin + x)] += s.fraction(x);
            }
        }
        if (radius >= 1.0) CHECK(sum == close_to(4.0 / 3.0 * pi * radius * radius * radius).epsilon(0.005));
        if (radius >= 2.5) CHECK(sum == close_to(4.0 / 3.0 * pi * radius * radius * radius).epsilon(5e-4));
        constexpr int fine = 20;  // points a cell each way: off by some 1e-3 themselves
        for (std::size_t cell = 0; cell < fraction.size(); ++cell) {
            double const from_surface = std::hypot(static_cast<double>(cell % 32) + 0.5 - sphere.centre[0],
                                                   static_cast<double>(cell / 32 % 30) + 0.5 - sphere.centre[1],
                                                   static_cast<double>(cell / 960) + 0.5 - sphere.centre[2]) -
                                        radius;
            if (std::abs(from_surface) > 0.87) {  // more than half a diagonal: all of the cell is on one side
                worst = std::max(worst, std::abs(fraction[cell] - (from_surface < 0)));
                continue;
            }
            int inside = 0;
            for (int k = 0; k < fine * fine * fine; ++k) {
                double const x = static_cast<double>(cell % 32) + (k % fine + 0.5) / fine,
                             y = static_cast<double>(cell / 32 % 30) + (k / fine % fine + 0.5) / fine,
                             z = static_cast<double>(cell / 960) + (k / fine / fine + 0.5) / fine;
                inside += std::hypot(x - sphere.centre[0], y - sphere.centre[1], z - sphere.centre[2]) < radius;
            }
            worst = std::max(worst, std::abs(fraction[cell] - inside / static_cast<double>(fine * fine * fine)));
        }
        INFO("radius " << radius << ", worst " << worst);
        CHECK(worst < (radius < 1 ? 0.03 : 0.016));  // the points of this sum alone: some 0.003
    }
}

TEST_CASE("space: a sphere's cells that are covered in part have room")
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (double radius = 0.1; radius < 40; radius *= 1.3)
        for (int k = 0; k < 4; ++k) {
            std::array<double, 3> const centre{uniform(random), uniform(random), k == 0 ? 0.0 : uniform(random)};
            lbm::SphereBox const box = lbm::sphere_box(centre, radius);
            std::vector<lbm::RowCover> rows(static_cast<std::size_t>(box.size[1] * box.size[2]));
            std::vector<double> fractions(static_cast<std::size_t>(box.size[0]) * rows.size() + lbm::RowCover::slack);
            lbm::rasterise(centre, radius, box, fractions, rows);
            std::size_t listed = 0;
            for (lbm::RowCover const& row : rows) listed += static_cast<std::size_t>(row.left + row.right);
            CHECK(listed <= lbm::most_listed_of_sphere(radius));
        }
}

TEST_CASE("space: fluid at rest stays at rest, with spheres and body force a neutral one feels its buoyancy")
{
    for (auto const collision : {lbm::Operator::trt, lbm::Operator::central}) {
        Scene const scene{"rest", collision, 0, 0, {true, true, false}, true};
        lbm::Config c = config(scene);
        c.walls[lbm::upper_z].velocity = {};
        c.acceleration = {0, 0, -1e-5};
        lbm::Solver<3> solver(c);
        solver.set_state([&](std::array<double, 3> const& at) {
            return lbm::PointState<3>{.velocity = {}, .pressure = 1e-5 * (7 - at[2]), .gradient = {}};
        });
        lbm::Body<3> const sphere{{10.3, 8.1, 6.6}, 3.3, {}};
        Arrays const arrays({sphere});
        for (int k = 0; k < 200; ++k) {
            solver.set_bodies(arrays.view());
            solver.step();
        }
        double const buoyancy = 1e-5 * 4.0 / 3.0 * pi * 3.3 * 3.3 * 3.3;
        CHECK(solver.max_speed() < 1e-12);
        CHECK(solver.loads().force[2] == close_to(buoyancy).epsilon(1e-9));
        CHECK(std::abs(solver.loads().force[0]) < 1e-9 * buoyancy);
    }
}

TEST_CASE("space: any number of threads and a restored state give the same bits, in both precisions")
{
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32}) {
        Scene const scene{"threads", lbm::Operator::mrt, 0.1, 1e-5, {true, true, false}, true};
        lbm::Config one = config(scene);
        one.precision = precision;
        lbm::Config three = one;
        one.threads = 1;
        three.threads = 3;
        lbm::Solver<3> a(one), b(three), resumed(three);
        for (int k = 0; k < 40; ++k) {
            Arrays const arrays(spheres_at(k, true));
            for (auto* solver : {&a, &b, &resumed}) {
                if (solver == &resumed && k <= 20) continue;
                solver->set_bodies(arrays.view());
                solver->step();
            }
            if (k != 20) continue;
            sluice::State kept;
            b.keep(kept);
            resumed.restore(kept);
        }
        for (auto* other : {&b, &resumed}) {
            CHECK(populations_of(a) == populations_of(*other));
            CHECK(std::ranges::equal(a.loads().force, other->loads().force));
            CHECK(std::ranges::equal(a.loads().torque, other->loads().torque));
        }
    }
}

//! Where a cylinder's surface goes through corners of cells but for rounding. Floats are rounded by 2^-24 when stored.
TEST_CASE("space: a trace of a curved solid does nothing to the fluid, in single precision too")
{
    constexpr int steps = 10;
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32})
        for (double const fraction : {1e-36, 1e-39, 1e-43}) {
            lbm::Config c = unit_config<3>({8, 7, 6}, 0.02);
            c.acceleration = {1e-5, 0, 0};
            c.precision = precision;
            lbm::Patch<3> trace{.first = {3, 3, 3}, .size = {1, 1, 1}, .fraction = {fraction}, .drag = 0.5};
            lbm::Solver<3> without(c), with(c, {trace});
            for (int k = 0; k < steps; ++k) {
                without.step();
                with.step();
            }
            auto const expected = populations_of(without), populations = populations_of(with);
            double const largest = std::ranges::max(expected);
            for (std::size_t k = 0; k < expected.size(); ++k)
                CHECK(std::abs(populations[k] - expected[k]) <= steps * std::ldexp(largest, -23));
        }
}

//! Its row has a solid, but no cell with solid.
TEST_CASE("space: a solid of less than the smallest float gets nothing, whatever bodies got before")
{
    lbm::Config c = unit_config<3>({10, 9, 8}, 0.05);
    c.precision = lbm::Precision::float32;
    lbm::Solver<3> solver(c, {{.first = {3, 3, 3}, .size = {1, 1, 1}, .fraction = {1e-50}, .drag = lbm::flat_drag}});
    std::vector<double> const at{5, 4.5, 4}, velocity{0.01, 0, 0}, spin(3), radius{2.5};
    solver.set_bodies({at, velocity, spin, radius});
    solver.step();
    REQUIRE(solver.loads().force[0] < 0);
    solver.set_bodies({});
    solver.step();
    for (double const force : solver.solid_loads().force) CHECK(force == 0);
}

TEST_CASE("space: fluid that drifts keeps its momentum in single precision")
{
    // weights that do not add up to 1 as floats would change it at every step: 3e-8 of it, the same way each time.
    // Mark: roundings of a float that are independent, up to 16 a step: of a collision without fused operations, about
    // as many sums and products go into a population
    constexpr int steps = 500, roundings = 16 * steps;
    auto c = unit_config<3>({16, 16, 16}, 0.1);
    c.precision = lbm::Precision::float32;
    for (std::size_t axis = 0; axis < 3; ++axis) c.set_periodic(axis);
    lbm::Solver<3> solver(c);
    solver.set_state([](std::array<double, 3> const& at) {
        return lbm::PointState<3>{
            .velocity = {0.05 + 0.01 * std::sin(pi / 8 * at[1]), 0.01, -0.01}, .pressure = 0, .gradient = {}};
    });
    auto const before = solver.momentum();
    for (int k = 0; k < steps; ++k) solver.step();
    auto const after = solver.momentum();
    for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(std::abs(after[axis] - before[axis]) < std::sqrt(roundings) * 0x1p-24 * std::abs(before[axis]));
}

TEST_CASE("space: what the spheres get is what fluid, walls and force lose")
{
    // single: of all momentum that there is, the rounding of a float, 16 of them that are independent
    for (auto const& [precision, mark] :
         {std::pair{lbm::Precision::float64, 1e-12}, {lbm::Precision::float32, 4 * 0x1p-24}}) {
        for (auto const collision : {lbm::Operator::trt, lbm::Operator::central}) {
            Scene const scene{"momentum", collision, 0, 0, {true, true, true}, true};
            lbm::Config c = config(scene);
            c.precision = precision;
            lbm::Solver<3> solver(c);
            auto before = solver.momentum();
            for (int k = 0; k < 30; ++k) {
                Arrays const arrays(spheres_at(k, true));
                solver.set_bodies(arrays.view());
                solver.step();
                auto const after = solver.momentum();
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    double lost = before[axis] - after[axis];
                    for (std::size_t i = 0; i < 3; ++i) lost -= solver.exchange().force[3 * i + axis];
                    CHECK(std::abs(lost) < mark);
                }
                before = after;
            }
            CHECK(std::abs(before[0]) > 0.1);
        }
    }
}
