#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/kept_populations.hpp"

//! A disc that covers and uncovers cells, and cells that several discs share.
namespace {

lbm::Config config(std::ptrdiff_t nx, std::ptrdiff_t ny, double tau)
{
    lbm::Config c;
    c.cell = c.step = c.density = 1;
    c.size = {static_cast<double>(nx), static_cast<double>(ny)};
    c.viscosity = (tau - 0.5) / 3;
    c.set_periodic(0);
    c.set_periodic(1);
    return c;
}

//! Drag at each step on a disc of 5 cells' radius at 0.05 cells a step, in fluid at rest of a given pressure.
std::vector<double> drag(double pressure, int steps)
{
    lbm::Solver<2> solver(config(96, 40, 0.8));
    solver.set_state([&](std::array<double, 2> const&) {
        return lbm::PointState<2>{.velocity = {}, .pressure = pressure, .gradient = {}};
    });
    std::vector<double> force;
    std::vector<double> const velocity{0.05, 0}, spin{0}, radius{5};
    for (int k = 0; k < steps; ++k) {
        std::vector<double> const position{20 + 0.05 * k, 20.3};
        solver.set_bodies({position, velocity, spin, radius});
        solver.step();
        force.push_back(solver.loads().force[0]);
    }
    return force;
}

}  // namespace

TEST_CASE("moving disc: cells that it uncovers bring no clicks, at whatever pressure")
{
    // all is in proportion to density: a cell that were filled anew with density 1 would break that by the excess, 0.15
    double const excess = 0.15;
    auto const plain = drag(0, 400), dense = drag(excess / 3, 400);
    double worst = 0, largest = 0;
    for (std::size_t k = 0; k < plain.size(); ++k) {
        worst = std::max(worst, std::abs(dense[k] / (1 + excess) - plain[k]));
        largest = std::max(largest, std::abs(plain[k]));
    }
    CHECK(worst < 1e-11 * largest);
}

namespace {

//! What two bodies that come together get in 20 steps, in the order of the first; all of what the fluid loses.
template <int D>
std::vector<double> shared_force(bool swapped, lbm::Surface surface, lbm::Operator collision)
{
    lbm::Config c = config(40, 32, 0.6);
    c.surface = surface;
    c.dimension = D;
    c.collision = collision;
    if (D == 3) c.size[2] = 32, c.set_periodic(2);
    lbm::Solver<D> solver(c);
    double const place[2][3] = {{14.2, 15.1, 15.7}, {21.7, 15.9, 16.2}},
                 speed[2][3] = {{0.02, 0, 0.01}, {-0.01, 0.01, 0}}, turn[2] = {0.001, -0.002}, size[2] = {4.1, 3.9};
    std::vector<double> position, velocity, spin, radius, force(2 * D, 0.0);
    for (std::size_t const i : {swapped ? 1UL : 0UL, swapped ? 0UL : 1UL}) {
        position.insert(position.end(), place[i], place[i] + D);
        velocity.insert(velocity.end(), speed[i], speed[i] + D);
        spin.insert(spin.end(), lbm::spins<D>, turn[i]);
        radius.push_back(size[i]);
    }
    for (int k = 0; k < 20; ++k) {
        auto const before = solver.momentum();
        solver.set_bodies({position, velocity, spin, radius});
        solver.step();
        auto const after = solver.momentum();
        auto const got = solver.exchange().force;
        // rounding of sums of 32^D cells' momenta below 0.03
        for (std::size_t axis = 0; axis < D; ++axis)
            CHECK(std::abs(before[axis] - after[axis] - got[axis] - got[D + axis]) < 1e-12);
        for (std::size_t i = 0; i < 2 * D; ++i) force[i] += got[swapped ? (i + D) % (2 * D) : i];
    }
    return force;
}

template <int D>
void check_shares(lbm::Surface surface, lbm::Operator collision)
{
    auto const one = shared_force<D>(false, surface, collision), other = shared_force<D>(true, surface, collision);
    for (std::size_t i = 0; i < 2 * D; ++i) {
        CHECK(std::abs(one[i]) > 1e-3);
        CHECK(std::abs(one[i] - other[i]) < 1e-11);
    }
}

}  // namespace

TEST_CASE("moving disc: discs and spheres that share cells share the force, in whatever order they come")
{
    for (auto const surface : {lbm::Surface::covered, lbm::Surface::forced}) {
        check_shares<2>(surface, lbm::Operator::mrt);
        check_shares<3>(surface, lbm::Operator::trt);
        check_shares<2>(surface, lbm::Operator::central);
        check_shares<3>(surface, lbm::Operator::central);
    }
}

TEST_CASE("moving disc: a cell that it covers has no eddy viscosity, the next one has")
{
    auto const after_a_step = [](double smagorinsky) {
        lbm::Config c = config(24, 24, 0.52);
        c.smagorinsky = smagorinsky;
        lbm::Solver<2> solver(c);
        solver.set_state([](std::array<double, 2> const& at) {
            return lbm::PointState<2>{.velocity = {0.05 * std::sin(at[1]), 0},
                                      .pressure = 0,
                                      .gradient = {{{0, 0.05 * std::cos(at[1])}, {0, 0}}}};
        });
        std::vector<double> const position{12, 12}, rest{0, 0}, spin{0}, radius{3.3};
        solver.set_bodies({position, rest, spin, radius});
        solver.step();
        return std::pair{populations_of(solver), solver.fields().solid_fraction};
    };
    auto const [a, covered] = after_a_step(0.3);
    auto const b = after_a_step(0).first;
    double inside = 0, outside = 0;
    for (std::size_t q = 1; q < 9; ++q)
        for (std::ptrdiff_t y = 1; y < 23; ++y)
            for (std::ptrdiff_t x = 1; x < 23; ++x) {
                auto const& c = lbm::Lattice<2>::c[q];  // where it came from
                auto const from = static_cast<std::size_t>((y - c[1]) * 24 + x - c[0]);
                auto const at = q * 576 + static_cast<std::size_t>(y * 24 + x);
                double& worst = covered[from] > 1e-6 ? inside : outside;
                worst = std::max(worst, std::abs(a[at] - b[at]));
            }
    CHECK(inside < 1e-15);
    CHECK(outside > 1e-5);
}

TEST_CASE("moving disc: with direct forcing a cell loses twice its covered share of the slip, whatever tau")
{
    // half of the force is in the velocity, which is then (1 - eps) u + eps u_s. No cell is deep inside this disc
    for (double const tau : {0.51, 0.8, 2.0}) {
        lbm::Config c = config(24, 24, tau);
        c.surface = lbm::Surface::forced;
        lbm::Solver<2> solver(c);
        solver.set_state([](auto const&) { return lbm::PointState<2>{.velocity = {0.03, -0.01}}; });
        std::vector<double> const position{11.3, 12.6}, velocity{-0.02, 0.01}, spin{0}, radius{2.1};
        solver.set_bodies({position, velocity, spin, radius});
        solver.step();
        double share = 0;
        for (double const eps : solver.fields().solid_fraction) share += std::min(eps, lbm::full_weight);
        CHECK(std::abs(solver.exchange().force[0] - 2 * share * 0.05) < 1e-13);
        CHECK(std::abs(solver.exchange().force[1] + 2 * share * 0.02) < 1e-13);
    }
}

TEST_CASE("moving disc: direct forcing leaves solids at rest as they are")
{
    auto const after_steps = [](lbm::Surface surface) {
        lbm::Config c = config(48, 24, 0.7);
        c.surface = surface;
        c.acceleration = {1e-4, 0, 0};
        c.solids = {{.name = "pier", .centre = {12, 12}, .radius = 4.3}};
        lbm::Solver<2> solver(c);
        std::vector<double> const position{36, 12}, rest{0, 0}, spin{0}, radius{3.3};
        solver.set_bodies({position, rest, spin, radius});  // too far for a step to reach the pier
        for (int k = 0; k < 5; ++k) solver.step();
        return std::vector<double>(solver.solid_loads().force.begin(), solver.solid_loads().force.end());
    };
    auto const covered = after_steps(lbm::Surface::covered);
    CHECK(covered == after_steps(lbm::Surface::forced));
    CHECK(std::abs(covered[0]) > 1e-5);
}
