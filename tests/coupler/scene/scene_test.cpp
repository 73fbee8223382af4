#include "coupler/scene/scene.hpp"

#include <doctest/doctest.h>

#include <fstream>

#include "coupler/base/error.hpp"
#include "tests/coupler/scene/mistakes.hpp"

using namespace sluice;
using namespace scene_text;

TEST_CASE("scene: a good one has no mistakes and reads as written")
{
    in_threads::Scratch scratch;
    auto const file = scratch.path() / "s.yaml";
    std::ofstream(file) << good;
    auto const loaded = load_scene(file, {"time.end=0.5", "couplings.1.predict=linear"});
    loaded.diagnostics->throw_if_any();
    CHECK(loaded.scene.end == 0.5);
    CHECK_FALSE(loaded.scene.window.has_value());
    CHECK(loaded.scene.gravity[1] == -9.81);
    CHECK(loaded.scene.edges.at(1).lag == 1);
    CHECK(loaded.scene.edges.at(1).predict == 1);
    CHECK(loaded.scene.edges.at(0).from == 0);
}

TEST_CASE("scene: the hash tells shared parts apart and ignores layout")
{
    auto hash = [](std::string const& text) {
        in_threads::Scratch scratch;
        std::ofstream(scratch.path() / "s.yaml") << text;
        return load_scene(scratch.path() / "s.yaml", {}).scene.hash;
    };
    CHECK(hash(good) == hash("# a comment\n" + with("end: 1.0", "end: 1")));
    CHECK(hash(good) != hash(with("end: 1.0", "end: 1.1")));
}

TEST_CASE("scene: place, path, what was seen, what is needed and the nearest key, for each kind of mistake")
{
    struct Case
    {
        std::string from, to, place, says;
    };
    Case const cases[] = {
        {"sluice: 1", "sluice: 2", "1:9: ", "sluice = 2 (must be >= 1 and <= 1)"},
        {"sluice: 1\n", "", "1:1: ", "sluice is missing"},
        {"end: 1.0", "end: -1", "2:13: ", "time.end = -1 s (must be > 0)"},
        {"end: 1.0", "end: 1e-5x", "2:13: ", "time.end = 1e-5x is not a number"},
        {"end: 1.0", "end: .nan", "2:13: ", "time.end = .nan is not a number"},
        {"end: 1.0", "edn: 1.0", "2:8: ", "time.edn is not a key (keys: end, pace, window). Did you mean end?"},
        {"window: auto", "window: 2", "2:26: ", "time.window = 2 is longer than the whole run"},
        {"time: ", "tiem: ", "2:1: ", "Did you mean time?"},
        {"[0, -9.81]", "[0, -9.81, 0]", "3:10: ", "gravity is a list of 3 (must be a list of 2 numbers, in m/s2)"},
        {"[0, -9.81]", "[0, down]", "3:14: ", "gravity[1] = down is not a number"},
        {"solver: dem", "solvr: dem", "5:12: ", "participants.grains.solvr is not a key"},
        {"solver: dem", "solver: [dem]", "5:", "participants.grains.solver = a list (must be a text)"},
        {"{solver: dem}", "dem", "5:11: ", "participants.grains = dem (must be a mapping of keys)"},
        {"to: water, data: k", "to: watr, data: k",
         "8:24: ", "there is no such participant: grains, water). Did you mean water?"},
        {"data: kinematics", "data: kinematic", "8:37: ", "Did you mean kinematics?"},
        {"lag: 1", "lag: 2", "9:", "couplings[1].lag = 2 (must be >= 0 and <= 1)"},
        {"lag: 1", "lag: 0.5", "9:", "couplings[1].lag = 0.5 (must be a whole number)"},
        {"lag: 1", "lagg: 1", "9:", "Did you mean lag?"},
        {"data: kinematics", "data: kinematics, predict: linear", "8:58: ", "has nothing to predict without a lag"},
        {"to: water, data: k", "to: grains, data: k", "8:24: ", "is the same participant as \"from\""},
        {"couplings:", "transport: zqm\ncouplings:", "7:12: ", "Did you mean zmq?"},
        {"couplings:", "address: tcp://0.0.0.0:5000\ncouplings:", "7:10: ",
         "To go beyond this host give participants a host"},
        {"gravity", "gravity: [0, 1]\ngravity", "4:1: ", "gravity is given twice (first in line 3)"},
        {"gravity", "frame: {rotating: {}}\ngravity", "3:9: ", "frame.rotating.axis is missing"},
    };
    for (Case const& c : cases) {
        CAPTURE(c.to);
        auto const found = mistakes(with(c.from, c.to));
        CHECK(has(found, c.says));
        CHECK(has("\n" + found, "\n" + c.place));
    }
}

TEST_CASE("scene: lag-0 edges in a circle are refused and the circle is named")
{
    auto const found = mistakes(with(", lag: 1", ""));
    CHECK(has(found, "7:1: couplings: the lag-0 edges form a circle"));
    CHECK(has(found, "grains -> water -> grains"));
}

TEST_CASE("scene: all mistakes at once, by line")
{
    auto text = with("end: 1.0", "end: -1");
    text.replace(text.find("lag: 1"), 6, "lagg: 1");
    text.replace(text.find("to: water"), 9, "to: sand ");
    auto const found = mistakes(text);
    auto const first = found.find("2:13"), second = found.find("8:"), third = found.find("9:");
    CHECK(first < second);
    CHECK(second < third);
    CHECK(third != std::string::npos);
}

TEST_CASE("scene: a mistake in --set is said to be there, and a path that is not in the scene is refused")
{
    CHECK(has(mistakes(good, {"time.end=-3"}), "--set: time.end = -3 s (must be > 0)"));
    CHECK(has(mistakes(good, {"couplings.1.lag=7"}), "--set: couplings[1].lag = 7"));
    CHECK(has(mistakes(good, {"tiem.end=3"}), "\"tiem\" is not in the scene"));
    CHECK(has(mistakes(good, {"couplings.5.lag=1"}), "\"5\" is not in the scene"));
    CHECK(has(mistakes(good, {"time.end"}), "no \"=\""));
}

TEST_CASE("scene: --set may name a block of keys that the file does not have")
{
    REQUIRE(std::string(good).find("checkpoint") == std::string::npos);
    auto const loaded = sluice::load_scene_text(good, "scene.yaml", {"checkpoint.windows=5", "checkpoint.keep=3"});
    CHECK(loaded.scene.checkpoint.windows == 5);
    CHECK(loaded.scene.checkpoint.keep == 3);
    CHECK(has(mistakes(good, {"chekpoint.windows=5"}), "chekpoint"));  // its reader knows no such key
}

TEST_CASE("scene: text that is no YAML, empty, several documents, too deep, a bomb of aliases: one message each")
{
    CHECK(has(mistakes("a: [1, 2\nb: 3\n"), "not YAML"));
    CHECK(has(mistakes(""), "not a mapping"));
    CHECK(has(mistakes("a: 1\n---\nb: 2\n"), "2:1: 2 YAML documents or more"));
    CHECK(has(mistakes(", 1"), "1:1: the text goes on after its YAML document"));  // endless for LoadAll()
    CHECK(has(mistakes("a: " + std::string(60, '[') + std::string(60, ']')), "nested deeper than 32"));
    std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
    for (int i = 1; i < 8; ++i) {
        auto const n = std::to_string(i), m = std::to_string(i - 1);
        bomb +=
            "a" + n + ": &a" + n + " [*a" + m + ", *a" + m + ", *a" + m + ", *a" + m + ", *a" + m + ", *a" + m + "]\n";
    }
    CHECK(has(mistakes(bomb), "more than 100000 nodes"));
    CHECK(has(mistakes(std::string(2 << 20, ' ')), "larger than 1 MB"));
}

TEST_CASE("nearest: finds typos and leaves strangers alone")
{
    CHECK(nearest("frction", {"friction", "density"}) == "friction");
    CHECK(nearest("fritcion", {"friction", "density"}) == "friction");
    CHECK_FALSE(nearest("colour", {"friction", "density"}).has_value());
}
