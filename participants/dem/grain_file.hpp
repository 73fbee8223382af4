#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/files/lines.hpp"

namespace dem {

using files::Lines, files::take_word, files::trimmed;

//! The grains of a file, in its order: a CSV with a header, a text dump of LAMMPS or LIGGGHTS (the frame of this
//! timestep, else the last), or a data file of LAMMPS with `Atoms # sphere`. Which of them, its content says. Grains
//! without an id get their place in the file. Throws sluice::Error (config) that begins with `file:line:`.
std::vector<GrainConfig> read_grain_file(std::filesystem::path const& file, int dimension,
                                         std::optional<std::int64_t> timestep, std::vector<std::string>& warnings);

//! Grains and where in the file they stand.
struct FileGrains
{
    std::vector<GrainConfig> grains;
    std::vector<std::int64_t> line;
    bool several_types = false;
};
FileGrains read_csv(Lines lines, int dimension);
FileGrains read_dump(Lines lines, int dimension, std::optional<std::int64_t> timestep);
FileGrains read_data(Lines lines, int dimension);

//! Orders grains so that neighbours in space are neighbours in memory, whatever their order was: by cells, ties by
//! place and id.
void sort_in_space(std::vector<GrainConfig>& grains);

}  // namespace dem
