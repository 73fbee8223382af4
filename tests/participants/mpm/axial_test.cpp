#include "participants/mpm/axial.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "participants/mpm/basis.hpp"
#include "participants/mpm/setup.hpp"
#include "participants/mpm/solver.hpp"
#include "participants/mpm/transfer.hpp"
#include "tests/participants/mpm/scenes.hpp"

namespace {

//! Rings of radius 0.2 to 0.6 m, or from the axis on.
mpm::Config rings(double inner)
{
    mpm::Config c;
    c.symmetry = mpm::Symmetry::axial;
    c.size = {1, 1, 0};
    c.cell = 0.1;
    c.density = 1000;
    c.law = mpm::LinearElastic{{1e5, 0.3}};
    c.bodies.push_back({.low = {inner, 0.2, 0}, .high = {0.6, 0.8, 0}});
    return c;
}

}  // namespace

TEST_CASE("axial: moments of a hat function are those of its parts")
{
    for (double const l : {0.05, 0.25, 0.5})
        for (double d = -1.6; d < 1.6; d += 0.037) {
            mpm::Moments sum;
            int const parts = 20000;
            mpm::Linear const hat(0);
            for (int k = 0; k < parts; ++k) {
                double const u = l * ((2.0 * k + 1) / parts - 1);
                sum.value += u * hat.value(d + u) / parts;
                sum.slope += u * hat.slope(d + u) / parts;
            }
            mpm::Moments const m = mpm::moments_of_hat(d, l);
            CHECK(std::abs(m.value - sum.value) < 1e-4 * l);
            CHECK(std::abs(m.slope - sum.slope) < 1e-3 * l);
        }
    CHECK(mpm::moments_of_hat(0.3, 0).value == 0);
}

TEST_CASE("axial: mass is that of the cylinder, and uniform pressure pulls at no node inside, wherever the points are")
{
    for (auto const& [basis, inner] : {std::pair{mpm::BasisKind::gimp, 0.0},
                                       {mpm::BasisKind::gimp, 0.2},
                                       {mpm::BasisKind::cpdi, 0.0},
                                       {mpm::BasisKind::cpdi, 0.2}})
        for (double const shift : {0.0, 0.013, 0.031}) {
            CAPTURE(inner);
            CAPTURE(shift);
            auto const setup = mpm::make_setup<2>(rings(inner));
            auto state = mpm::make_state<2>(rings(inner));
            double mass = 0;
            for (auto& p : state.points) {
                mass += p.mass;
                if (inner > 0) p.place[0] += shift;  // those on the axis fill space as they are alone
                p.place[1] += 2 * shift;
                p.volume = 2 * std::numbers::pi * p.place[0] * 0.05 * 0.05;
                p.matter.stress = -1e3 * mpm::Mat3::Identity();
            }
            double const cylinder = std::numbers::pi * (0.36 - inner * inner) * 0.6 * 1000;
            CHECK(std::abs(mass / cylinder - 1) < 1e-12);
            mpm::Grid<2> grid(setup.cells);
            mpm::transfer_of<2>(basis).to_grid(setup, state, {}, {}, grid);
            double most = 0, at_side = 0;
            for (auto const& node : grid.nodes()) {
                double const r = 0.1 * node.index[0], y = 0.1 * node.index[1];
                bool const inside = r > inner + 0.15 - (inner > 0 ? 0 : 0.1) && r < 0.45 && y > 0.4 && y < 0.7;
                double& largest = inside ? most : at_side;
                largest = std::max(largest, node.inner.norm());
            }
            CHECK(at_side > 1);  // N: 1 kPa on a cell of some rings
            CHECK(most < 1e-10);
        }
}

TEST_CASE("axial: the radius stays that of the stretch around the axis, and J that of the ring's volume")
{
    auto c = rings(0.0);
    c.scheme = mpm::Scheme::usl;
    auto solver = mpm::make_solver<2>(c);
    for (auto& p : solver.points()) p.velocity = {2 * p.place[0] * p.place[1], 0.5 * p.place[0]};
    auto const start = solver.state().points;
    for (int k = 0; k < 60; ++k) solver.step(solver.longest_step());
    double moved = 0;
    for (std::size_t p = 0; p < start.size(); ++p) {
        auto const& now = solver.state().points[p];
        double const stretch = now.place[0] / start[p].place[0];
        moved = std::max(moved, std::abs(stretch - 1));
        // strain sees a node of 1e-9 of a cell's mass otherwise
        CHECK(std::abs(now.matter.gradient(2, 2) / stretch - 1) < 1e-9);
        CHECK(std::abs(now.matter.ratio / now.matter.gradient.determinant() - 1) < 1e-12);
    }
    CHECK(moved > 0.01);
}

TEST_CASE("axial: momentum along the axis is kept, free rings gain no energy")
{
    for (mpm::Scheme const scheme : {mpm::Scheme::usl, mpm::Scheme::musl}) {
        auto c = rings(0.2);
        c.scheme = scheme;
        auto solver = mpm::make_solver<2>(c);
        for (auto& p : solver.points()) p.velocity = {std::sin(9 * p.place[1]), 0.3 + std::cos(7 * p.place[0])};
        auto const along = [&] {
            double sum = 0;
            for (auto const& p : solver.state().points) sum += p.mass * p.velocity[1];
            return sum;
        };
        double const before = along(), energy = solver.energies().kinetic;
        unit::GainOfVolume gain(solver);
        for (int k = 0; k < 30; ++k) {
            solver.step(solver.longest_step());
            gain.add(solver);
        }
        CHECK(std::abs(along() / before - 1) < 1e-12);
        auto const e = solver.energies();
        CHECK(e.kinetic + e.elastic < energy);
        CHECK(gain.sum() > 1e-3 * energy);
        CHECK(std::abs(e.balance() - energy - gain.sum()) < 1e-10 * energy);
    }
}
