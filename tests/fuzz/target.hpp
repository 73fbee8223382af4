#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

//! What every fuzz target is made of. The target is one function that takes any bytes; it may refuse them with an
//! Error, and nothing else may happen.
extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size);

namespace sluice::fuzz {

//! How many inputs were taken, not refused: a corpus that nothing takes would test nothing.
inline long accepted = 0;

//! A rule that no input may break; ends the process, so that the fuzzer keeps the input.
inline void demand(bool holds, char const* rule, std::string const& seen = {})
{
    if (holds) return;
    std::fprintf(stderr, "broken: %s\n%s\n", rule, seen.c_str());
    std::abort();
}

//! A file in memory, for what reads files.
class MemoryFile
{
 public:
    explicit MemoryFile(std::span<std::uint8_t const> bytes) : file_(::memfd_create("input", MFD_CLOEXEC))
    {
        demand(file_ >= 0 && ::write(file_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
               "there is memory for the input");
    }
    MemoryFile(MemoryFile const&) = delete;
    MemoryFile& operator=(MemoryFile const&) = delete;
    ~MemoryFile() { ::close(file_); }
    std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
    int file_;
};

}  // namespace sluice::fuzz
