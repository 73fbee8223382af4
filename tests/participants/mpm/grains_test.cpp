#include "participants/mpm/grains.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/mpm/setup.hpp"
#include "participants/mpm/solver.hpp"
#include "tests/participants/mpm/scenes.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

//! A block of 0.4 m.
template <int D>
mpm::Config block()
{
    return unit::box<D>(1.2, {0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
}

//! Beside the block by `gap`, on its upper side, and one at its right that turns.
template <int D>
std::vector<mpm::Grain<D>> two(double gap, mpm::Vec<D> const& velocity)
{
    std::vector<mpm::Grain<D>> grains(2);
    for (auto& g : grains) {
        g.place.setConstant(0.57);
        g.radius = 0.15;
        g.velocity = velocity;
    }
    grains[0].id = 7;
    grains[0].place[D - 1] = 0.95 + gap;
    grains[1].id = 9;
    grains[1].place[0] = 0.95 + gap;
    grains[1].spin[grains[1].spin.size() - 1] = 30;
    return grains;
}

template <int D>
mpm::Solver<D> with_grains(mpm::Config const& c, bool one_at_a_time, double friction)
{
    auto setup = mpm::make_setup<D>(c);
    setup.one_at_a_time = one_at_a_time;
    mpm::Solver<D> solver(setup, mpm::make_state<D>(c));
    solver.set_friction(friction);
    return solver;
}

template <int D>
void check_reaction(mpm::BasisKind basis, mpm::Scheme scheme, bool one_at_a_time)
{
    mpm::Config c = block<D>();
    c.basis = basis;
    c.affine = basis != mpm::BasisKind::linear;
    c.scheme = scheme;
    auto solver = with_grains<D>(c, one_at_a_time, 0.4);
    auto grains = two<D>(0.001, mpm::Vec<D>::Constant(-0.5));
    mpm::Vec<D> given = mpm::Vec<D>::Zero();
    double scale = 0, moment = 0;
    for (int k = 0; k < 40; ++k) {
        double const dt = 0.2 * solver.limit();
        solver.set_grains(grains);
        solver.step(dt);
        for (auto const& push : solver.grains().pushes()) {
            given += push.impulse;
            scale += push.impulse.norm();
            moment += push.angular.norm();
        }
        for (auto& g : grains) g.place += dt * g.velocity;
    }
    CHECK(scale > 1);
    CHECK(moment > 0.01 * scale * 0.15);
    CHECK((unit::momentum(solver.state()) + given).norm() < 1e-13 * scale);
}

}  // namespace

TEST_CASE(
    "grains: what points gain grains lose, to rounding, every basis and scheme, plane and space, both ways of a step")
{
    for (auto scheme : {mpm::Scheme::musl, mpm::Scheme::usl})
        for (auto basis : {mpm::BasisKind::gimp, mpm::BasisKind::spline, mpm::BasisKind::linear}) {
            check_reaction<2>(basis, scheme, true);
            check_reaction<2>(basis, scheme, false);
            check_reaction<3>(basis, scheme, true);
        }
}

TEST_CASE("grains: moments vanish too: what nodes get about any point grains get with the other sign")
{
    auto const setup = mpm::make_setup<3>(block<3>());
    auto const state = mpm::make_state<3>(block<3>());
    mpm::GrainContacts<3> contacts;
    contacts.friction = 0.7;
    auto const grains = two<3>(0, {-0.4, 0.3, -0.6});
    contacts.set(grains);
    contacts.begin(setup);
    for (auto const& p : state.points)
        if (contacts.is_near(setup, p.place)) contacts.consider(setup, 1e-3, p.id, p.place, 1);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> mass(0.1, 1);
    for (auto& node : contacts.nodes()) node.mass = mass(random);
    mpm::Booked booked;
    contacts.solve(setup, 0, 1e-3, booked);
    mpm::Vec3 impulse = mpm::Vec3::Zero(), moment = mpm::Vec3::Zero();
    for (auto const& node : contacts.nodes()) {
        mpm::Vec3 const at = 0.1 * mpm::Vec3(node.index[0], node.index[1], node.index[2]);
        impulse += node.mass * node.velocity;
        moment += at.cross(node.mass * node.velocity);
    }
    double const size = impulse.norm();
    CHECK(size > 0.1);
    for (std::size_t g = 0; g < 2; ++g) {
        auto const& push = contacts.pushes()[g];
        impulse += push.impulse;
        moment += grains[g].place.cross(push.impulse) + push.angular;
    }
    CHECK(impulse.norm() < 1e-14 * size);
    CHECK(moment.norm() < 1e-14 * size);
    CHECK(booked.sliding > 0);
}

TEST_CASE("grains: those that leave, or stay away, get nothing, and nothing is held")
{
    for (double const gap : {0.0, 0.02}) {
        auto solver = with_grains<2>(block<2>(), false, 0.5);
        auto const alone = solver;
        solver.set_grains(two<2>(gap, gap > 0 ? mpm::Vec<2>(-0.1, -0.1) : mpm::Vec<2>(0.3, 0.3)));
        solver.step(1e-3);
        auto without = alone;
        without.step(1e-3);
        CHECK(solver.grains().contacts() > 0);  // near enough to be looked at
        for (auto const& push : solver.grains().pushes()) CHECK(push.impulse.norm() == 0);
        for (std::size_t p = 0; p < solver.state().points.size(); ++p)
            CHECK(solver.state().points[p].velocity == without.state().points[p].velocity);
    }
}

TEST_CASE("grains: points stay outside: overlap is a small share of a cell")
{
    mpm::Config c = block<2>();
    c.walls.push_back({.axis = 1, .side = -1, .place = 0.4});
    auto solver = with_grains<2>(c, false, 0);
    auto grains = two<2>(0.01, {0, -0.2});
    grains.resize(1);
    double deepest = 0;
    while (grains[0].place[1] > 0.9) {  // 0.05 m, an eighth of the block
        double const dt = solver.longest_step();
        solver.set_grains(grains);
        solver.step(dt);
        grains[0].place += dt * grains[0].velocity;
        for (auto const& p : solver.state().points)
            deepest = std::max(deepest, 0.15 + 0.025 - (p.place - grains[0].place).norm());
    }
    CHECK(solver.grains().pushes()[0].impulse[1] > 0);
    CHECK(deepest < 0.3 * 0.025);  // half the width of a point shrinks by less than the strain, 0.3 at most
}

TEST_CASE(
    "grains: four points at a time do what one at a time does beside grains and plates, and the books are the same")
{
    mpm::Config c = block<2>();
    c.gravity = {0, -9.81, 0};
    for (int side : {-1, 1})
        c.walls.push_back({.axis = 1, .side = side, .place = side < 0 ? 0.4 : 1.2, .kind = mpm::WallKind::rough});
    mpm::Plate<3> piston{.point = {0.39, 0, 0}, .normal = {1, 0, 0}, .friction = 0.3};
    piston.motion.velocity = {0.5, 0, 0};
    piston.motion.amplitude = {0, 1e-3, 0}, piston.motion.frequency = 100;
    c.plates = {piston};
    auto plain = with_grains<2>(c, true, 0.3), packed = with_grains<2>(c, false, 0.3);
    auto grains = two<2>(0.001, {-0.2, -0.5});
    for (int k = 0; k < 100; ++k) {
        double const dt = 0.2 * plain.limit();
        for (auto* s : {&plain, &packed}) {
            s->set_grains(grains);
            s->step(dt);
        }
        for (auto& g : grains) g.place += dt * g.velocity;
    }
    double const off = 1e-5 * c.cell;  // the tolerance of the sweeps, which rounding may end one earlier or later
    for (std::size_t p = 0; p < plain.state().points.size(); ++p) {
        auto const &a = plain.state().points[p], &b = packed.state().points[p];
        CHECK((a.place - b.place).norm() < off);
        CHECK((a.velocity - b.velocity).norm() < off / (0.2 * plain.limit()));
    }
    auto const a = plain.energies(), b = packed.energies();
    CHECK(a.booked.external_work > 0.1);
    CHECK(b.booked.external_work == close_to(a.booked.external_work).epsilon(1e-6));
    CHECK(b.booked.sliding == close_to(a.booked.sliding).epsilon(1e-6));
    CHECK(b.booked.numerical == close_to(a.booked.numerical).epsilon(1e-4));
}

TEST_CASE("grains: a fast one shortens the step, a point deep inside one ends the run and names both")
{
    auto solver = with_grains<2>(block<2>(), false, 0);
    double const alone = solver.longest_step();
    auto grains = two<2>(0.05, {0, -100});
    solver.set_grains(grains);
    CHECK(solver.longest_step() == close_to(0.4 * 0.1 / (100 + 30 * 0.15)));
    CHECK(solver.longest_step() < alone);
    grains = two<2>(-0.14, {0, 0});
    grains.resize(1);
    solver.set_grains(grains);
    std::string said;
    try {
        solver.step(1e-3);
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::numerical);
        said = e.what();
    }
    CHECK(contains(said, "cells inside grain 7 (must stay outside)"));
    CHECK(contains(said, "mpm: point "));
}

TEST_CASE("grains: one smaller than a cell is refused, with its size")
{
    auto solver = with_grains<2>(block<2>(), false, 0);
    auto grains = two<2>(0.05, {0, 0});
    grains[1].radius = 0.049;
    solver.set_grains(grains);
    std::string said;
    try {
        solver.step(1e-3);
    } catch (sluice::Error const& e) {
        said = e.what();
    }
    CHECK(contains(said, "grain 9 has a radius of 0.049 m, 0.49 cells (must be at least 0.5)"));
}
