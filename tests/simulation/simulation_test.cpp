// The protocol in a world with a virtual clock and a network that does what it likes: see README.md.
//   build/tests/simulation_test                          the tests
//   SLUICE_REPEATS=50 build/tests/simulation_test        a million schedules
//   SLUICE_SCHEDULE=1234 build/tests/simulation_test     what happens in one of them
#include <doctest/doctest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "tests/simulation/course.hpp"
#include "tests/support/repeats.hpp"
#include "tests/support/verification.hpp"

TEST_CASE("simulation: no schedule breaks a rule")
{
    if (char const* const number = std::getenv("SLUICE_SCHEDULE")) {
        std::printf("%s", simulation::describe_schedule(std::atoll(number)).c_str());
        return;
    }
    auto const start = std::chrono::steady_clock::now();
    auto const tally = simulation::run_schedules(0, sluice::test::repeats(20'000));
    double const seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%lld schedules, %lld of them with faults, in %lld somebody failed; %.0f a second\n",
                static_cast<long long>(tally.schedules), static_cast<long long>(tally.faulty),
                static_cast<long long>(tally.failed), static_cast<double>(tally.schedules) / seconds);
    if (std::getenv("SLUICE_VERIFY_JSONL"))
        CHECK(verification::report({.id = "simulation",
                                    .metric = "rules broken in " + std::to_string(tally.schedules) + " schedules [-]",
                                    .value = tally.broken.empty() ? 0.0 : 1.0,
                                    .reference = 0,
                                    .error = tally.broken.empty() ? 0.0 : 1.0,
                                    .mark = 0,
                                    .seconds = seconds}));
    CHECK(tally.broken == "");
}
