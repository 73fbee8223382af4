#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "participants/dem/random.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/dem/setup.hpp"

//! Small scenes shared by the unit tests.
namespace unit {

inline constexpr double density = 2650.0, stiffness = 1e6;

inline dem::ContactConfig contact(double friction, double damping_ratio = 0.2)
{
    dem::ContactConfig c;
    c.normal_stiffness = stiffness;
    c.damping_ratio = damping_ratio;
    c.tangential_stiffness = stiffness * 2.0 / 7.0;
    c.tangential_damping = 0.2;
    c.friction = friction;
    return c;
}

//! The same with resistance to rolling, mu_r = 0.1.
inline dem::ContactConfig rolling_contact(double friction, dem::Rolling law)
{
    dem::ContactConfig c = contact(friction);
    c.rolling = law;
    c.rolling_friction = 0.1;
    c.rolling_stiffness = 1.0;
    c.rolling_damping = 0.3;
    return c;
}

inline dem::Setup<2> setup(double friction, dem::Vec2 gravity = {0.0, -9.81}, bool ledger = false)
{
    dem::Setup<2> s;
    s.gravity = gravity;
    s.law = dem::contact_law(contact(friction));
    s.skin = 2e-4;
    s.features = {.friction = friction > 0.0, .ledger = ledger};
    return s;
}

inline void add_wall(dem::Setup<2>& s, std::string const& name, dem::Vec2 point, dem::Vec2 normal)
{
    s.walls.push_back({.name = name, .shape = dem::Plane<2>{point, normal}, .motion = {}, .law = s.law});
}

//! `side` x `side` discs of 1 to 1.8 mm at random places of cells of 1.9 mm.
inline dem::Grains<2> loose(int side, std::uint64_t seed, double speed = 0.0)
{
    dem::Random random(seed);
    dem::Grains<2> g;
    for (int k = 0; k < side * side; ++k) {
        double const radius = random.uniform(0.5e-3, 0.9e-3), cell = 1.9e-3;
        double const x = (k % side) * cell + random.uniform(radius, cell - radius);
        double const y = (k / side) * cell + random.uniform(radius, cell - radius);
        double const vx = random.uniform(-speed, speed), vy = random.uniform(-speed, speed);
        g.add({x, y}, radius, density, {{vx, vy}, 0.0});
    }
    return g;
}

//! A box of 12 x 12 falling grains with friction.
inline dem::Solver<2> box(bool ledger = false, double skin = 2e-4)
{
    dem::Setup<2> s = setup(0.5, {0.0, -9.81}, ledger);
    s.skin = skin;
    add_wall(s, "floor", {0.0, 0.0}, {0.0, 1.0});
    add_wall(s, "left", {0.0, 0.0}, {1.0, 0.0});
    add_wall(s, "right", {12 * 1.9e-3, 0.0}, {-1.0, 0.0});
    return {s, loose(12, 5, 0.3)};
}

//! Spheres that fall, turn, meet, slide and part in a box with a moving floor.
inline dem::Solver<3> tumbling(dem::Rolling rolling, dem::Scheme scheme, bool plain, bool ledger = false,
                               int threads = 1, dem::Elasticity elasticity = dem::Elasticity::linear)
{
    dem::ContactConfig c = rolling_contact(0.3, rolling);
    c.elasticity = elasticity;
    c.normal_stiffness = 1e5;
    c.tangential_stiffness = 2e5 / 7.0;
    c.youngs_modulus = 1e8;  // about as stiff, at the overlaps of these impacts
    c.poissons_ratio = 0.25;
    dem::Setup<3> s;
    s.gravity = {1.0, 0.5, -9.81};
    s.law = dem::contact_law(c);
    s.skin = 1e-3;
    s.plain = plain;
    s.threads = threads;
    s.features = {.elasticity = elasticity, .friction = true, .rolling = rolling, .scheme = scheme, .ledger = ledger};
    auto const wall = [&](dem::Vec3 point, dem::Vec3 normal, dem::Vec3 velocity) {
        dem::WallMotion<3> motion;
        motion.velocity = velocity;
        s.walls.push_back({.name = "w", .shape = dem::Plane<3>{point, normal}, .motion = motion, .law = s.law});
    };
    wall({}, {0, 0, 1}, {0.2, 0.0, 0.05});
    wall({}, {1, 0, 0}, {});
    wall({}, {0, 1, 0}, {});
    wall({0.05, 0, 0}, {-1, 0, 0}, {});
    wall({0, 0.05, 0}, {0, -1, 0}, {});
    s.walls.push_back({.name = "pillar",
                       .shape = dem::Cylinder<3>{{0.025, 0.025, 0.0}, {0, 0, 1}, 0.004, false},
                       .motion = {},
                       .law = s.law});
    dem::Random random(5);
    dem::Grains<3> g;
    for (int k = 0; k < 5 * 5 * 9 + 2; ++k) {
        auto const about = [&](double scale) { return random.uniform(-scale, scale); };
        dem::Vec3 const centre{(k % 5 + 0.5) * 0.01 + about(5e-4), (k / 5 % 5 + 0.5) * 0.01 + about(5e-4),
                               (k / 25 + 0.5) * 0.01 + about(5e-4)};
        if (k % 25 == 12) continue;  // where the pillar is
        dem::Motion<3> motion{};
        motion.velocity = {about(1.0), about(1.0), about(1.0)};
        motion.spin = {about(100.0), about(100.0), about(100.0)};
        g.add(centre, random.uniform(3.5e-3, 4.5e-3), 2650.0, motion);
    }
    return {s, g};
}

//! The same numbers in the ledger.
template <int D>
bool same_books(dem::State<D> const& a, dem::State<D> const& b)
{
    auto const numbers = [](dem::State<D> const& s) {
        return std::array{s.booked.normal_dashpot, s.booked.tangential_dashpot, s.booked.sliding,
                          s.booked.rolling,        s.booked.wall_work,          s.booked.touch,
                          s.power.normal,          s.power.tangential,          s.power.sliding,
                          s.power.rolling};
    };
    return numbers(a) == numbers(b);
}

inline constexpr double step = 2e-6;  //!< [s], below t_c/50 of two 1 mm discs

inline char const* const scene =
    "density: 2650\n"
    "diameter: {min: 1.0e-3, max: 1.8e-3}\n"
    "contact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction_angle: 26}\n"
    "walls:\n"
    "  - {name: floor, point: [0, 0], normal: [0, 1]}\n"
    "  - {name: back, point: [0, 0], normal: [1, 0]}\n"
    "column: {count: 60, aspect_ratio: 0.8, seed: 3}\n";

inline dem::Config config(std::string const& text = scene)
{
    return dem::read_config(sluice::read_yaml(text, "grains.yaml"), 2, {0.0, -9.81, 0.0});
}

}  // namespace unit
