#pragma once

#include <fcntl.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace sluice {

//! An open file; closes itself. `close()` reports what the kernel kept for the end (quota, network file systems).
class Descriptor
{
 public:
    Descriptor(std::filesystem::path const& path, int flags) : value_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
    Descriptor(Descriptor const&) = delete;
    Descriptor& operator=(Descriptor const&) = delete;
    ~Descriptor();
    int get() const noexcept { return value_; }
    bool close() noexcept;

 private:
    int value_;
};

//! 0, or errno of what went wrong.
int write_all(int descriptor, std::span<std::byte const> bytes) noexcept;

//! How many bytes came, fewer than `into` only at the file's end; -1: errno says why.
std::ptrdiff_t read_full(int descriptor, std::span<std::byte> into) noexcept;

//! The length of an open file, which must be a plain one. Throws Error (Exit::io).
std::uint64_t length_of(Descriptor const& file, std::filesystem::path const& path);

//! Throws the Error (Exit::io) `path: cannot <action>: <the system's reason>`, with what to try.
[[noreturn]] void throw_io(std::filesystem::path const& path, std::string_view action, int code);

}  // namespace sluice
