#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "coupler/cli/launch.hpp"

namespace sluice {

//! summary.json: the run, and one entry per participant from what its processes left in RUN/.sluice. What a participant
//! did not write is left out, `exit` is then null.
//!
//! Several processes (ranks) of a participant: the times are those of the rank that computed longest, bytes_sent is the
//! sum, exit the largest, facts are those of rank 0; `ranks` lists what each said that said anything.
//! A run that was resumed: seconds and bytes are summed over its parts (a part that was killed has left none), windows
//! count from the beginning. `parts`: wall time of each part that ended by itself, this one included [s].
nlohmann::ordered_json summarise(Scene const& scene, std::filesystem::path const& directory, RunEnding const& ending,
                                 std::vector<double> const& parts);

}  // namespace sluice
