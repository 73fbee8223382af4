#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/dem/measures.hpp"
#include "participants/dem/neighbours.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/scenes.hpp"
#include "tests/support/close_to.hpp"

using namespace unit;

namespace {

//! A box of grains that has come to rest, in a scene in which they may sleep.
dem::Solver<2> resting(bool ledger = false)
{
    auto const settle = [](bool with_ledger) {
        auto const loose = box(with_ledger);
        dem::Setup<2> s = loose.setup();
        s.law = dem::contact_law(rolling_contact(0.5, dem::Rolling::elastic_plastic));
        s.features.rolling = dem::Rolling::elastic_plastic;
        for (auto& wall : s.walls) wall.law = s.law;
        s.sleep = {.speed = 1e-5, .time = 2e-3};
        dem::Solver<2> sleepy(s, loose.grains());
        for (int k = 0; k < 200'000; ++k) sleepy.step(step);
        return sleepy;
    };
    static dem::Solver<2> const plain = settle(false), booked = settle(true);
    return ledger ? booked : plain;
}

std::size_t sleepers(dem::Solver<2> const& solver)
{
    auto const& asleep = solver.state().rest.asleep;
    return static_cast<std::size_t>(std::count(asleep.begin(), asleep.end(), 1U));
}

}  // namespace

TEST_CASE("sleep: grains that have come to rest sleep, their weight stays on the floor, and the list is whole")
{
    auto solver = resting();
    std::size_t const count = solver.grains().size();
    CHECK(sleepers(solver) > count / 2);
    double weight = 0.0, before = solver.state().walls[0].force.y;
    for (double const m : solver.grains().mass) weight += 9.81 * m;
    CHECK(before == close_to(weight).epsilon(0.02));
    std::vector<std::uint32_t> first, other;
    dem::find_pairs(solver.grains(), 0.0, first, other);  // all that touch are in the list, as in a new one
    std::size_t const touching = dem::contact_numbers(solver.setup(), solver.state()).contacts;
    CHECK(touching >= other.size());
    auto const places = solver.grains().place;
    for (int k = 0; k < 2000; ++k) solver.step(step);
    for (std::size_t i = 0; i < count; ++i)
        if (solver.state().rest.asleep[i] != 0U) CHECK(solver.grains().place[i].centre == places[i].centre);
}

TEST_CASE("sleep: a grain that falls on them wakes those that it moves")
{
    auto s = resting().setup();
    auto const still = resting();
    auto g = still.grains();
    double const top = dem::measure(still).height;
    g.add({10e-3, top + 4e-3}, 2e-3, density, {{0.0, -3.0}, 0.0});
    dem::Solver<2> hit(s, g);
    dem::Setup<2> awake = s;
    awake.sleep = {};
    dem::Solver<2> all(awake, g);
    for (int k = 0; k < 6000; ++k) {  // they sleep again after 5 ms, here nearly from the start
        hit.step(step);
        all.step(step);
    }
    // the impact's energy goes into the heap in both: the heavy grain has stopped at the same depth
    double const depth = hit.grains().place.back().centre.y, reference = all.grains().place.back().centre.y;
    CHECK(depth == close_to(reference).epsilon(0.02));
    double moved = 0.0;
    for (std::size_t i = 0; i + 1 < g.size(); ++i)
        moved = std::max(moved, norm(hit.grains().place[i].centre - g.place[i].centre));
    CHECK(moved > 1e-4);
}

TEST_CASE("sleep: when a wall goes all wake")
{
    auto solver = resting();
    dem::Setup<2> s = solver.setup();
    s.walls[2].removed_at = solver.time() + 0.01;
    dem::Solver<2> opened(s, solver.grains());
    opened.restore(solver.state());
    while (opened.time() < s.walls[2].removed_at + 2 * step) opened.step(step);
    CHECK(sleepers(opened) == 0);
    double const before = dem::centre_of_mass(opened.grains()).x;
    for (int k = 0; k < 20'000; ++k) opened.step(step);
    CHECK(dem::centre_of_mass(opened.grains()).x > before + 1e-4);
}

TEST_CASE("sleep: the ledger closes over falling asleep, restored runs and looks at the state change no bit")
{
    auto solver = resting(true);
    CHECK(sleepers(solver) > solver.grains().size() / 2);
    auto awake = box(true);
    double const start = awake.energies().balance();
    CHECK(solver.energies().balance() == close_to(start).epsilon(1e-4));  // C08's mark
    CHECK(solver.energies().removed_walls > 0.0);
    CHECK(solver.energies().removed_walls < 1e-5 * start);
    dem::Solver<2> again(solver.setup(), solver.grains());
    again.restore(dem::kept_state<2>(kept(solver), solver.setup(), solver.grains().size()));
    for (int k = 0; k < 777; ++k) {
        solver.step(step);
        again.step(step);
        if (k % 7 == 0) CHECK(again.state().pairs.other.size() > 100);  // takes the list back each time
    }
    CHECK(kept(solver) == kept(again));
}

TEST_CASE("sleep: what would set resting grains in motion unseen is refused when the scene is read")
{
    std::string const sleep = "sleep: {speed: 1.0e-4, time: 0.01}\n";
    CHECK(config(std::string(scene) + sleep).sleep.time == 0.01);
    CHECK(config(std::string(scene) + "sleep: {speed: 1.0e-6, time: 0.01}\n").warnings.empty());
    CHECK(config(std::string(scene) + "sleep: {speed: 1.0e-3, time: 0.01}\n").warnings.size() == 1);
    auto const refused = [](std::string const& text, char const* message) {
        CHECK_THROWS_WITH_AS(config(std::string(scene) + text), doctest::Contains(message), sluice::Error);
    };
    refused("sleep: {speed: 1.0e-4}\n", "sleep.time");
    refused("sleep: {speed: 0, time: 1}\n", "sleep.speed");
    refused(sleep + "gravity_ramp: {time: 1}\n", "does not go with gravity_ramp");
}
