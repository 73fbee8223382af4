#include "coupler/transport/shm_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

constexpr std::string_view link_prefix = "/memfd:sluice";
constexpr std::size_t piece = std::size_t{16} << 20;  // bytes allocated at once: a signal undoes no more than that

Error failed(char const* what, std::size_t size)
{
    return Error("shared memory: " + std::string(what) + " of " + std::to_string(size) +
                     " bytes: " + std::strerror(errno) + ". Take transport: zmq, or make room.",
                 Exit::io);
}

//! Whether the link leads to one of ours: opening anything else (a pipe, a device) may block or have effects.
bool leads_to_ours(std::string const& path)
{
    char target[64] = {};
    auto const length = ::readlink(path.c_str(), target, sizeof target - 1);
    return length > 0 && std::string_view(target).starts_with(link_prefix);
}

}  // namespace

Mapping::~Mapping()
{
    if (data_) ::munmap(data_, size_);
}

SharedFile::~SharedFile()
{
    if (descriptor_ >= 0) ::close(descriptor_);
}

SharedFile SharedFile::create(std::size_t size)
{
    rlimit limit = {};
    if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < size) {  // the kernel would end the process
        errno = EFBIG;
        throw failed("a file", size);
    }
    SharedFile file(::memfd_create("sluice", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    bool const ok = file.descriptor_ >= 0 && ::ftruncate(file.descriptor_, static_cast<off_t>(size)) == 0 &&
                    ::fcntl(file.descriptor_, F_ADD_SEALS, F_SEAL_SHRINK) == 0;
    require(ok, [&] { return failed("a file", size); });
    return file;
}

std::optional<SharedFile> SharedFile::open(Address address, std::size_t size)
{
    auto const path = "/proc/" + std::to_string(address.process) + "/fd/" + std::to_string(address.descriptor);
    if (!leads_to_ours(path)) return std::nullopt;
    SharedFile file(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
    struct stat info = {};
    bool const ok = file.descriptor_ >= 0 && ::fstat(file.descriptor_, &info) == 0 && info.st_size >= 0 &&
                    static_cast<std::size_t>(info.st_size) >= size &&
                    (::fcntl(file.descriptor_, F_GET_SEALS) & F_SEAL_SHRINK) != 0;
    if (!ok) return std::nullopt;
    return file;
}

SharedFile::Address SharedFile::address() const
{
    return {::getpid(), descriptor_};
}

void SharedFile::allocate(std::size_t offset, std::size_t size) const
{
    for (std::size_t done = 0; done < size;) {
        auto const part = std::min(piece, size - done);
        int const error = ::posix_fallocate(descriptor_, static_cast<off_t>(offset + done), static_cast<off_t>(part));
        if (error == EINTR) continue;
        errno = error;
        require(error == 0, [&] { return failed("memory", size); });
        done += part;
    }
}

Mapping SharedFile::map(std::size_t offset, std::size_t size, Access access) const
{
    int const protection = access == Access::write ? PROT_READ | PROT_WRITE : PROT_READ;
    void* const data =
        ::mmap(nullptr, size, protection, MAP_SHARED | MAP_POPULATE, descriptor_, static_cast<off_t>(offset));
    require(data != MAP_FAILED, [&] { return failed("a view", size); });
    return {static_cast<std::byte*>(data), size};
}

}  // namespace sluice
