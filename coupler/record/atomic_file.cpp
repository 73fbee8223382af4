#include "coupler/record/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

[[noreturn]] void fail(std::filesystem::path const& path, std::string_view action, int code)
{
    std::string_view const advice = code == ENOSPC || code == EDQUOT ? "Free some space, or choose another folder."
                                                                     : "Check the folder and its permissions.";
    throw Error(
        fmt::format("{}: cannot {}: {} (errno {}). {}", path.string(), action, std::strerror(code), code, advice),
        Exit::io);
}

//! An open file; closes itself. `close()` reports what the kernel kept for the end (quota, network file systems).
class Descriptor
{
 public:
    Descriptor(std::filesystem::path const& path, int flags) : value_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
    Descriptor(Descriptor const&) = delete;
    Descriptor& operator=(Descriptor const&) = delete;
    ~Descriptor()
    {
        if (value_ >= 0) ::close(value_);
    }
    int get() const noexcept { return value_; }
    bool close() noexcept
    {
        int const value = value_;
        value_ = -1;
        return ::close(value) == 0;
    }

 private:
    int value_;
};

//! 0, or errno of what went wrong.
int write_all(int descriptor, std::string_view bytes)
{
    while (!bytes.empty()) {
        ssize_t const done = ::write(descriptor, bytes.data(), bytes.size());
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return errno;
        bytes.remove_prefix(static_cast<std::size_t>(done));
    }
    return 0;
}

int write_aside(std::filesystem::path const& aside, std::string_view bytes, Survive survive)
{
    Descriptor file(aside, O_WRONLY | O_CREAT | O_TRUNC);
    if (file.get() < 0) return errno;
    if (int const code = write_all(file.get(), bytes)) return code;
    if (survive == Survive::power_loss && ::fsync(file.get()) != 0) return errno;
    return file.close() ? 0 : errno;
}

int sync_folder(std::filesystem::path const& folder)
{
    Descriptor const handle(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
    if (handle.get() < 0) return errno;
    return ::fsync(handle.get()) == 0 || errno == EINVAL ? 0 : errno;
}

}  // namespace

void make_folder(std::filesystem::path const& folder)
{
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error) fail(folder, "make the folder", error.value());
}

void write_atomically(std::filesystem::path const& path, std::string_view bytes, Survive survive)
{
    make_folder(path.parent_path());
    std::filesystem::path aside = path;
    aside += ".partial";
    if (int const code = write_aside(aside, bytes, survive)) {
        ::unlink(aside.c_str());
        fail(path, fmt::format("write {} bytes", bytes.size()), code);
    }
    if (std::rename(aside.c_str(), path.c_str()) != 0) {
        int const code = errno;
        ::unlink(aside.c_str());
        fail(path, "rename into place", code);
    }
    if (survive == Survive::power_loss)
        if (int const code = sync_folder(path.parent_path())) fail(path, "sync the folder", code);
}

std::string read_file(std::filesystem::path const& path)
{
    Descriptor const file(path, O_RDONLY);
    if (file.get() < 0) fail(path, "open", errno);
    std::string text;
    char buffer[1 << 16];
    for (;;) {
        ssize_t const count = ::read(file.get(), buffer, sizeof buffer);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail(path, "read", errno);
        if (count == 0) return text;
        text.append(buffer, static_cast<std::size_t>(count));
    }
}

}  // namespace sluice
