#include "coupler/record/disk_space.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

Error too_full(std::filesystem::path const& path, std::uint64_t bytes, int code)
{
    struct statvfs system = {};
    std::uint64_t const free = ::statvfs(path.c_str(), &system) == 0 ? system.f_bavail * system.f_frsize : 0;
    return Error(fmt::format("{}: {} (needs {} kB for the next step, {} kB are free). Free some space, or choose "
                             "another folder; what was written so far can be read.",
                             path.string(), std::strerror(code), bytes / 1024 + 1, free / 1024),
                 Exit::io);
}

//! 0, or errno.
int allocate_beyond_end(int descriptor, std::uint64_t bytes)
{
    struct stat status = {};
    if (::fstat(descriptor, &status) != 0) return errno;
    int code = EINTR;
    while (code == EINTR)
        code = ::fallocate(descriptor, FALLOC_FL_KEEP_SIZE, status.st_size, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
    return code;
}

int compare_with_free(std::filesystem::path const& path, std::uint64_t bytes)
{
    struct statvfs system = {};
    if (::statvfs(path.c_str(), &system) != 0) return errno;
    return system.f_bavail * system.f_frsize < bytes ? ENOSPC : 0;
}

}  // namespace

void reserve_space(std::filesystem::path const& path, std::uint64_t bytes)
{
    int const descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    require(descriptor >= 0, [&] {
        return Error(fmt::format("{}: cannot open: {}. Was the file moved?", path.string(), std::strerror(errno)),
                     Exit::io);
    });
    int code = allocate_beyond_end(descriptor, bytes);
    ::close(descriptor);
    if (code == EOPNOTSUPP || code == ENOSYS) code = compare_with_free(path, bytes);
    if (code == 0) return;
    release_reserve(path);
    throw too_full(path, bytes, code);
}

void release_reserve(std::filesystem::path const& path) noexcept
{
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) return;
    [[maybe_unused]] int const ignored = ::truncate(path.c_str(), status.st_size);
}

}  // namespace sluice
