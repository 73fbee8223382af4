#include "coupler/record/manifest.hpp"

#include <doctest/doctest.h>

#include "coupler/base/error.hpp"

using namespace sluice;

namespace {

Manifest sample()
{
    return {.version = "0.1.0",
            .scene = 0xffff'ffff'ffff'fff0,
            .window = 40,
            .ticks = 40'000,
            .tick = 1e-5,
            .previous = 30,
            .members = {{"grains", 1'000'000, {1, 2}}, {"water:0", 0, {3, 4}}, {"water:10", 7, {5, 6}}}};
}

std::string refusal(std::string const& text)
{
    try {
        Manifest::parse(text, "m.json");
    } catch (Error const& error) {
        CHECK(error.exit() == Exit::io);
        return error.what();
    }
    return {};
}

//! The text with one part replaced and the checksum made right: what the rules behind the checksum see.
std::string resealed(std::string text, std::string const& from, std::string const& to)
{
    auto const at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    auto const covered = text.substr(0, text.rfind(",\n \"xxh3\""));
    return covered + ",\n \"xxh3\": \"" + hex(digest_of(std::as_bytes(std::span(covered)))) + "\"\n}\n";
}

}  // namespace

TEST_CASE("manifest: a text a person can read, and back")
{
    auto const text = sample().text();
    CHECK(
        text.starts_with("{\n \"format\": 1,\n \"sluice\": \"0.1.0\",\n \"scene\": \"fffffffffffffff0\",\n"
                         " \"window\": 40,\n \"ticks\": 40000,\n \"tick\": 1e-05,\n \"previous\": 30,\n"
                         " \"members\": [\n  {\n   \"member\": \"grains\",\n   \"bytes\": 1000000,\n"));
    CHECK(Manifest::parse(text, "m.json") == sample());
    auto first = sample();
    first.previous.reset();
    first.ticks = -5;
    first.tick = 0.1;
    CHECK(Manifest::parse(first.text(), "m.json") == first);
    CHECK(first.part_of("water:10")->bytes == 7);
    CHECK(first.part_of("water:1") == nullptr);
}

TEST_CASE("manifest: every cut and every flipped bit is refused")
{
    auto const whole = sample().text();
    for (std::size_t size = 0; size < whole.size(); ++size)
        REQUIRE(refusal(whole.substr(0, size)).starts_with("m.json: "));
    for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
        auto changed = whole;
        changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
        REQUIRE(refusal(changed).starts_with("m.json: "));
    }
    CHECK_FALSE(refusal(whole + "\n").empty());
}

TEST_CASE("manifest: behind a right checksum, only the one form is taken")
{
    auto const whole = sample().text();
    CHECK(refusal(resealed(whole, "40,", "40,")).empty());
    auto const refuses = [&](std::string const& from, std::string const& to, std::string const& why) {
        auto const text = refusal(resealed(whole, from, to));
        bool const said = text.find(why) != std::string::npos;
        if (!said) MESSAGE(from << " -> " << to << ": " << text);
        return said;
    };
    CHECK(refuses("\"format\": 1", "\"format\": 2", "its format is not 1"));
    CHECK(refuses("\"window\": 40", "\"window\": 40.0", "window is no integer"));
    CHECK(refuses("\"window\": 40", "\"window\": -1", "a window before the first"));
    CHECK(refuses("\"window\": 40", "\"window\": 18446744073709551615", "window is no integer"));
    CHECK(refuses("\"window\": 40", "\"window\": 30", "a previous window that is not before it"));
    CHECK(refuses("\"window\": 40", "\"win\": 40", "window is missing"));
    CHECK(refuses("\"tick\": 1e-05", "\"tick\": 0.0", "a tick that is not above 0 s"));
    CHECK(refuses("\"tick\": 1e-05", "\"tick\": 1e999", "not JSON"));
    CHECK(refuses("\"tick\": 1e-05", "\"tick\": 0.00001", "not in the form"));
    CHECK(refuses("\"sluice\": \"0.1.0\"", "\"sluice\": \"0 1\"", "the version of Sluice is no word"));
    CHECK(refuses("fffffffffffffff0", "FFFFFFFFFFFFFFF0", "scene is not 16"));
    CHECK(refuses("\"member\": \"grains\"", "\"member\": \"../grains\"", "a member whose name is none"));
    CHECK(refuses("\"member\": \"grains\"", "\"member\": \"xgrains\"", "members out of order"));
    CHECK(refuses("\"bytes\": 1000000", "\"bytes\": -1", "bytes is no length"));
    CHECK(refuses("\"bytes\": 1000000", "\"bytes\": 1000000, \"bytes\": 1000000", "not in the form"));
    CHECK(refuses("\"previous\": 30", "\"previous\": [[[[1]]]]", "nested too deeply"));
    CHECK(refuses("{\n", "{ \n", "not in the form"));
    CHECK(refuses("\"sluice\"", "\"more\": 1,\n \"sluice\"", "not in the form"));
}

TEST_CASE("manifest: a member is a name, perhaps with a rank, nothing that leads out of the folder")
{
    for (char const* good : {"grains", "water:0", "a-b_C9:12", "w:999999"}) CHECK(is_member(good));
    for (char const* bad :
         {"", ":1", "a:", "a:01", "a:-1", "a:1:2", "a:1234567", "a/b", "..", "a.b", "a b", "\xc3\xa4"})
        CHECK_FALSE(is_member(bad));
    CHECK(is_member(std::string(64, 'x')));
    CHECK_FALSE(is_member(std::string(65, 'x')));
}

TEST_CASE("manifest: a report travels as one line")
{
    CheckpointPart const part{"water:3", 18'000'000'000'000'000'000u, {0xabc, 0xdef}};
    CHECK(part.line() == "water:3 18000000000000000000 0000000000000abc0000000000000def");
    CHECK(CheckpointPart::parse(part.line()) == part);
    for (std::string const& wrong :
         {std::string(), std::string("a"), std::string("a 1"), std::string("a 1 12"), part.line() + "\n",
          " " + part.line(), std::string("a -1 0000000000000abc0000000000000def"),
          std::string("a 18446744073709551616 0000000000000abc0000000000000def"),
          std::string("a/b 1 0000000000000abc0000000000000def")})
        CHECK_FALSE(CheckpointPart::parse(wrong));
}

TEST_CASE("manifest: what must not be written is a bug, not a file")
{
    auto m = sample();
    std::swap(m.members[0], m.members[1]);
    CHECK_THROWS_WITH_AS(m.text(), "checkpoint of window 40: members out of order. This is a bug of Sluice.", Error);
    m = sample();
    m.members.clear();
    CHECK_THROWS_AS(m.text(), Error);
}
