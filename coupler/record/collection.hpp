#pragma once

#include <filesystem>
#include <optional>
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

//! Where the frames of one series are: `<directory>/<name>/<name>_000012.<ending>` per frame, `<directory>/<name>.pvd`
//! over all.
struct SeriesFiles
{
    std::filesystem::path directory;
    std::string name;
    std::string ending;  //!< "vtp", "vti"

    std::filesystem::path collection() const { return directory / (name + ".pvd"); }
    std::string frame(std::size_t number) const;  //!< relative to `directory`
};

//! What a series begins with: nothing; with `keep_until` [s] the frames of an earlier one up to that time. Writes the
//! collection, then removes the files of later frames. Throws Error (Exit::io), also when there are frames but no
//! whole collection that says their times.
std::vector<CollectionEntry> begin_series(SeriesFiles const& files, std::optional<double> keep_until);

//! One collection that shows all `parts` together: the first is part 0, the second part 1, ... Entries are sorted by
//! time; ParaView shows a part that has no file at some time at its latest earlier one. File names become relative to
//! `merged`.
void merge_collections(std::span<std::filesystem::path const> parts, std::filesystem::path const& merged);

}  // namespace sluice
