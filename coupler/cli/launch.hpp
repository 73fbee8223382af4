#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coupler/cli/progress.hpp"
#include "coupler/cli/signals.hpp"
#include "coupler/cli/start.hpp"
#include "coupler/scene/scene.hpp"

namespace sluice {

//! How a run ended: 0 and no message, or the exit code and a message whose first line names the root cause.
struct RunEnding
{
    int exit = 0;
    std::string message;
    double wall_seconds = 0;
    int restarts = 0;  //!< of participants that died
};

//! Starts every participant, watches them, ends all when one fails. No process of the run is left when it returns.
//!
//! - A participant that dies ends the run within 2 s; with on-death: restart it is started again instead.
//! - SIGINT, SIGTERM, or SIGTERM to one participant: the run stops before its next window, with a checkpoint if all
//!   solvers keep their state (exit 75), else without (exit 130). A second signal, or 15 s: it is ended (exit 130).
//! - SIGUSR1: a checkpoint before the next window.
//!
//! `resume`: how the user goes on with a stopped run, for the message. `signals`: one that came before counts, too.
RunEnding launch(Scene const& scene, std::filesystem::path const& directory, Progress& progress, Begin begin,
                 std::string const& resume, UserSignals& signals);

}  // namespace sluice
