#pragma once

#include <filesystem>

#include "coupler/scene/reader.hpp"

namespace sluice {

//! A file's path as a scene has it: it counts from the scene's.
inline std::filesystem::path beside_scene(Reader const& reader, std::filesystem::path const& file)
{
    return file.is_absolute() ? file : std::filesystem::path(reader.diagnostics()->file).parent_path() / file;
}

}  // namespace sluice
