#include "coupler/record/collection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/descriptor.hpp"
#include "coupler/record/vtk_xml.hpp"

namespace sluice {
namespace {

constexpr auto closing = "</Collection>\n</VTKFile>\n";

std::string xml_plain(std::string text)
{
    constexpr std::pair<std::string_view, std::string_view> names[] = {
        {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}};
    for (auto const& [escaped, plain] : names)
        for (std::size_t at = text.find(escaped); at != std::string::npos; at = text.find(escaped, at + 1))
            text.replace(at, escaped.size(), plain);
    return text;
}

//! The value of ` name="..."` in one line.
std::optional<std::string_view> attribute(std::string_view line, std::string_view name)
{
    std::string const opening = fmt::format(" {}=\"", name);
    std::size_t const start = line.find(opening);
    if (start == std::string_view::npos) return std::nullopt;
    std::size_t const end = line.find('"', start + opening.size());
    if (end == std::string_view::npos) return std::nullopt;
    return line.substr(start + opening.size(), end - start - opening.size());
}

std::optional<CollectionEntry> parse_entry(std::string_view line)
{
    auto const time = attribute(line, "timestep");
    auto const part = attribute(line, "part");
    auto const file = attribute(line, "file");
    if (!time || !part || !file) return std::nullopt;
    CollectionEntry entry{.time = 0.0, .part = 0, .file = xml_plain(std::string(*file))};
    bool const ok = std::from_chars(time->data(), time->data() + time->size(), entry.time).ec == std::errc{} &&
                    std::from_chars(part->data(), part->data() + part->size(), entry.part).ec == std::errc{};
    return ok ? std::optional(entry) : std::nullopt;
}

//! The files of a series' frames from number `first` on, unfinished ones included.
std::vector<std::filesystem::path> frames_from(SeriesFiles const& files, std::size_t first)
{
    std::vector<std::filesystem::path> found;
    std::string const start = files.name + "_", end = "." + files.ending;
    std::error_code none;
    for (auto const& entry : std::filesystem::directory_iterator(files.directory / files.name, none)) {
        auto const name = entry.path().filename().string();
        if (!name.starts_with(start)) continue;
        std::size_t number = 0;
        auto const [rest, code] = std::from_chars(name.data() + start.size(), name.data() + name.size(), number);
        if (code == std::errc{} && number >= first && (rest == end || rest == end + ".partial"))
            found.push_back(entry.path());
    }
    return found;
}

}  // namespace

void write_collection(std::filesystem::path const& path, std::span<CollectionEntry const> entries)
{
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<Collection>\n";
    for (auto const& entry : entries)
        text += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", entry.time, entry.part,
                            xml_escaped(entry.file));
    write_atomically(path, text + closing);
}

std::vector<CollectionEntry> read_collection(std::filesystem::path const& path)
{
    std::string const text = read_file(path);
    std::vector<CollectionEntry> entries;
    std::string_view rest = text;
    while (!rest.empty()) {
        std::string_view const line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), line.size() + 1));
        if (!line.starts_with("<DataSet ")) continue;
        auto entry = parse_entry(line);
        require(entry.has_value(), [&] {
            return Error(fmt::format("{}: `{}` is not an entry of a collection (needs timestep, part and file).",
                                     path.string(), line),
                         Exit::io);
        });
        entries.push_back(std::move(*entry));
    }
    return entries;
}

std::string SeriesFiles::frame(std::size_t number) const
{
    return fmt::format("{0}/{0}_{1:06}.{2}", name, number, ending);
}

std::vector<CollectionEntry> begin_series(SeriesFiles const& files, std::optional<double> keep_until)
{
    std::vector<CollectionEntry> entries;
    if (keep_until && std::filesystem::exists(files.collection()) && read_file(files.collection()).ends_with(closing))
        entries = read_collection(files.collection());
    else if (keep_until)
        require(frames_from(files, 0).empty(), [&] {
            return Error(fmt::format("{}: not there or not whole, but frames are (it says their times). Bring it back, "
                                     "or put {} elsewhere and resume again.",
                                     files.collection().string(), (files.directory / files.name).string()),
                         Exit::io);
        });
    std::erase_if(entries, [&](CollectionEntry const& entry) { return entry.time > *keep_until; });
    write_collection(files.collection(), entries);
    if (!keep_until) return entries;
    for (auto const& file : frames_from(files, entries.size())) {
        std::error_code error;
        std::filesystem::remove(file, error);
        if (error) throw_io(file, "remove", error.value());
    }
    return entries;
}

void merge_collections(std::span<std::filesystem::path const> parts, std::filesystem::path const& merged)
{
    std::vector<CollectionEntry> all;
    for (std::size_t part = 0; part < parts.size(); ++part) {
        for (CollectionEntry entry : read_collection(parts[part])) {
            auto const file = parts[part].parent_path() / entry.file;
            entry.file = std::filesystem::absolute(file)
                             .lexically_normal()
                             .lexically_relative(std::filesystem::absolute(merged).lexically_normal().parent_path())
                             .generic_string();
            entry.part = static_cast<int>(part);
            all.push_back(std::move(entry));
        }
    }
    std::ranges::stable_sort(all, {}, [](CollectionEntry const& entry) { return std::pair(entry.time, entry.part); });
    write_collection(merged, all);
}

}  // namespace sluice
