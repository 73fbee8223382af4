#include "coupler/base/state.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "coupler/base/error.hpp"
#include "tests/support/repeats.hpp"

using namespace sluice;

namespace {

using Bytes = std::vector<std::byte>;

//! What an Error says, with its exit code checked; empty: none was thrown.
template <class Action>
std::string complaint(Exit exit, Action&& action)
{
    try {
        action();
    } catch (Error const& error) {
        CHECK(error.exit() == exit);
        return error.what();
    }
    return {};
}

std::string refusal(Bytes const& encoded)
{
    return complaint(Exit::io, [&] { State::decode(encoded, "part"); });
}

template <class Random>
State random_state(Random& random)
{
    auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    State state;
    for (std::size_t i = below(12); i > 0; --i) {
        std::string name(1 + below(below(4) == 0 ? longest_state_name : 12), 'x');
        for (char& c : name) c = "abcXYZ019_-.:/"[below(14)];
        if (state.has(name)) continue;
        std::size_t const count = below(3) == 0 ? 0 : below(300);
        std::vector<std::int64_t> integers(count);
        for (auto& x : integers) x = static_cast<std::int64_t>(random());
        switch (below(3)) {
            case 0: {
                std::vector<double> numbers(count);
                for (std::size_t k = 0; k < count; ++k) numbers[k] = std::bit_cast<double>(integers[k]);  // NaN too
                state.put(name, numbers);
                break;
            }
            case 1:
                state.put(name, integers);
                break;
            default:
                state.put(name, std::as_bytes(std::span(integers)).first(count));
        }
    }
    return state;
}

}  // namespace

TEST_CASE("state: what was put is there, bit for bit, before and after encoding")
{
    State state;
    state.put("position", std::vector<double>{1.5, -0.0, std::nan("7"), 3e300});
    state.put("id", std::vector<std::int64_t>{-1, std::numeric_limits<std::int64_t>::max()});
    state.put("flags", Bytes(100, std::byte{0x5a}));
    state.put("empty", std::vector<double>{});
    state.put_number("time", 0.1);
    state.put_integer("step", 123);
    state.put_text("generator", "12 34");
    State const back = State::decode(state.encode(), "part");
    CHECK(back == state);
    CHECK(back.size() == 7);
    CHECK(back.numbers("position").size() == 4);
    CHECK(std::signbit(back.numbers("position")[1]));
    CHECK(std::bit_cast<std::uint64_t>(back.numbers("position")[2]) == std::bit_cast<std::uint64_t>(std::nan("7")));
    CHECK(back.integers("id", 2)[1] == std::numeric_limits<std::int64_t>::max());
    CHECK(back.bytes("flags").size() == 100);
    CHECK(back.numbers("empty", 0).empty());
    CHECK(back.number("time") == 0.1);
    CHECK(back.integer("step") == 123);
    CHECK(back.text("generator") == "12 34");
    CHECK_FALSE(back.has("velocity"));
}

TEST_CASE("state: one content has one encoding, whatever the order it was put in")
{
    State one, other;
    one.put_number("a", 1), one.put_integer("b", 2), one.put_text("a/b", "x");
    other.put_text("a/b", "x"), other.put_integer("b", 2), other.put_number("a", 1);
    CHECK(one.encode() == other.encode());
    CHECK(one.encode().size() % 64 == 0);
    State changed;
    changed.put_number("a", 1), changed.put_integer("b", 3), changed.put_text("a/b", "x");
    CHECK(changed.encode() != one.encode());
    CHECK_FALSE(changed == one);
    State minus, plus;
    minus.put_number("x", -0.0), plus.put_number("x", 0.0);
    CHECK_FALSE(minus == plus);
}

TEST_CASE("state: random contents come back, and only one encoding of them is taken")
{
    std::mt19937_64 random(20240501);
    for (int repeat = test::repeats(2000); repeat > 0; --repeat) {
        State const state = random_state(random);
        Bytes const encoded = state.encode();
        State const back = State::decode(encoded, "part");
        REQUIRE(back == state);
        REQUIRE(back.encode() == encoded);
    }
}

TEST_CASE("state: every cut and every flipped bit is refused, and so is a longer one")
{
    State state;
    state.put("position", std::vector<double>{1, 2, 3});
    state.put("id", std::vector<std::int64_t>{4, 5});
    state.put_text("note", "text");
    Bytes const whole = state.encode();
    CHECK(refusal(whole).empty());
    for (std::size_t size = 0; size < whole.size(); ++size)
        REQUIRE_FALSE(refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))).empty());
    for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
        Bytes changed = whole;
        changed[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
        REQUIRE(refusal(changed).starts_with("part: "));
    }
    Bytes longer = whole;
    longer.resize(whole.size() + 64);
    CHECK(refusal(longer) ==
          "part: its length is not the one it states (needs a state as Sluice writes it). Use another checkpoint.");
}

TEST_CASE("state: reading what is not there names the array and what is needed")
{
    State state;
    state.put_number("time", 1);
    state.put("id", std::vector<std::int64_t>{1, 2});
    State const back = State::decode(state.encode(), "checkpoints/40/grains.part");
    std::string const other = "Was it written by another version of the solver?";
    CHECK(complaint(Exit::io, [&] { back.numbers("velocity"); }) ==
          "checkpoints/40/grains.part: \"velocity\" is not in it (needs numbers of that name). " + other);
    CHECK(complaint(Exit::io, [&] { back.integers("time"); }) ==
          "checkpoints/40/grains.part: \"time\" holds numbers (needs integers). " + other);
    CHECK(complaint(Exit::io, [&] { back.text("id"); }) ==
          "checkpoints/40/grains.part: \"id\" holds integers (needs bytes). " + other);
    CHECK(complaint(Exit::io, [&] { back.integer("id"); }) ==
          "checkpoints/40/grains.part: \"id\" has 2 values (needs 1). Does it belong to another scene?");
    CHECK(complaint(Exit::io, [&] { back.integers("id", 3); }).find("has 2 values (needs 3)") != std::string::npos);
}

TEST_CASE("state: a name that is none or taken is the solver's bug")
{
    State state;
    state.put_number("a", 1);
    CHECK(complaint(Exit::internal, [&] { state.put_number("a", 2); }).find("put twice") != std::string::npos);
    CHECK(state.number("a") == 1);
    for (std::string const& name : {std::string(), std::string("a b"), std::string("a\0b", 3), std::string(201, 'x')})
        CHECK(complaint(Exit::internal, [&] { state.put_number(name, 1); }).find("no name") != std::string::npos);
    state.put_number(std::string(200, 'x'), 1);
    CHECK(State::decode(state.encode(), "part") == state);
}

TEST_CASE("state: states nest by prefix and come out again")
{
    State inner, outer;
    inner.put_number("time", 1);
    inner.put("id", std::vector<std::int64_t>{1, 2});
    outer.put_number("time", 2);
    outer.put_number("solver-time", 3);
    outer.nest("solver", inner);
    CHECK(outer.number("solver/time") == 1);
    CHECK(outer.size() == 4);
    CHECK(complaint(Exit::internal, [&] { outer.nest("solver", inner); }).find("is taken") != std::string::npos);
    State back = State::decode(outer.encode(), "part");
    State const taken = back.take("solver");
    CHECK(taken == inner);
    CHECK(back.size() == 2);
    CHECK(complaint(Exit::io, [&] { taken.number("x"); }).starts_with("part, solver: \"x\" is not in it"));
}
