// Preloaded into a process: once the file SLUICE_DISK_FAILS exists, writing to files below the directory
// SLUICE_FAILING_DISK fails with the error whose number that file holds: EIO as on a broken disk, EROFS as on one that
// the kernel has made read-only.

#include <dlfcn.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

//! The error that writing there fails with, 0: none.
int failure_of(int descriptor)
{
    static char const* const directory = std::getenv("SLUICE_FAILING_DISK");
    static char const* const trigger = std::getenv("SLUICE_DISK_FAILS");
    if (!directory || !trigger || ::access(trigger, F_OK) != 0) return 0;
    char link[64], path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    auto const length = ::readlink(link, path, sizeof path - 1);
    if (length <= 0 || std::strncmp(path, directory, std::strlen(directory)) != 0) return 0;
    int error = EIO;
    if (auto* const file = std::fopen(trigger, "r")) {
        if (std::fscanf(file, "%d", &error) != 1) error = EIO;
        std::fclose(file);
    }
    return error;
}

template <class Function>
Function real(char const* name)
{
    return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" ssize_t write(int descriptor, void const* bytes, size_t size)
{
    static auto const next = real<ssize_t (*)(int, void const*, size_t)>("write");
    int const error = failure_of(descriptor);
    if (error == 0) return next(descriptor, bytes, size);
    errno = error;
    return -1;
}

extern "C" ssize_t pwrite64(int descriptor, void const* bytes, size_t size, off64_t offset)
{
    static auto const next = real<ssize_t (*)(int, void const*, size_t, off64_t)>("pwrite64");
    int const error = failure_of(descriptor);
    if (error == 0) return next(descriptor, bytes, size, offset);
    errno = error;
    return -1;
}

extern "C" ssize_t pwrite(int descriptor, void const* bytes, size_t size, off_t offset)
{
    return ::pwrite64(descriptor, bytes, size, offset);
}
