#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace sluice {

//! One line of a ParaView collection (.pvd): a file that shows one part at one time.
struct CollectionEntry
{
    double time;       //!< [s]
    int part;          //!< parts of the same time are shown together
    std::string file;  //!< relative to the collection's folder, `/` between folders
};

//! Writes aside and renames, so that a killed run still opens. Throws Error (Exit::io).
void write_collection(std::filesystem::path const& path, std::span<CollectionEntry const> entries);

//! Reads a collection written by us (one DataSet per line). Throws Error (Exit::io) when it cannot be read.
std::vector<CollectionEntry> read_collection(std::filesystem::path const& path);

//! One collection that shows all `parts` together: the first is part 0, the second part 1, ... Entries are sorted by
//! time; ParaView shows a part that has no file at some time at its latest earlier one. File names become relative to
//! `merged`.
void merge_collections(std::span<std::filesystem::path const> parts, std::filesystem::path const& merged);

}  // namespace sluice
