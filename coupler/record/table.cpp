#include "coupler/record/table.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <map>
#include <string_view>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/descriptor.hpp"

namespace sluice {
namespace {

using Cells = std::vector<std::string>;

std::string line_of(std::span<std::string const> cells)
{
    std::string line;
    for (auto const& cell : cells) line += (&cell == cells.data() ? "" : ",") + cell;
    return line + '\n';
}

Cells split(std::string_view line)
{
    Cells cells;
    for (;;) {
        std::size_t const comma = line.find(',');
        cells.emplace_back(line.substr(0, comma));
        if (comma == std::string_view::npos) return cells;
        line.remove_prefix(comma + 1);
    }
}

//! Complete lines only: what stands after the last line break is an unfinished row.
std::vector<Cells> read_rows(std::filesystem::path const& path)
{
    std::string const text = read_file(path);
    std::vector<Cells> rows;
    std::size_t start = 0;
    for (std::size_t end; (end = text.find('\n', start)) != std::string::npos; start = end + 1)
        rows.push_back(split(std::string_view(text).substr(start, end - start)));
    require(!rows.empty(), [&] {
        return Error(
            fmt::format("{}: no header line (needs `time [s],...`). Did the participant stop at once?", path.string()),
            Exit::io);
    });
    return rows;
}

double parse_time(std::string const& cell, std::filesystem::path const& path, std::size_t line)
{
    double time = 0.0;
    auto const [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), time);
    require(code == std::errc{} && end == cell.data() + cell.size(), [&] {
        return Error(fmt::format("{}:{}: time `{}` is not a number.", path.string(), line, cell), Exit::io);
    });
    return time;
}

//! How many bytes of a table's text hold the header and the rows up to `time` [s]. Rows come in the order of time.
std::size_t length_until(std::string_view text, double time, std::filesystem::path const& path)
{
    std::size_t length = text.find('\n') + 1;
    for (std::size_t line = 2;; ++line) {
        std::size_t const end = text.find('\n', length);
        if (end == std::string_view::npos) return length;
        auto const cell = text.substr(length, std::min(end, text.find(',', length)) - length);
        if (parse_time(std::string(cell), path, line) > time) return length;
        length = end + 1;
    }
}

//! Puts the rows of one participant at `first` of the merged rows.
void place(std::vector<Cells> const& rows, std::size_t first, std::size_t width, std::filesystem::path const& path,
           std::map<double, Cells>& merged)
{
    for (std::size_t i = 1; i < rows.size(); ++i) {
        require(rows[i].size() == rows[0].size(), [&] {
            return Error(fmt::format("{}:{}: {} cells (the header has {}).", path.string(), i + 1, rows[i].size(),
                                     rows[0].size()),
                         Exit::io);
        });
        Cells& row = merged.try_emplace(parse_time(rows[i][0], path, i + 1), width).first->second;
        row[0] = rows[i][0];
        for (std::size_t k = 1; k < rows[i].size(); ++k) row[first + k - 1] = rows[i][k];
    }
}

}  // namespace

Table::Table(std::filesystem::path path, std::span<std::string const> headers, std::optional<double> keep_until)
    : path_(std::move(path)), columns_(headers.size())
{
    for (auto const& header : headers)
        require(header.find_first_of(",\n\"") == std::string::npos, [&] {
            return Error(
                fmt::format("{}: the header `{}` holds a comma, a quote or a line break (CSV cells must "
                            "not). Rename the column.",
                            path_.string(), header));
        });
    make_folder(path_.parent_path());
    std::string const head = line_of(headers);
    std::string const before = keep_until && std::filesystem::exists(path_) ? read_file(path_) : "";
    if (before.find('\n') == std::string::npos) {  // none, or a run that was killed while it began
        open(O_TRUNC);
        write(head);
        return;
    }
    require(before.starts_with(head), [&] {
        return Error(fmt::format("{}: begins with `{}` (this run's rows have `{}`). Put it elsewhere and resume again.",
                                 path_.string(), before.substr(0, before.find('\n')), head.substr(0, head.size() - 1)),
                     Exit::io);
    });
    length_ = static_cast<long long>(length_until(before, *keep_until, path_));
    open(0);
    if (::ftruncate(descriptor_, length_) != 0 || ::lseek(descriptor_, length_, SEEK_SET) < 0)
        throw_io(path_, "cut off what came later", errno);
}

void Table::open(int flags)
{
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0644);
    require(descriptor_ >= 0, [&] {
        return Error(fmt::format("{}: cannot open: {}. Check the folder and its permissions.", path_.string(),
                                 std::strerror(errno)),
                     Exit::io);
    });
}

Table::~Table()
{
    if (descriptor_ >= 0) ::close(descriptor_);
}

void Table::append(std::span<double const> row)
{
    assert(row.size() == columns_);
    Cells cells;
    for (double const value : row) cells.push_back(fmt::format("{}", value));
    write(line_of(cells));
}

void Table::write(std::string const& line)
{
    std::size_t done = 0;
    while (done < line.size()) {
        ssize_t const count = ::write(descriptor_, line.data() + done, line.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) {
            int const code = errno;
            bool const cut = ::ftruncate(descriptor_, length_) == 0 && ::lseek(descriptor_, length_, SEEK_SET) >= 0;
            throw Error(
                fmt::format("{}: cannot write a row: {} (errno {}){}. Free some space, or choose another folder.",
                            path_.string(), std::strerror(code), code, cut ? "" : "; its last row is cut off"),
                Exit::io);
        }
        done += static_cast<std::size_t>(count);
    }
    length_ += static_cast<long long>(line.size());
}

void merge_tables(std::span<TablePart const> parts, std::filesystem::path const& merged)
{
    Cells header{"time [s]"};
    std::vector<std::vector<Cells>> tables;
    for (auto const& part : parts) {
        tables.push_back(read_rows(part.path));
        for (std::size_t k = 1; k < tables.back()[0].size(); ++k)
            header.push_back(part.prefix + "." + tables.back()[0][k]);
    }
    std::map<double, Cells> rows;
    std::size_t first = 1;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        place(tables[p], first, header.size(), parts[p].path, rows);
        first += tables[p][0].size() - 1;
    }
    std::string text = line_of(header);
    for (auto const& [time, row] : rows) text += line_of(row);
    write_atomically(merged, text);
}

}  // namespace sluice
