#include "coupler/record/descriptor.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {

Descriptor::~Descriptor()
{
    if (value_ >= 0) ::close(value_);
}

bool Descriptor::close() noexcept
{
    int const value = value_;
    value_ = -1;
    return ::close(value) == 0;
}

int write_all(int descriptor, std::span<std::byte const> bytes) noexcept
{
    while (!bytes.empty()) {
        ssize_t const done = ::write(descriptor, bytes.data(), bytes.size());
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return errno;
        bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
    return 0;
}

std::ptrdiff_t read_full(int descriptor, std::span<std::byte> into) noexcept
{
    std::size_t done = 0;
    while (done < into.size()) {
        ssize_t const count = ::read(descriptor, into.data() + done, into.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return -1;
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    return static_cast<std::ptrdiff_t>(done);
}

std::uint64_t length_of(Descriptor const& file, std::filesystem::path const& path)
{
    struct stat status = {};
    if (::fstat(file.get(), &status) != 0) throw_io(path, "look at", errno);
    require(S_ISREG(status.st_mode),
            [&] { return Error(path.string() + ": not a plain file. Check the folder.", Exit::io); });
    return static_cast<std::uint64_t>(status.st_size);
}

void throw_io(std::filesystem::path const& path, std::string_view action, int code)
{
    std::string_view const advice = code == ENOSPC || code == EDQUOT   ? "Free some space, or choose another folder."
                                    : code == EMFILE || code == ENFILE ? "Raise `ulimit -n`."
                                                                       : "Check the folder and its permissions.";
    throw Error(
        fmt::format("{}: cannot {}: {} (errno {}). {}", path.string(), action, std::strerror(code), code, advice),
        Exit::io);
}

}  // namespace sluice
