#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

constexpr double radius = 1e-3, cutoff = 2e-4, viscosity = 0.1;  // m, m, Pa s
constexpr double pi = std::numbers::pi;

template <int D>
dem::Setup<D> squeezing(bool ledger = true)
{
    dem::Setup<D> s;
    s.law = dem::contact_law(contact(0.5));
    s.lubrication = {.viscosity = viscosity, .cutoff = cutoff, .floor = 1e-3};
    s.skin = 2e-4 + cutoff;
    s.features = {.friction = true, .ledger = ledger};
    return s;
}

template <int D>
dem::Vec<D> at(double x)
{
    dem::Vec<D> v;
    v.x = x;
    return v;
}

//! Integral of the film's resistance from a gap h to the cutoff: what the speed falls by, times the mass.
template <int D>
double brake(double h, double effective)
{
    if (D == 3) return 6 * pi * viscosity * effective * effective * (std::log(cutoff / h) - (cutoff - h) / cutoff);
    return 3 * std::numbers::sqrt2 * pi * viscosity * std::pow(effective, 1.5) *
           (2 * (1 / std::sqrt(h) - 1 / std::sqrt(cutoff)) - (cutoff - h) * std::pow(cutoff, -1.5));
}

//! A grain that comes to a wall or to an equal grain at rest: its (relative) speed against the closed form,
//! m dv/dh = resistance.
template <int D>
void check_approach(bool wall)
{
    auto s = squeezing<D>();
    dem::Grains<D> g;
    dem::Motion<D> motion{};
    motion.velocity = at<D>(-0.2);
    g.add(at<D>(2 * radius), radius, density, motion);
    if (wall)
        s.walls.push_back({.name = "wall", .shape = dem::Plane<D>{at<D>(0), at<D>(1)}, .motion = {}, .law = s.law});
    else
        g.add(at<D>(-0.5 * radius), radius, density);
    dem::Solver<D> solver(s, g);
    double const mass = wall ? g.mass[0] : 0.5 * g.mass[0], effective = wall ? radius : 0.5 * radius;
    double const start = solver.energies().balance();
    auto const gap = [&] {
        auto const& place = solver.grains().place;
        return (wall ? place[0].centre.x : place[0].centre.x - place[1].centre.x - radius) - radius;
    };
    auto const speed = [&] {
        auto const& motion = solver.grains().motion;
        return wall ? -motion[0].velocity.x : motion[1].velocity.x - motion[0].velocity.x;
    };
    double worst = 0.0;
    int inside = 0;
    for (int k = 0; k < 200'000 && gap() > 2e-6 && speed() > 1e-3; ++k) {
        solver.step(1e-6);
        if (gap() >= cutoff) {
            CHECK(speed() == close_to(0.2).epsilon(1e-14));
            continue;
        }
        ++inside;
        worst = std::max(worst, std::abs(speed() - (0.2 - brake<D>(gap(), effective) / mass)));
    }
    CHECK(inside > 100);
    CHECK(speed() < 0.15);  // the film took part of it
    // the step's error, of order (c dt/m)^2 at the narrowest gap seen, c dt/m < 0.05
    CHECK(worst < 0.2 * 2.5e-3);
    CHECK(solver.energies().normal_dashpot > 0.0);
    CHECK(solver.energies().balance() == close_to(start).epsilon(2.5e-3));
}

}  // namespace

TEST_CASE("film: a sphere or a disc comes to a wall or to another one by the closed form")
{
    for (bool const wall : {false, true}) {
        check_approach<2>(wall);
        check_approach<3>(wall);
    }
}

TEST_CASE("film: below a Stokes number nothing comes back from a wall, well above it nearly as from a dry one")
{
    auto const rebound = [](double speed) {
        auto s = squeezing<3>();
        s.law = dem::contact_law(contact(0.0, 0.0));
        s.features.friction = false;
        s.walls.push_back({.name = "wall", .shape = dem::Plane<3>{at<3>(0), at<3>(1)}, .motion = {}, .law = s.law});
        dem::Grains<3> g;
        dem::Motion<3> motion{};
        motion.velocity = at<3>(-speed);
        g.add(at<3>(radius + 1.2 * cutoff), radius, density, motion);
        dem::Solver<3> solver(s, g);
        for (int k = 0; k < 20'000 && solver.grains().motion[0].velocity.x < 0.0; ++k) solver.step(2e-7);
        for (int k = 0; k < 20'000 && solver.grains().place[0].centre.x < radius + cutoff; ++k) solver.step(2e-7);
        return solver.grains().motion[0].velocity.x / speed;
    };
    double const mass = density * 4.0 / 3.0 * pi * radius * radius * radius;
    double const needed = brake<3>(1e-3 * radius, radius) / mass;  // to come to the floor's gap at all
    CHECK(rebound(0.9 * needed) < 0.01);
    // and back: twice what the film takes from the cutoff to the floor, at the floor's resistance to the touch, and
    // half of that again while it fades
    double const there = needed + 1.5 * 6 * pi * viscosity * radius * radius * (1 - 1e-3 * radius / cutoff) / mass;
    CHECK(rebound(20 * needed) == close_to(1 - 2 * there / (20 * needed)).epsilon(0.01));
}

TEST_CASE("film: momentum is kept, a run is restored bit for bit, and a scene without films has none of it")
{
    auto s = squeezing<2>();
    s.lubrication.viscosity = 1e-3;
    auto g = loose(6, 3, 0.2);
    auto const momentum = [](dem::Grains<2> const& grains) {
        dem::Vec2 sum{};
        for (std::size_t i = 0; i < grains.size(); ++i) sum += grains.mass[i] * grains.motion[i].velocity;
        return sum;
    };
    dem::Solver<2> solver(s, g);
    double const scale = g.mass[0] * 36 * 0.2;
    auto const before = momentum(solver.grains());
    for (int k = 0; k < 1500; ++k) solver.step(step);
    CHECK(norm(momentum(solver.grains()) - before) < 1e-13 * scale);
    dem::Solver<2> again(s, g);
    again.restore(dem::kept_state<2>(kept(solver), s, g.size()));
    for (int k = 0; k < 500; ++k) {
        solver.step(step);
        again.step(step);
    }
    CHECK(kept(solver) == kept(again));
    s.lubrication = {};
    dem::Solver<2> dry(s, g);
    dry.step(step);
    CHECK(dry.state().films.empty());
}

TEST_CASE("film: what cannot be is refused when the scene is read")
{
    std::string const film = "lubrication: {viscosity: 1.0e-3, cutoff: 6.0e-5}\n";
    CHECK(config(std::string(scene) + film).lubrication.floor == 1e-2);
    auto const refused = [](std::string const& text, char const* message) {
        CHECK_THROWS_WITH_AS(config(std::string(scene) + text), doctest::Contains(message), sluice::Error);
    };
    refused("lubrication: {viscosity: 1.0e-3}\n", "lubrication.cutoff");
    refused("lubrication: {viscosity: -1, cutoff: 6.0e-5}\n", "lubrication.viscosity");
    refused("lubrication: {viscosity: 1.0e+3, cutoff: 6.0e-5}\n", "brakes within m/c");
    CHECK_THROWS_WITH_AS(config("density: 2650\ncontact: {normal_stiffness: 1e6, damping_ratio: 0.2, friction: 0.5}\n"
                                "grains: [{position: [0, 0.01], radius: 0.001}]\n"
                                "walls: [{name: ramp, segments: [{from: [0, 0], to: [1, 0]}]}]\n" +
                                film),
                         doctest::Contains("does not go with a mesh, here wall \"ramp\""), sluice::Error);
    refused(film + "scheme: liggghts\n", "does not go with scheme: liggghts");
}
