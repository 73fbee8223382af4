#pragma once

#include <cstdint>
#include <filesystem>

namespace sluice {

//! Makes sure that `path` can grow by `bytes` before anybody writes: the blocks are allocated beyond the file's end
//! (its size stays), so that no other process can take them; where the file system cannot do that, the free space is
//! compared. Throws Error (Exit::io) that says how much is needed and how much is free; the file is then untouched.
void reserve_space(std::filesystem::path const& path, std::uint64_t bytes);

//! Gives back what reserve_space() allocated beyond the end. Never fails: what is left is only unused space.
void release_reserve(std::filesystem::path const& path) noexcept;

}  // namespace sluice
