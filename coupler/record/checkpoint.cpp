#include "coupler/record/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/descriptor.hpp"

namespace sluice {
namespace {

namespace fs = std::filesystem;

//! A folder's name as a window: nothing unless it is how folder() writes one.
std::optional<std::int64_t> window_of(std::string const& name)
{
    std::int64_t window = -1;
    std::from_chars(name.data(), name.data() + name.size(), window);
    return window >= 0 && std::to_string(window) == name ? std::optional(window) : std::nullopt;
}

std::uint64_t length_of_part(fs::path const& file)
{
    Descriptor const descriptor(file, O_RDONLY | O_NONBLOCK);
    if (descriptor.get() < 0) throw_io(file, "open", errno);
    return length_of(descriptor, file);
}

void require_length(fs::path const& file, std::uint64_t length, std::uint64_t needed)
{
    require(length == needed,
            [&] { return Error(fmt::format("{}: {} bytes (needs {}).", file.string(), length, needed), Exit::io); });
}

void require_digest(fs::path const& file, Digest const& found, Digest const& needed)
{
    require(checksum_fits(needed, found), [&] {
        return Error(fmt::format("{}: XXH3 {} (needs {}).", file.string(), hex(found), hex(needed)), Exit::io);
    });
}

//! Reads a part in pieces; throws if it is not what its manifest says.
void verify(fs::path const& file, CheckpointPart const& part)
{
    Descriptor const descriptor(file, O_RDONLY | O_NONBLOCK);
    if (descriptor.get() < 0) throw_io(file, "open", errno);
    require_length(file, length_of(descriptor, file), part.bytes);
    std::vector<std::byte> piece(std::min<std::uint64_t>(part.bytes, 1u << 20));
    DigestStream stream;
    for (std::uint64_t done = 0; done < part.bytes;) {
        auto const count = read_full(descriptor.get(), piece);
        if (count < 0) throw_io(file, "read", errno);
        done += static_cast<std::uint64_t>(count);
        if (count == 0) require_length(file, done, part.bytes);  // cut while it is read
        stream.add(std::span(piece).first(static_cast<std::size_t>(count)));
    }
    require_digest(file, stream.digest(), part.digest);
}

}  // namespace

CheckpointStore::CheckpointStore(fs::path const& directory, int keep) : root_(directory / "checkpoints"), keep_(keep)
{
    assert(keep >= 1);
}

void CheckpointStore::prepare() const
{
    make_folder(root_);
    sync_folder(root_.parent_path());
}

fs::path CheckpointStore::folder(std::int64_t window) const
{
    return root_ / std::to_string(window);
}

fs::path CheckpointStore::manifest_file(std::int64_t window) const
{
    return folder(window) / "manifest.json";
}

fs::path CheckpointStore::part_file(std::int64_t window, std::string_view member) const
{
    require(is_member(member) && window >= 0, [&] {
        return Error(fmt::format("{}: window {} of member \"{}\" is none (needs a participant's name, then :RANK).",
                                 root_.string(), window, member.substr(0, 64)),
                     Exit::internal);
    });
    return folder(window) / (std::string(member) + ".part");
}

CheckpointPart CheckpointStore::write_part(std::int64_t window, std::string_view member,
                                           std::span<std::byte const> bytes) const
{
    return write_pieces(window, member, {&bytes, 1});
}

CheckpointPart CheckpointStore::write_part(std::int64_t window, std::string_view member, State const& state) const
{
    return write_pieces(window, member, state.pieces().pieces);
}

CheckpointPart CheckpointStore::write_pieces(std::int64_t window, std::string_view member,
                                             std::span<std::span<std::byte const> const> pieces) const
{
    auto const file = part_file(window, member);
    std::error_code error;
    fs::create_directory(file.parent_path(), error);
    if (error) throw_io(file.parent_path(), "make the folder", error.value());
    write_atomically(file, pieces, Survive::power_loss);
    CheckpointPart part{std::string(member), 0, {}};
    DigestStream stream;
    for (auto const piece : pieces) {
        stream.add(piece);
        part.bytes += piece.size();
    }
    part.digest = stream.digest();
    return part;
}

std::string CheckpointStore::commit(Manifest manifest) const
{
    auto const by_name = [](CheckpointPart const& a, CheckpointPart const& b) { return a.member < b.member; };
    std::sort(manifest.members.begin(), manifest.members.end(), by_name);
    for (auto const& part : manifest.members) {
        auto const file = part_file(manifest.window, part.member);
        require_length(file, length_of_part(file), part.bytes);
    }
    manifest.previous.reset();
    for (auto const window : windows())
        if (!manifest.previous && window < manifest.window && looks_complete(window)) manifest.previous = window;
    sync_folder(root_);
    write_atomically(manifest_file(manifest.window), manifest.text(), Survive::power_loss);
    return prune(manifest.window);
}

std::vector<std::int64_t> CheckpointStore::windows() const
{
    std::vector<std::int64_t> found;
    std::error_code error;
    fs::directory_iterator entries(root_, error);
    for (; !error && entries != fs::directory_iterator(); entries.increment(error))
        if (auto const window = window_of(entries->path().filename().string())) found.push_back(*window);
    if (error && error != std::errc::no_such_file_or_directory) throw_io(root_, "list the folder", error.value());
    std::sort(found.begin(), found.end(), std::greater<>());
    return found;
}

Manifest CheckpointStore::read_manifest(std::int64_t window) const
{
    auto const file = manifest_file(window);
    auto manifest = Manifest::parse(read_file(file, Manifest::longest_text), file.string());
    require(manifest.window == window, [&] {
        return Error(fmt::format("{}: of window {} (needs {}).", file.string(), manifest.window, window), Exit::io);
    });
    return manifest;
}

bool CheckpointStore::looks_complete(std::int64_t window) const
{
    try {
        auto const manifest = read_manifest(window);
        return std::all_of(manifest.members.begin(), manifest.members.end(), [&](CheckpointPart const& part) {
            return length_of_part(part_file(window, part.member)) == part.bytes;
        });
    } catch (Error const&) {
        return false;
    }
}

FoundCheckpoint CheckpointStore::newest() const
{
    FoundCheckpoint found;
    for (auto const window : windows()) {
        try {
            auto manifest = read_manifest(window);
            for (auto const& part : manifest.members) verify(part_file(window, part.member), part);
            found.manifest = std::move(manifest);
            break;
        } catch (Error const& error) {
            std::error_code ignored;
            bool const unfinished = !fs::exists(manifest_file(window), ignored) && !ignored;
            found.note += fmt::format("checkpoint of window {} is passed over: {}\n", window,
                                      unfinished ? "it was never completed." : error.what());
        }
    }
    if (found.manifest && !found.note.empty())
        found.note += fmt::format("going on from the one of window {}.", found.manifest->window);
    if (!found.manifest) found.note += fmt::format("{}: no complete checkpoint.", root_.string());
    return found;
}

std::vector<std::byte> CheckpointStore::read_part(Manifest const& manifest, std::string_view member) const
{
    auto const file = part_file(manifest.window, member);
    auto const* const part = manifest.part_of(member);
    require(part != nullptr, [&] {
        return Error(fmt::format("{}: has no part of \"{}\". Was the scene changed?",
                                 manifest_file(manifest.window).string(), member),
                     Exit::io);
    });
    Descriptor const descriptor(file, O_RDONLY | O_NONBLOCK);
    if (descriptor.get() < 0) throw_io(file, "open", errno);
    require_length(file, length_of(descriptor, file), part->bytes);
    std::vector<std::byte> bytes(part->bytes);
    auto const count = read_full(descriptor.get(), bytes);
    if (count < 0) throw_io(file, "read", errno);
    require_length(file, static_cast<std::uint64_t>(count), part->bytes);
    require_digest(file, digest_of(bytes), part->digest);
    return bytes;
}

//! The manifest goes first: what is left after a death in between is an incomplete generation.
void CheckpointStore::remove(std::int64_t window) const
{
    std::error_code error;
    fs::remove(manifest_file(window), error);
    if (!error) fs::remove_all(folder(window), error);
    if (error) throw_io(folder(window), "remove the folder", error.value());
}

std::string CheckpointStore::prune(std::int64_t newest) const
{
    std::string left;
    int kept = 1;
    for (auto const window : windows()) {
        if (window >= newest || (looks_complete(window) && ++kept <= keep_)) continue;
        try {
            remove(window);
        } catch (Error const& error) {
            left += (left.empty() ? "" : "\n") + std::string(error.what());
        }
    }
    return left;
}

void CheckpointStore::discard_after(std::int64_t window) const
{
    auto const all = windows();
    if (all.empty() || all.front() <= window) return;
    for (auto const newer : all)
        if (newer > window) remove(newer);
    sync_folder(root_);
}

}  // namespace sluice
