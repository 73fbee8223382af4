#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace sluice {

enum class Pack
{
    plain,
    deflate
};  //!< deflate (with byte shuffle, by chunks of whole rows) pays for lattice arrays

//! One array of a step.
struct ArchiveDataset
{
    std::string_view name;  //!< e.g. "velocity"
    std::string_view unit;  //!< e.g. "m/s", kept as the attribute `unit`; "" has none
    std::variant<std::span<double const>, std::span<float const>, std::span<std::int64_t const>> values;
    std::vector<std::size_t> shape;  //!< e.g. {N, 2}, or {ny, nx, 2}: the last index is the fastest
    Pack pack = Pack::plain;
};

//! A fact about the file: scene hash, version, origin, spacing, ...
struct ArchiveFact
{
    std::string name;
    std::variant<std::string, double, std::vector<double>> value;  //!< text: fixed length, UTF-8
};

//! One HDF5 file per participant: a group `/steps/000012` with the attribute `time` [s] per output, datasets in it.
//! Flushed after every step: a killed run keeps what was appended. No clock times inside: two equal runs write equal
//! bytes. Each step's space is reserved first, so that a full disk ends in one Error (Exit::io) and a file that still
//! opens.
class Archive
{
 public:
    //! Replaces an earlier file; with `keep_until` [s] goes on with it, without the steps after that time, also if it
    //! was never closed. It is copied into a new file that then takes its place: what a kill left torn is not written
    //! to, and a kill now leaves it as it was. Throws Error (Exit::io).
    explicit Archive(std::filesystem::path path, std::span<ArchiveFact const> facts = {},
                     std::optional<double> keep_until = std::nullopt);
    Archive(Archive const&) = delete;
    Archive& operator=(Archive const&) = delete;
    ~Archive();

    //! Adds the step of `time` [s] and flushes. Throws Error (Exit::io); after a failure of HDF5 itself (not of the
    //! reservation) the archive takes no more steps.
    void append(double time, std::span<ArchiveDataset const> datasets);

    //! Closes the file and reports what goes wrong then; the destructor closes silently. Throws Error (Exit::io).
    void close();

    std::size_t steps() const noexcept { return steps_; }
    //! Right after the constructor: empty, or why the archive goes on with fewer than `expected` steps.
    std::string remark(std::size_t expected) const;

 private:
    void create(std::filesystem::path const& path, std::span<ArchiveFact const> facts);
    void take_steps_of(std::filesystem::path const& earlier, double keep_until);
    void write_step(double time, std::span<ArchiveDataset const> datasets);
    std::filesystem::path path_;
    std::int64_t file_ = -1;  //!< HDF5 id
    std::size_t steps_ = 0;
    std::string damage_;   //!< of the earlier file, and where it was put
    bool broken_ = false;  //!< HDF5 failed: closing the file would write again and may crash
};

//! A link of the joint archive: `name` shows the root of `file` (relative to the joint archive's folder).
struct ArchiveLink
{
    std::string name;
    std::filesystem::path file;
};

//! Writes `path` (archive.h5) with one external link per participant, aside and renamed. Throws Error (Exit::io).
void link_archives(std::filesystem::path const& path, std::span<ArchiveLink const> links);

}  // namespace sluice
