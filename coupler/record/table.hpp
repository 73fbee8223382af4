#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sluice {

//! A time series as CSV: a header with units such as `time [s],run_out [m]`, then one row per output. Numbers are the
//! shortest text that reads back as the same double. Every row reaches the system at once: a killed run keeps it.
class Table
{
 public:
    //! `headers`: the first is the time. Replaces an earlier file; with `keep_until` [s] goes on with it: rows up to
    //! that time stay, later ones and an unfinished one are cut off. Throws Error (Exit::io), also when the file that
    //! is to go on has other headers.
    Table(std::filesystem::path path, std::span<std::string const> headers,
          std::optional<double> keep_until = std::nullopt);
    Table(Table const&) = delete;
    Table& operator=(Table const&) = delete;
    ~Table();

    //! One number per header. On failure no half row stays behind. Throws Error (Exit::io).
    void append(std::span<double const> row);

 private:
    void open(int flags);
    void write(std::string const& line);
    std::filesystem::path path_;
    std::size_t columns_;
    int descriptor_ = -1;
    long long length_ = 0;  //!< bytes of complete rows
};

//! A participant's table on its way into the merged one.
struct TablePart
{
    std::string prefix;  //!< e.g. "grains": its column `run_out [m]` becomes `grains.run_out [m]`
    std::filesystem::path path;
};

//! One CSV over the union of all times; a cell is empty where a participant has no row at that time. A last line that a
//! killed run left unfinished is dropped. Throws Error (Exit::io).
void merge_tables(std::span<TablePart const> parts, std::filesystem::path const& merged);

}  // namespace sluice
