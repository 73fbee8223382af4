#include "coupler/record/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/record/descriptor.hpp"

namespace sluice {
namespace {

using Pieces = std::span<std::span<std::byte const> const>;

int write_aside(std::filesystem::path const& aside, Pieces pieces, Survive survive)
{
    Descriptor file(aside, O_WRONLY | O_CREAT | O_TRUNC);
    if (file.get() < 0) return errno;
    for (auto const piece : pieces)
        if (int const code = write_all(file.get(), piece)) return code;
    if (survive == Survive::power_loss && ::fsync(file.get()) != 0) return errno;
    return file.close() ? 0 : errno;
}

}  // namespace

void make_folder(std::filesystem::path const& folder)
{
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error) throw_io(folder, "make the folder", error.value());
}

void sync_folder(std::filesystem::path const& folder)
{
    Descriptor const handle(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
    if (handle.get() < 0 || (::fsync(handle.get()) != 0 && errno != EINVAL)) throw_io(folder, "sync the folder", errno);
}

void write_atomically(std::filesystem::path const& path, Pieces pieces, Survive survive)
{
    make_folder(path.parent_path());
    std::filesystem::path aside = path;
    aside += ".partial";
    if (int const code = write_aside(aside, pieces, survive)) {
        ::unlink(aside.c_str());
        std::size_t bytes = 0;
        for (auto const piece : pieces) bytes += piece.size();
        throw_io(path, fmt::format("write {} bytes", bytes), code);
    }
    if (std::rename(aside.c_str(), path.c_str()) != 0) {
        int const code = errno;
        ::unlink(aside.c_str());
        throw_io(path, "rename into place", code);
    }
    if (survive == Survive::power_loss) sync_folder(path.parent_path());
}

void write_atomically(std::filesystem::path const& path, std::span<std::byte const> bytes, Survive survive)
{
    write_atomically(path, Pieces(&bytes, 1), survive);
}

void write_atomically(std::filesystem::path const& path, std::string_view text, Survive survive)
{
    write_atomically(path, std::as_bytes(std::span(text)), survive);
}

std::string read_file(std::filesystem::path const& path)
{
    Descriptor const file(path, O_RDONLY);
    if (file.get() < 0) throw_io(path, "open", errno);
    std::string text;
    char buffer[1 << 16];
    for (;;) {
        auto const count = read_full(file.get(), std::as_writable_bytes(std::span(buffer)));
        if (count < 0) throw_io(path, "read", errno);
        text.append(buffer, static_cast<std::size_t>(count));
        if (count < static_cast<std::ptrdiff_t>(sizeof buffer)) return text;
    }
}

std::string read_file(std::filesystem::path const& path, std::uint64_t most)
{
    Descriptor const file(path, O_RDONLY | O_NONBLOCK);
    if (file.get() < 0) throw_io(path, "open", errno);
    auto const length = length_of(file, path);
    require(length <= most, [&] {
        return Error(fmt::format("{}: {} bytes long (at most {}). Is it the right file?", path.string(), length, most),
                     Exit::io);
    });
    std::string text(length, '\0');
    auto const count = read_full(file.get(), std::as_writable_bytes(std::span(text)));
    if (count < 0) throw_io(path, "read", errno);
    text.resize(static_cast<std::size_t>(count));
    return text;
}

}  // namespace sluice
