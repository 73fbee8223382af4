#include "participants/dem/checkpoint.hpp"

#include <doctest/doctest.h>

#include "coupler/base/error.hpp"
#include "tests/participants/dem/scenes.hpp"

using namespace unit;

TEST_CASE("checkpoint: a restored solver continues bit for bit")
{
    dem::Solver a = box(true);
    for (int n = 0; n < 10000; ++n) a.step(step);
    auto const bytes = dem::to_bytes(a.state());
    for (int n = 0; n < 10000; ++n) a.step(step);
    dem::Solver b = box(true);
    b.restore(dem::state_from_bytes(bytes, 144, 3));
    for (int n = 0; n < 10000; ++n) b.step(step);
    CHECK(dem::to_bytes(a.state()) == dem::to_bytes(b.state()));
}

TEST_CASE("checkpoint: bytes of another scene, cut short or with an index out of range are refused")
{
    auto const bytes = dem::to_bytes(box().state());
    CHECK_THROWS_AS(dem::state_from_bytes(bytes, 143, 3), sluice::Error);
    CHECK_THROWS_AS(dem::state_from_bytes(bytes, 144, 2), sluice::Error);
    CHECK_THROWS_AS(dem::state_from_bytes({}, 144, 3), sluice::Error);
    for (std::size_t size = 0; size < bytes.size(); size += 97)
        CHECK_THROWS_AS(dem::state_from_bytes(std::span(bytes).first(size), 144, 3), sluice::Error);
    dem::State state = box().state();
    state.pairs.other.at(0) = 4000;
    CHECK_THROWS_AS(dem::state_from_bytes(dem::to_bytes(state), 144, 3), sluice::Error);
}
