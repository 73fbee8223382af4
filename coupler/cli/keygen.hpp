#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sluice {

//! Makes the keys of a run whose participants are on several hosts: NAME.public and NAME.secret in `directory` (0700,
//! made if needed) for every name, or for every participant of the one scene named. Nothing is overwritten; secrets are
//! not printed. Returns the exit code. Throws Error (exit 2, 7 or 8).
int keygen(std::filesystem::path const& directory, std::vector<std::string> const& scene_or_names);

}  // namespace sluice
