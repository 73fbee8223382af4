#include "coupler/base/name_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "coupler/base/error.hpp"

namespace sluice {

NameLock::NameLock(std::filesystem::path const& file, std::string const& taken)
    : file_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600))
{
    require(file_ >= 0, [&] {
        return Error(file.string() + ": " + std::strerror(errno) + " (needed: a directory to write to). Use --out.",
                     Exit::io);
    });
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        std::string owner;
        std::ifstream(file) >> owner;
        ::close(file_);
        throw Error(taken + " (process " + owner + "). Wait for it, or use another --out.", Exit::protocol);
    }
    auto const pid = std::to_string(::getpid()) + "\n";
    if (::ftruncate(file_, 0) == 0 && ::write(file_, pid.data(), pid.size()) < 0) {
        // The owner's id is a courtesy to the next one; a full disk is reported by whoever needs the space.
    }
}

NameLock::~NameLock()
{
    ::close(file_);
}

}  // namespace sluice
