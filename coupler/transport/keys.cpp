#include "coupler/transport/keys.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <cerrno>
#include <cstring>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

constexpr std::size_t key_length = 40;  // Z85 of 32 bytes

Error already_there(std::filesystem::path const& file)
{
    return Error(file.string() + ": exists (keys are not overwritten: others may trust them). Remove it first.",
                 Exit::security);
}

void write_key(std::filesystem::path const& file, char const* key, mode_t mode)
{
    int const handle = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    require(handle >= 0, [&] {
        return errno == EEXIST ? already_there(file)
                               : Error(file.string() + ": " + std::strerror(errno) + ".", Exit::io);
    });
    auto const line = std::string(key) + "\n";
    bool const written = ::fchmod(handle, mode) == 0 &&
                         ::write(handle, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
                         ::fsync(handle) == 0;
    int const error = errno;
    ::close(handle);
    require(written, [&] { return Error(file.string() + ": " + std::strerror(error) + ".", Exit::io); });
}

//! The key in `file`, which must not give any of the rights `forbidden` to anybody.
std::string read_key(std::filesystem::path const& file, mode_t forbidden, char const* danger)
{
    int const handle = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    require(handle >= 0, [&] {
        return Error(file.string() + ": " + std::strerror(errno) + " (needed: a key). Make it with `sluice keygen`.",
                     Exit::security);
    });
    struct stat info = {};
    char text[key_length + 2] = {};
    bool const seen = ::fstat(handle, &info) == 0;
    auto const size = ::read(handle, text, sizeof text);
    ::close(handle);
    require(seen && (info.st_mode & forbidden) == 0 && (info.st_uid == ::geteuid() || info.st_uid == 0), [&] {
        return Error(file.string() + ": " + danger + " (needed: a file of this user's). Use chmod go-rwx.",
                     Exit::security);
    });
    unsigned char raw[32];
    bool const whole = size >= static_cast<ssize_t>(key_length) &&
                       (size == static_cast<ssize_t>(key_length) || text[key_length] == '\n');
    text[key_length] = '\0';
    require(whole && std::strlen(text) == key_length && zmq_z85_decode(raw, text), [&] {
        return Error(file.string() + ": not a key (needed: 40 characters of Z85). Make it with `sluice keygen`.",
                     Exit::security);
    });
    return text;
}

}  // namespace

void require_no_keys(std::filesystem::path const& directory, std::vector<std::string> const& names)
{
    for (auto const& name : names)
        for (char const* kind : {".public", ".secret"})
            require(!std::filesystem::exists(directory / (name + kind)),
                    [&] { return already_there(directory / (name + kind)); });
}

void make_key_pair(std::filesystem::path const& directory, std::string const& name)
{
    require_no_keys(directory, {name});
    char open[key_length + 1], secret[key_length + 1];
    require(zmq_curve_keypair(open, secret) == 0,
            [] { return Error("this libzmq has no CURVE (needed for keys).", Exit::security); });
    write_key(directory / (name + ".secret"), secret, 0600);
    write_key(directory / (name + ".public"), open, 0644);
}

KeyPair read_key_pair(std::filesystem::path const& directory, std::string const& name)
{
    KeyPair pair{read_public_key(directory, name),
                 read_key(directory / (name + ".secret"), 077, "others than its owner can read it")};
    char derived[key_length + 1] = {};
    require(zmq_curve_public(derived, pair.secret.c_str()) == 0 && pair.open == derived, [&] {
        return Error((directory / (name + ".public")).string() + ": does not belong to " + name +
                         ".secret (needed: a pair). Make both again with `sluice keygen`.",
                     Exit::security);
    });
    return pair;
}

std::string read_public_key(std::filesystem::path const& directory, std::string const& name)
{
    return read_key(directory / (name + ".public"), 022, "others than its owner can change it");
}

}  // namespace sluice
