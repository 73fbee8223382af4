#include <doctest/doctest.h>

#include <cmath>

#include "participants/mpm/setup.hpp"
#include "participants/mpm/solver.hpp"
#include "tests/participants/mpm/scenes.hpp"

namespace {

//! A block in a box whose left and right sides are one.
mpm::Config joined(double low)
{
    auto c = unit::box<2>(1, {low, 0.2, 0}, {low + 0.4, 0.6, 0});
    for (int side : {-1, 1})
        c.walls.push_back({.axis = 0, .side = side, .place = side < 0 ? 0.0 : 1.0, .kind = mpm::WallKind::joined});
    return c;
}

}  // namespace

TEST_CASE("periodic: a block that lies across the joined sides moves as one in the middle does")
{
    for (auto const& [basis, scheme] : {std::pair{mpm::BasisKind::gimp, mpm::Scheme::usl},
                                        {mpm::BasisKind::gimp, mpm::Scheme::musl},
                                        {mpm::BasisKind::cpdi, mpm::Scheme::musl}}) {
        auto middle = joined(0.3), across = joined(0.3);
        middle.scheme = across.scheme = scheme;
        middle.basis = across.basis = basis;
        auto one = mpm::make_solver<2>(middle), other = mpm::make_solver<2>(across);
        for (auto* solver : {&one, &other})
            for (auto& p : solver->points()) p.velocity = {1.3 + std::sin(9 * p.place[1]), 0.2 * p.place[0]};
        for (auto& p : other.points()) p.place[0] = std::fmod(p.place[0] + 0.5, 1.0);  // five cells on
        double const before = other.energies().balance();
        unit::GainOfVolume gain(other);
        for (int k = 0; k < 120; ++k) {
            double const dt = one.longest_step();
            one.step(dt);
            other.step(dt);
            gain.add(other);
        }
        double most = 0, moved = 0;
        for (std::size_t p = 0; p < one.count(); ++p) {
            auto const &a = one.state().points[p], &b = other.state().points[p];
            double const apart = b.place[0] - a.place[0] - 0.5;
            most = std::max({most, std::abs(apart - std::round(apart)), std::abs(b.place[1] - a.place[1]),
                             (b.velocity - a.velocity).norm()});
            moved = std::max(moved, one.time() * a.velocity[0]);
        }
        CHECK(moved > 0.2);
        CHECK(most < 1e-10);
        CHECK(gain.sum() > 1e-3 * before);
        CHECK(std::abs(other.energies().balance() - before - gain.sum()) < 1e-10 * before);
    }
}

TEST_CASE("periodic: what falls along joined sides goes round and round, and the ledger with it")
{
    auto c = joined(0.3);
    c.gravity = {4, 0, 0};
    auto solver = mpm::make_solver<2>(c);
    double const before = solver.energies().balance();
    while (solver.time() < 1) solver.step(solver.longest_step());  // 2 m: twice round
    double mass = 0;
    for (auto const& p : solver.state().points) {
        mass += p.mass;
        CHECK(p.place[0] >= 0);
        CHECK(p.place[0] <= 1);
    }
    double const speed = 4 * solver.time();
    CHECK(std::abs(solver.energies().kinetic / (0.5 * mass * speed * speed) - 1) < 1e-9);
    CHECK(std::abs(solver.energies().balance() - before) < 1e-9 * solver.energies().kinetic);
}
