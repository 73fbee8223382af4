#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "participants/dem/packing.hpp"

namespace dem {

//! Name of a packing's file, "packing-<hash of everything it depends on>.bin".
std::string packing_file_name(Config const& config);

//! Writes aside, then renames. Throws sluice::Error (io) if that fails.
template <int D>
void write_packing(Packing<D> const& packing, std::filesystem::path const& file);

//! Nothing if there is no such file; also nothing, with `damage` set, if it is cut short or its hash is wrong.
template <int D>
std::optional<Packing<D>> load_packing(std::filesystem::path const& file, std::string& damage);

}  // namespace dem
