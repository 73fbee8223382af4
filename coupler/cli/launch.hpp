#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coupler/cli/process.hpp"
#include "coupler/cli/progress.hpp"
#include "coupler/scene/scene.hpp"

namespace sluice {

//! How a run ended: 0 and no message, or the exit code and the one message that names the root cause.
struct RunEnding
{
    int exit = 0;
    std::string message;
    double wall_seconds = 0;
};

//! Starts every participant, watches them, ends all when one fails. No process of the run is left when it returns.
//! A participant that dies ends the run within 2 s. SIGINT and SIGTERM end it too (exit 130).
RunEnding launch(Scene const& scene, std::filesystem::path const& directory, Progress& progress);

}  // namespace sluice
