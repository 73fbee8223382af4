// The schema is made of what the code asks; these tests keep the words about it and the probing scenes whole.

#include "coupler/cli/schema.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/cli/explain.hpp"
#include "coupler/scene/probe.hpp"
#include "coupler/scene/scene.hpp"
#include "coupler/scene/units.hpp"

using namespace sluice;

TEST_CASE("schema: every key has a meaning, and every meaning a key")
{
    std::set<std::string> keys, words;
    for (auto const& key : scene_keys()) keys.insert(key.path);
    for (auto const& [pattern, meaning] : meanings()) words.insert(pattern);
    CHECK(keys.size() > 50);
    CHECK(keys == words);
}

TEST_CASE("schema: the rules stand at mappings or keys that exist")
{
    std::set<std::string> keys{"", "participants.*", "data.*", "couplings[]"};
    for (auto const& key : scene_keys()) keys.insert(key.path);
    for (auto const& [pattern, rule] : rules()) {
        CAPTURE(pattern);
        CHECK(keys.contains(pattern));
    }
}

//! A reader asks for a key by a literal: any literal of scene/*.cpp that a getter gets must be in the schema.
TEST_CASE("schema: no key in the code of the scene is missing")
{
    std::set<std::string> keys{"config"};
    for (auto const& key : scene_keys()) keys.insert(key.path.substr(key.path.rfind('.') + 1));
    int found = 0;
    for (char const* file : {"scene.cpp", "network.cpp", "implicit.cpp", "units.cpp"}) {
        std::ifstream in(std::string(SOURCE_DIRECTORY) + "/coupler/scene/" + file);
        std::stringstream text;
        text << in.rdbuf();
        auto const code = text.str();
        for (char const* getter :
             {".number(\"",     ".number_or(\"",   ".number_if(\"", ".number_unless(\"", ".integer(\"",
              ".integer_or(\"", ".integer_if(\"",  ".text(\"",      ".text_or(\"",       ".text_if(\"",
              ".word(\"",       ".word_or(\"",     ".word_if(\"",   ".flag_or(\"",       ".choice(\"",
              ".choice_or(\"",  ".words(\"",       ".name_of(\"",   ".name_of_if(\"",    ".names_of(\"",
              ".numbers(\"",    ".numbers_or(\"",  ".child(\"",     ".child_if(\"",      ".child_or_empty(\"",
              ".children(\"",   ".children_if(\"", ".list(\"",      ".subtree(\"",       ">text(\"",
              ">numbers(\""}) {
            std::string const start = getter;
            for (auto at = code.find(start); at != code.npos; at = code.find(start, at + 1)) {
                auto const first = at + start.size();
                auto const key = code.substr(first, code.find('"', first) - first);
                CAPTURE(key);
                CHECK(keys.contains(key));
                ++found;
            }
        }
    }
    CHECK(found > 50);
}

TEST_CASE("schema: required, bounds, choices and defaults are those of the code")
{
    auto const schema = scene_schema();
    CHECK(schema["required"] == nlohmann::ordered_json{"sluice", "participants", "time"});
    auto const& coupling = schema["properties"]["couplings"]["items"];
    CHECK(coupling["required"] == nlohmann::ordered_json{"from", "to", "data"});
    CHECK(coupling["additionalProperties"] == false);
    CHECK(coupling["properties"]["lag"]["maximum"] == 1);
    CHECK(coupling["properties"]["lag"]["default"] == 0);
    CHECK(coupling["properties"]["predict"]["enum"] == nlohmann::ordered_json{"none", "linear", "quadratic"});
    CHECK(schema["properties"]["timeouts"]["properties"]["silence"]["minimum"] == 0.5);
    CHECK_FALSE(schema["properties"]["title"].contains("default"));  // the file's name
    CHECK_FALSE(schema["properties"]["participants"]["additionalProperties"]["properties"]["config"].contains(
        "additionalProperties"));
}

TEST_CASE("units: products with powers are read, others are not, and what is not SI is known as such")
{
    for (char const* unit : {"1", "-", "m", "m/s", "N m", "kg m2/s", "W/m2/K", "m s^-1", "1/s", "N*m", "rad/s", "m3"}) {
        CAPTURE(unit);
        CHECK(check_unit(unit).known);
        CHECK(check_unit(unit).odd.empty());
    }
    for (char const* unit : {"mm", "g/cm3", "kPa", "km/h", "%", "deg"}) {
        CAPTURE(unit);
        CHECK(check_unit(unit).known);
        CHECK_FALSE(check_unit(unit).odd.empty());
    }
    for (char const* unit : {"", "furlong", "m//s", "m/", "/s", "m s ", "metre", "m10", "1/", "N-m", "M"}) {
        CAPTURE(unit);
        CHECK_FALSE(check_unit(unit).known);
    }
    CHECK(check_unit("g/cm3").instead == "kg");
}

TEST_CASE("explain: every exit code has its text, and no word stands there twice")
{
    std::set<int> codes;
    std::set<std::string> words;
    for (auto const& e : explanations()) {
        if (e.code >= 0) codes.insert(e.code);
        CHECK(words.emplace(e.word).second);
        CHECK(e.more.size() > 40);
    }
    CHECK(codes == std::set<int>{0, 2, 3, 4, 5, 6, 7, 8, 70, 75, 130});
    CHECK(codes.contains(static_cast<int>(Exit::stopped)));
}
