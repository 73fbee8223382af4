#pragma once

#include <filesystem>

#include "coupler/scene/scene.hpp"

namespace sluice {

//! Asks every other host of the scene, all at once and through its `remote` words, whether a participant can be started
//! there as here: the current directory, the scene, the program, and the directory of the run (not looked at if empty;
//! else it exists) must be there under the same paths. Throws one Error (exit 7) that lists what is not so, by
//! participant; a host that does not answer within timeouts.connect counts as one that cannot be reached.
void require_hosts(Scene const& scene, std::filesystem::path const& directory);

}  // namespace sluice
