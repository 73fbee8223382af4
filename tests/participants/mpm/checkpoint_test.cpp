#include "participants/mpm/checkpoint.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/mpm/measures.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/participants/mpm/scenes.hpp"
#include "tests/support/close_to.hpp"

namespace {

mpm::Config collapse()
{
    mpm::Elasticity const elastic{1e6, 0.3};
    mpm::Config c;
    c.gravity = {0, -9.81, 0};
    c.size = {0.5, 0.2, 0};
    c.cell = 0.01;
    c.density = 1900;
    c.law = mpm::MohrCoulomb{elastic, mpm::MohrCoulombSurface(elastic, {.friction_angle = 0.4})};
    c.bodies.push_back({.low = {0, 0, 0}, .high = {0.1, 0.1, 0}});
    c.walls = {{.axis = 0, .side = -1}, {.axis = 1, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.4}};
    c.walls.push_back({.axis = 0, .side = 1, .place = 0.1, .removed_at = 0.02});
    return c;
}

template <int D>
bool same(mpm::Solver<D> const& a, mpm::Solver<D> const& b)
{
    sluice::State one, other;
    mpm::keep(a, one);
    mpm::keep(b, other);
    return one == other;
}

template <int D>
void goes_on(mpm::Config const& c)
{
    auto solver = mpm::make_solver<D>(c);
    while (solver.time() < 0.015) solver.step(solver.longest_step());
    sluice::State kept;
    mpm::keep(solver, kept);
    auto const bytes = kept.encode();
    auto other = mpm::make_solver<D>(c);
    CHECK(!same(solver, other));
    mpm::restore(other, sluice::State::decode(bytes, "test"));
    CHECK(same(solver, other));
    while (solver.time() < 0.04) {  // past the gate, and the time in which the rate is reached
        solver.step(solver.longest_step());
        other.step(other.longest_step());
    }
    CHECK((solver.energies().booked.sliding > 0) == (D == 2));
    CHECK((solver.energies().booked.field_work != 0) == (c.rotation || solver.setup().period.norm() > 0));
    CHECK(same(solver, other));
}

}  // namespace

TEST_CASE("checkpoint: a run that goes on from one is bit for bit the other, with its books")
{
    for (bool const turns : {false, true}) {
        auto c = collapse();
        if (turns) c.rotation = sluice::Rotation{{0, 2, 0}, {0, 0, 1}, 0.2, 0.03, true, true, true};
        goes_on<2>(c);
    }
    auto corners = collapse();
    corners.basis = mpm::BasisKind::cpdi;
    goes_on<2>(corners);
    auto round = collapse();  // slides up the left wall, and comes in again from below
    round.gravity = {-9.81, -2, 0};
    round.size = {0.2, 0.1, 0};
    round.bodies[0].velocity = {0, 3, 0};
    round.walls = {{.axis = 0, .side = -1, .kind = mpm::WallKind::rough, .friction = 0.4}};
    for (int side : {-1, 1}) round.walls.push_back({1, side, side < 0 ? 0 : 0.1, mpm::WallKind::joined});
    goes_on<2>(round);
    mpm::Config c = unit::box<3>(1.2, {0.4, 0, 0.4}, {0.8, 0.4, 0.8});
    c.rotation = sluice::Rotation{{0, 0, 2}, {0, 1, 0}, 5, 0.03, true, true, true};
    goes_on<3>(c);
}

TEST_CASE("checkpoint: the longest step is that of the run, to the last bit")
{
    auto c = unit::box<2>(100, {1, 1, 0}, {2, 2, 0});
    c.walls.clear();
    auto solver = mpm::make_solver<2>(c);
    REQUIRE(mpm::PackedStep<2>::serves(solver.setup()));
    for (auto& p : solver.points()) p.velocity = {200 + p.place[0], 300 + p.place[1]};
    for (int k = 0; k < 50; ++k) {  // the velocity outweighs the wave of 12 m/s: its rounding shows
        solver.step(1e-4);
        sluice::State kept;
        mpm::keep(solver, kept);
        auto other = mpm::make_solver<2>(c);
        mpm::restore(other, kept);
        CHECK(other.longest_step() == solver.longest_step());
    }
}

TEST_CASE("checkpoint: one that lacks something, or does not fit, is refused and changes nothing")
{
    auto solver = mpm::make_solver<2>(collapse());
    auto const before = solver;
    auto const refused = [&](sluice::State const& kept) {
        try {
            mpm::restore(solver, kept);
        } catch (sluice::Error const& e) {
            CHECK(e.exit() == sluice::Exit::io);
            CHECK(same(solver, before));
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(refused({}).find("points/id") != std::string::npos);
    mpm::Config small = collapse();
    small.bodies[0].high = {0.05, 0.05, 0};
    sluice::State fewer;
    mpm::keep(mpm::make_solver<2>(small), fewer);
    CHECK(refused(fewer).find("points/id") != std::string::npos);
    auto disordered = solver.state();
    disordered.order.assign(disordered.points.size(), 0);
    sluice::State twice;
    mpm::keep(mpm::Solver<2>(solver.setup(), disordered), twice);
    CHECK(refused(twice).find("points/order") != std::string::npos);
    auto still = solver;
    still.restore(solver.state(), 0.0);
    sluice::State without_speed;
    mpm::keep(still, without_speed);
    CHECK(refused(without_speed).find("speed") != std::string::npos);
    auto broken = solver;
    broken.points()[5].place[0] = 0.6;
    sluice::State outside;
    mpm::keep(broken, outside);
    CHECK(refused(outside).find("point 5") != std::string::npos);
    for (double const value : {0.0, std::nan(""), HUGE_VAL}) {  // a domain without an edge, or of no size
        auto flat = solver;
        flat.points()[7].matter.gradient.col(1).setConstant(value);
        sluice::State without_edge;
        mpm::keep(flat, without_edge);
        CHECK(refused(without_edge).find("point 7") != std::string::npos);
    }
}

TEST_CASE("measures: the front is that of the main mass, height that at the back wall")
{
    mpm::Config c = collapse();
    c.bodies.push_back({.low = {0.3, 0, 0}, .high = {0.32, 0.15, 0}});
    auto const solver = mpm::make_solver<2>([&] {
        c.walls.resize(2);
        return c;
    }());
    auto const r = mpm::run_out_of(solver.setup(), solver.state(), 0.005);
    CHECK(r.front == close_to(0.1 + 0.02 * (0.5 - 0.005 / 0.1)));  // a mean over two cells
    CHECK(r.foremost == close_to(0.32));
    CHECK(r.height == close_to(0.1));
    auto tongue = solver.state();  // one layer of points, half a cell deep, ahead of the rest
    for (auto& p : tongue.points)
        if (p.place[1] < 0.005 && p.place[0] > 0.05 && p.place[0] < 0.1) p.place[0] += 0.05;
    CHECK(mpm::run_out_of(solver.setup(), tongue, 0.004).front == close_to(0.15 + 0.02 * (0.5 - 0.004 / 0.005)));
    CHECK(mpm::run_out_of(solver.setup(), tongue, 0.006).front ==
          close_to(0.1 + 0.02 * (0.5 - (0.006 - 0.005) / (0.095 - 0.005))));
    auto away = solver.state();  // from the back wall
    for (auto& p : away.points) p.place[0] += 0.1;
    CHECK(mpm::run_out_of(solver.setup(), away, 0.005).front == close_to(r.front + 0.1));
    auto const centre = mpm::centre_of_mass(solver.state());
    CHECK(centre[0] == close_to((0.01 * 0.05 + 0.003 * 0.31) / 0.013));
    CHECK(centre[1] == close_to((0.01 * 0.05 + 0.003 * 0.075) / 0.013));
}
