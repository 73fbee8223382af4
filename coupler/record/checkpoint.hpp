#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coupler/base/state.hpp"
#include "coupler/record/manifest.hpp"

namespace sluice {

//! The newest checkpoint that can be trusted, and what was passed over on the way to it.
struct FoundCheckpoint
{
    std::optional<Manifest> manifest;  //!< absent: there is none
    std::string note;                  //!< empty: nothing was passed over. Else which windows, and why
};

//! The checkpoints of one run: RUN/checkpoints/<window>/<member>.part and manifest.json. In two phases: every process
//! writes its part and reports it; then the coordinator commits. A checkpoint counts once its manifest is there, and a
//! process or a machine that dies at any moment leaves the one before as it was.
//! Part and manifest outlive a power loss. Everything here throws Error (Exit::io) with the system's reason.
class CheckpointStore
{
 public:
    //! `directory`: RUN. `keep`: complete generations that commit() leaves, >= 1; while one is written there is one
    //! more.
    CheckpointStore(std::filesystem::path const& directory, int keep);

    //! Makes the folder, in every process before its first part.
    void prepare() const;

    //! Phase 1, in every process: this member's bytes of a window. Does not make a folder anew that was taken away.
    CheckpointPart write_part(std::int64_t window, std::string_view member, std::span<std::byte const> bytes) const;
    CheckpointPart write_part(std::int64_t window, std::string_view member, State const& state) const;  //!< no copy

    //! Phase 2, in the coordinator once it has all reports: writes the manifest (its `previous` is filled in here, its
    //! members are put in order) and then removes generations beyond `keep`, and older ones that were never complete.
    //! Throws, and nothing counts, if a part is not there as reported. Returns what could not be removed, if anything.
    std::string commit(Manifest manifest) const;

    //! Reads every part of the newest generation against its manifest, then of the one before, and so on.
    FoundCheckpoint newest() const;

    //! The manifest of one generation, for a process that was told which one to go on from; looks at no part.
    Manifest read_manifest(std::int64_t window) const;

    //! A part of a manifest's generation, if it is what the manifest says.
    std::vector<std::byte> read_part(Manifest const& manifest, std::string_view member) const;

    //! Removes what is newer than `window`, complete or not: what a resumed run will write again, or a phase 1 that
    //! failed.
    void discard_after(std::int64_t window) const;

    std::filesystem::path const& directory() const { return root_; }  //!< RUN/checkpoints
    std::filesystem::path part_file(std::int64_t window, std::string_view member) const;
    std::filesystem::path manifest_file(std::int64_t window) const;

 private:
    CheckpointPart write_pieces(std::int64_t window, std::string_view member,
                                std::span<std::span<std::byte const> const> pieces) const;
    std::filesystem::path folder(std::int64_t window) const;
    std::vector<std::int64_t> windows() const;  //!< newest first, complete or not
    bool looks_complete(std::int64_t window) const;
    void remove(std::int64_t window) const;
    std::string prune(std::int64_t newest) const;

    std::filesystem::path root_;
    int keep_;
};

}  // namespace sluice
