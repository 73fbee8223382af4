#include "coupler/transport/zmq_door.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

constexpr off_t owned = 0, opened = 1;  // the byte of the file that is locked
constexpr std::size_t secret_bytes = 32;

std::filesystem::path door_file(std::filesystem::path const& directory, int member)
{
    return directory / ("door-" + std::to_string(member));
}

// Locks of the open file (fcntl(2), "open file description locks"), so that threads of one process count as well.
struct flock lock_of(off_t byte)
{
    struct flock lock = {};
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    lock.l_start = byte;
    lock.l_len = 1;
    return lock;
}

Error cannot(std::filesystem::path const& file)
{
    return Error(file.string() + ": " + std::strerror(errno) + " (needed: a directory to write to).", Exit::io);
}

std::string random_text()
{
    std::array<unsigned char, secret_bytes> bytes;
    require(::getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
            [] { return Error(std::string("getrandom: ") + std::strerror(errno) + ".", Exit::io); });
    std::string text;
    for (auto const byte : bytes) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

//! Puts `text` at `file` whole and for this user only, unless a file is there.
void offer(std::filesystem::path const& file, std::string const& text)
{
    auto const draft = file.string() + "." + random_text().substr(0, 16);
    int const handle = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    require(handle >= 0, [&] { return cannot(draft); });
    bool const written = ::write(handle, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    bool const placed = written && (::link(draft.c_str(), file.c_str()) == 0 || errno == EEXIST);
    int const error = errno;
    ::close(handle);
    ::unlink(draft.c_str());
    errno = error;
    require(placed, [&] { return cannot(file); });
}

}  // namespace

Door::Door(std::filesystem::path const& directory, int member, std::string const& name)
    : file_(::open(door_file(directory, member).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600))
{
    require(file_ >= 0, [&] { return cannot(door_file(directory, member)); });
    auto lock = lock_of(owned);
    if (::fcntl(file_, F_OFD_SETLK, &lock) != 0) {
        if (errno != EAGAIN && errno != EACCES) {
            int const error = errno;
            ::close(file_);
            errno = error;
            throw cannot(door_file(directory, member));
        }
        char owner[16] = {};
        auto const length = ::read(file_, owner, sizeof owner - 1);
        ::close(file_);
        throw Error("\"" + name + "\" is already here: " +
                        (length > 0 ? "process " + std::string(owner) : std::string("another process")) +
                        " listens for it in " + directory.string() + ". Wait for it, or use another --out.",
                    Exit::protocol);
    }
    auto const pid = std::to_string(::getpid());
    if (::ftruncate(file_, 0) == 0 && ::pwrite(file_, pid.data(), pid.size(), 0) < 0) {
        // The owner's id is a courtesy to the next one; a full disk is reported by whoever needs the space.
    }
}

Door::~Door()
{
    ::close(file_);
}

void Door::open()
{
    auto lock = lock_of(opened);
    require(::fcntl(file_, F_OFD_SETLK, &lock) == 0,
            [] { return Error(std::string("lock of a door: ") + std::strerror(errno) + ".", Exit::io); });
}

bool Door::is_open(std::filesystem::path const& directory, int member)
{
    int const file = ::open(door_file(directory, member).c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) return false;
    auto lock = lock_of(opened);
    bool const held = ::fcntl(file, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
    ::close(file);
    return held;
}

void require_private(std::filesystem::path const& directory)
{
    struct stat info = {};
    bool const ours = ::lstat(directory.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == ::geteuid() &&
                      (info.st_mode & 077) == 0;
    require(ours, [&] {
        return Error(directory.string() + ": not a directory that only this user can enter (needed for sockets).",
                     Exit::security);
    });
}

std::string run_secret(std::filesystem::path const& directory)
{
    auto const file = directory / "secret";
    if (!std::filesystem::exists(file)) offer(file, random_text());
    int const handle = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    require(handle >= 0, [&] { return cannot(file); });
    struct stat info = {};
    std::string text(2 * secret_bytes, '\0');
    bool const safe = ::fstat(handle, &info) == 0 && info.st_uid == ::geteuid() && (info.st_mode & 077) == 0;
    bool const whole = ::read(handle, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    ::close(handle);
    require(safe && whole, [&] {
        return Error(file.string() + ": not this user's own secret (needed: mode 0600, 64 characters). Remove it.",
                     Exit::security);
    });
    return text;
}

}  // namespace sluice
