#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace sluice {

//! Whose results these are, and where they go.
struct RunNames
{
    std::filesystem::path directory;
    std::string participant;
    std::uint64_t scene_hash;
};

}  // namespace sluice
