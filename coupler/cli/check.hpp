#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coupler/scene/scene.hpp"

namespace sluice {

//! What the user said about a scene on the command line.
struct SceneChoice
{
    std::filesystem::path scene;
    std::vector<std::string> overrides;  //!< path=value
};

//! The command that starts a participant, without `--as` and what follows; its first word is a path if it was found.
std::vector<std::string> program_of(ParticipantSpec const& spec);

//! Reads the scene and lets every participant check its own block. Throws one Error (exit 2) with all mistakes by line.
//! Returns the scene and what the solvers have to say about it, a text per participant.
struct CheckedScene
{
    LoadedScene loaded;
    std::vector<std::string> remarks;
    std::optional<double> window;  //!< s: what a run would take, as far as its solvers say what they propose
};
CheckedScene check_scene(SceneChoice const& choice);

}  // namespace sluice
