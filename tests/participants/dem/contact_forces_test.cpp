#include "participants/dem/contact_forces.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "participants/dem/packing.hpp"
#include "participants/dem/solver.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

//! The forces of all contacts, summed up for each grain.
template <int D>
std::vector<dem::Vec<D>> sums(std::vector<dem::ContactForce<D>> const& forces, std::size_t grains)
{
    std::vector<dem::Vec<D>> sum(grains);
    for (auto const& f : forces) {
        sum[f.first] += f.force();
        if (f.second < grains) sum[f.second] -= f.force();
    }
    return sum;
}

//! Spheres that fall into a drum with a floor that moves (in LIGGGHTS' order a wall's speed is that of a step: it
//! rests), then the forces evaluated without a step.
dem::Solver<3> tumbled(dem::Features const& features)
{
    double const cell = 8.5e-3;
    dem::ContactConfig c = rolling_contact(0.3, features.rolling);
    c.elasticity = features.elasticity;
    c.youngs_modulus = 1e7;
    c.poissons_ratio = 0.25;
    dem::Setup<3> s;
    s.gravity = {1.0, 0.5, -9.81};
    s.law = dem::contact_law(c);
    s.skin = 1e-3;
    s.features = features;
    dem::WallMotion<3> motion;
    if (features.scheme == dem::Scheme::predicted) motion.velocity = {0.2, 0.0, 0.05};
    s.walls.push_back({.name = "floor", .shape = dem::Plane<3>{{}, {0, 0, 1}}, .motion = motion, .law = s.law});
    s.walls.push_back({.name = "drum",
                       .shape = dem::Cylinder<3>{{2.5 * cell, 2.5 * cell, 0}, {0, 0, 1}, 0.028, true},
                       .motion = {},
                       .law = s.law});
    dem::Random random(5);
    dem::Grains<3> g;
    for (int k = 0; k < 5 * 5 * 4; ++k)
        g.add({(k % 5 + 0.5) * cell, (k / 5 % 5 + 0.5) * cell, (k / 25 + 0.5) * cell}, random.uniform(4e-3, 4.4e-3),
              density,
              {{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
               {random.uniform(-50, 50), random.uniform(-50, 50), 5.0}});
    dem::Solver<3> solver(s, g);
    for (int n = 0; n < 6; ++n) solver.step(5e-6);
    if (features.scheme == dem::Scheme::liggghts) return solver;  // its forces are of the velocities that the state has
    return {s, solver.grains(), dem::records_of(solver.state())};
}

}  // namespace

TEST_CASE("contact forces: of each grain they add up to what the loops gave it, for every law and order")
{
    using dem::Elasticity, dem::Rolling, dem::Scheme;
    for (dem::Features const& features :
         {dem::Features{},
          {.friction = true},
          {.friction = true, .rolling = Rolling::elastic_plastic, .ledger = true},
          {.elasticity = Elasticity::hertz, .friction = true},
          {.friction = true, .rolling = Rolling::constant, .scheme = Scheme::liggghts}}) {
        CAPTURE(static_cast<int>(features.scheme));
        CAPTURE(static_cast<int>(features.elasticity));
        auto const solver = tumbled(features);
        auto const& g = solver.grains();
        auto const forces = dem::contact_forces(solver.setup(), solver.state());
        auto const sum = sums(forces, g.size());
        double worst = 0.0, largest = 0.0, friction = 0.0;
        for (std::size_t i = 0; i < g.size(); ++i) {
            worst = std::max(worst, dem::norm(sum[i] - g.contact[i].force));
            largest = std::max(largest, dem::norm(g.contact[i].force));
        }
        for (auto const& f : forces) friction = std::max(friction, dem::norm(f.tangential));
        CHECK(forces.size() > 50);
        CHECK(largest > 1e-3);
        CHECK((friction > 0.0) == features.friction);
        CHECK(worst < 1e-12 * largest);  // another order of the same sums
    }
}

TEST_CASE("contact forces: in a settled bed they carry each grain's weight, and the floor carries all of it")
{
    dem::Config c = config();
    c.walls.back().removed_at = 1e9;
    auto solver = dem::make_solver<2>(c, dem::pour_packing<2>(c));
    for (int n = 0; n < 40000; ++n) solver.step(c.step);
    auto const& g = solver.grains();
    auto const forces = dem::contact_forces(solver.setup(), solver.state());
    auto const sum = sums(forces, g.size());
    double const weight = 9.81 * std::accumulate(g.mass.begin(), g.mass.end(), 0.0), mean = weight / 60;
    double floor = 0.0;
    for (auto const& f : forces) {
        if (f.second == g.size()) floor += f.force().y;  // wall 0 is the floor, the others may lean by friction
        CHECK(f.normal >= 0.0);
        CHECK(dem::norm(f.tangential) <= c.contact.friction * f.normal * (1.0 + 1e-12));
    }
    double sides = 0.0;
    for (auto const& f : forces)
        if (f.second > g.size()) sides += f.force().y;
    CHECK(floor + sides == close_to(weight).epsilon(1e-4));
    for (std::size_t i = 0; i < g.size(); ++i)  // settled: the accelerations that are left are small against g
        CHECK(dem::norm(sum[i] + dem::Vec2{0.0, -9.81 * g.mass[i]}) < 1e-2 * mean);
}
