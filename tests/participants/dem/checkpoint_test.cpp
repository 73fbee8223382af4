
#include <doctest/doctest.h>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/kept.hpp"
#include "tests/participants/dem/scenes.hpp"

using namespace unit;

namespace {

//! `good` but for one array of integers.
template <class Change>
sluice::State changed(sluice::State const& good, char const* name, Change change)
{
    auto state = sluice::State::decode(good.encode(), "state");
    auto const old = good.integers(name);
    std::vector<std::int64_t> values(old.begin(), old.end());
    change(values);
    sluice::State without = state.take("pairs");
    for (auto const array : {"first", "other", "image"})
        if (std::string("pairs/") + array != name) state.put(std::string("pairs/") + array, without.integers(array));
    for (auto const array : {"friction", "rolling", "sqrt_mass"})
        state.put(std::string("pairs/") + array, without.numbers(array));
    state.put(name, std::span<std::int64_t const>(values));
    return state;
}

}  // namespace

TEST_CASE("checkpoint: a restored solver continues bit for bit, also one that was made without grains")
{
    for (bool const ledger : {false, true}) {
        dem::Solver<2> a = box(ledger);
        for (int n = 0; n < 10000; ++n) a.step(step);
        auto const bytes = kept(a).encode();
        for (int n = 0; n < 10000; ++n) a.step(step);
        auto const state = sluice::State::decode(bytes, "state");
        for (bool const empty : {false, true}) {
            dem::Solver<2> b = empty ? dem::Solver<2>(a.setup(), {}) : box(ledger);
            b.restore(dem::kept_state<2>(state, b.setup(), 144));
            for (int n = 0; n < 10000; ++n) b.step(step);
            CHECK(kept(a) == kept(b));
        }
    }
}

TEST_CASE("checkpoint: a state of another scene, or with an index out of range, is refused")
{
    dem::Solver<2> const solver = box();
    auto const good = kept(solver);
    CHECK_NOTHROW(dem::kept_state<2>(good, solver.setup(), 144));
    CHECK_THROWS_AS(dem::kept_state<2>(good, solver.setup(), 143), sluice::Error);
    dem::Setup<2> other = solver.setup();
    other.walls.pop_back();
    CHECK_THROWS_AS(dem::kept_state<2>(good, other, 144), sluice::Error);
    dem::Setup<2> rolls = solver.setup();
    rolls.features.rolling = dem::Rolling::elastic_plastic;
    CHECK_THROWS_AS(dem::kept_state<2>(good, rolls, 144), sluice::Error);
    CHECK_THROWS_AS(dem::kept_state<2>({}, solver.setup(), 144), sluice::Error);
    CHECK_NOTHROW(dem::kept_state<2>(changed(good, "pairs/other", [](auto&) {}), solver.setup(), 144));
    for (std::int64_t const wrong : {std::int64_t{144}, std::int64_t{-1}, std::int64_t{1} << 32})
        CHECK_THROWS_AS(
            dem::kept_state<2>(changed(good, "pairs/other", [&](auto& v) { v.at(0) = wrong; }), solver.setup(), 144),
            sluice::Error);
    CHECK_THROWS_AS(
        dem::kept_state<2>(changed(good, "pairs/first", [](auto& v) { v.back() += 1; }), solver.setup(), 144),
        sluice::Error);
    CHECK_THROWS_AS(
        dem::kept_state<2>(changed(good, "pairs/first", [](auto& v) { v.pop_back(); }), solver.setup(), 144),
        sluice::Error);
}

TEST_CASE("checkpoint: it goes on with the grains of its file only, and says nothing without a file")
{
    dem::Config config;
    sluice::State none, state;
    dem::keep_source(config, none);
    CHECK(none.size() == 0);
    CHECK_NOTHROW(dem::require_source(config, none));
    config.grains_from = "grains.csv";
    config.grains_hash = 0xfedcba9876543210u;
    dem::keep_source(config, state);
    CHECK_NOTHROW(dem::require_source(config, state));
    CHECK_THROWS_AS(dem::require_source(config, none), sluice::Error);
    config.grains_hash ^= 1;
    CHECK_THROWS_WITH_AS(dem::require_source(config, state), doctest::Contains("grains.csv holds other grains"),
                         sluice::Error);
}
