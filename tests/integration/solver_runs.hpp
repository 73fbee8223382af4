#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/shell.hpp"

//! Scenes of configs/ that are run by the command, and what they leave.
namespace solver_runs {

inline std::string const sluice_command = SLUICE_COMMAND;
inline std::filesystem::path const configs = CONFIGS, readback = READBACK;

inline shell::Result run(std::filesystem::path const& scene, std::filesystem::path const& out,
                         std::vector<std::string> const& settings)
{
    ::setenv("SLUICE_CACHE", PACKING_CACHE, 1);
    std::vector<std::string> words{sluice_command, "run", scene, "--out", out, "--no-report", "--quiet"};
    for (auto const& setting : settings) words.insert(words.end(), {"--set", setting});
    auto result = shell::run(words, out.string() + ".output", 250);
    if (result.exit != 0) MESSAGE(result.output);
    return result;
}

//! Sixty grains in a small tank: a second of computing.
inline std::vector<std::string> small(std::vector<std::string> more = {})
{
    for (auto const setting :
         {"time.end=0.004", "participants.grains.config.column.count=60", "participants.water.config.cell=2.0e-4",
          "participants.water.config.domain.size=[0.04, 0.02]", "output.interval=0.001"})
        more.emplace_back(setting);
    return more;
}

//! The columns of a CSV by their names; empty cells are NaN.
inline std::map<std::string, std::vector<double>> read_table(std::filesystem::path const& file)
{
    std::ifstream in(file);
    std::string line, cell;
    std::vector<std::string> names;
    std::map<std::string, std::vector<double>> table;
    for (std::getline(in, line); !line.empty();) {
        auto const comma = line.find(',');
        names.push_back(line.substr(0, comma));
        line = comma == std::string::npos ? "" : line.substr(comma + 1);
    }
    while (std::getline(in, line)) {
        std::stringstream cells(line);
        for (auto const& name : names) {
            cell.clear();
            std::getline(cells, cell, ',');
            table[name].push_back(cell.empty() ? std::nan("") : std::stod(cell));
        }
    }
    return table;
}

inline bool same_bytes(std::filesystem::path const& a, std::filesystem::path const& b)
{
    auto const x = shell::slurp(a), y = shell::slurp(b);
    return !x.empty() && x == y;
}

}  // namespace solver_runs
