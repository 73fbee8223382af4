#pragma once

#include <doctest/doctest.h>

#include <fstream>
#include <string>
#include <vector>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"
#include "tests/support/run_in_threads.hpp"

//! Scenes as texts, changed in one place, and what the validator says about them.
namespace scene_text {

//! All mistakes of a scene text as `line:column: text` lines, file name removed; empty if there are none.
inline std::string mistakes(std::string const& text, std::vector<std::string> const& overrides = {})
{
    in_threads::Scratch scratch;
    auto const file = scratch.path() / "s.yaml";
    std::ofstream(file) << text;
    try {
        sluice::load_scene(file, overrides).diagnostics->throw_if_any();
    } catch (sluice::Error const& e) {
        CHECK(e.exit() == sluice::Exit::config);
        std::string all = e.what();
        for (auto at = all.find(file.string() + ":"); at != std::string::npos; at = all.find(file.string() + ":"))
            all.erase(at, file.string().size() + 1);
        return all;
    }
    return {};
}

inline std::string const good = R"(sluice: 1
time: {end: 1.0, window: auto}
gravity: [0, -9.81]
participants:
  grains: {solver: dem}
  water: {solver: lbm}
couplings:
  - {from: grains, to: water, data: kinematics}
  - {from: water, to: grains, data: load, lag: 1}
)";

inline std::string with(std::string const& from, std::string const& to)
{
    auto text = good;
    auto const at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

inline bool has(std::string const& text, std::string const& part)
{
    bool const found = text.find(part) != std::string::npos;
    if (!found) MESSAGE("not in: " << text);
    return found;
}

}  // namespace scene_text
