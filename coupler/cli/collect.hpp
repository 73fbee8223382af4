#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coupler/cli/launch.hpp"

namespace sluice {

//! Puts together what the participants left in a run's directory: summary.json, series.csv, one .pvd for all,
//! archive.h5 (links), trace.json (of the last part of a resumed run). What a participant did not write is left out.
//! `parts`: see summarise(). Returns the summary.
nlohmann::ordered_json collect(Scene const& scene, std::filesystem::path const& directory, RunEnding const& ending,
                               std::vector<double> const& parts);

//! The end-of-run table: compute / wait / exchange seconds and shares per participant.
std::string time_table(nlohmann::ordered_json const& summary);

//! Makes report.html from one run, or a comparison of several. Returns false and says why if Python lacks a package.
bool make_report(std::vector<std::filesystem::path> const& runs, std::filesystem::path const& page,
                 std::string& why_not);

}  // namespace sluice
