#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace sluice {

//! What a written file must outlive. A killed process needs the rename alone (0.1 ms); a power loss needs the data and
//! the folder synced as well (6 to 12 ms for 1 MB).
enum class Survive
{
    kill,
    power_loss
};

//! Writes `bytes` to `path` aside (`<path>.partial`), then renames: a reader sees the old file or the new, never half.
//! Missing folders are made. Throws Error (Exit::io) with the system's reason, and leaves no partial file behind.
void write_atomically(std::filesystem::path const& path, std::span<std::byte const> bytes,
                      Survive survive = Survive::kill);
//! The same for bytes in pieces, one after the other.
void write_atomically(std::filesystem::path const& path, std::span<std::span<std::byte const> const> pieces,
                      Survive survive = Survive::kill);
void write_atomically(std::filesystem::path const& path, std::string_view text, Survive survive = Survive::kill);

//! The whole file. Throws Error (Exit::io) with the system's reason.
std::string read_file(std::filesystem::path const& path);
//! The same for a plain file of `most` bytes or fewer; looked at before anything is allocated.
std::string read_file(std::filesystem::path const& path, std::uint64_t most);

//! Makes the folder and its parents; throws Error (Exit::io).
void make_folder(std::filesystem::path const& folder);

//! Brings a folder's list of files to the disk; throws Error (Exit::io).
void sync_folder(std::filesystem::path const& folder);

}  // namespace sluice
