#include "coupler/base/status_page.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

template <std::size_t N>
void copy_text(char (&to)[N], std::string_view text)
{
    auto const n = std::min(text.size(), N - 1);
    std::memcpy(to, text.data(), n);
    to[n] = '\0';
}

}  // namespace

MappedStatus::MappedStatus(std::filesystem::path const& file, Mode mode)
{
    auto fail = [&](int error) { throw Error(file.string() + ": " + std::strerror(error) + ".", Exit::io); };
    int descriptor = -1;
    if (mode == Mode::open) {
        std::error_code none;
        if (std::filesystem::file_size(file, none) != sizeof(StatusPage) || none) return;
        descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
        if (descriptor < 0) return;
    }
    if (mode == Mode::create) {
        descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
        if (descriptor < 0) fail(errno);
        // blocks now: writing to a hole of a full disk ends a process without a word
        int const error = ::posix_fallocate(descriptor, 0, sizeof(StatusPage));
        if (error != 0) ::close(descriptor), fail(error);
    }
    int const flags = mode == Mode::unshared ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED;
    void* const memory = ::mmap(nullptr, sizeof(StatusPage), PROT_READ | PROT_WRITE, flags, descriptor, 0);
    int const error = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (memory == MAP_FAILED) fail(error);
    page_ = mode == Mode::open ? static_cast<StatusPage*>(memory) : new (memory) StatusPage;
}

MappedStatus::~MappedStatus()
{
    if (page_) ::munmap(page_, sizeof(StatusPage));
}

void MappedStatus::note(std::string_view text)
{
    copy_text(page_->note, text);
}

void MappedStatus::fail(std::string_view message, int exit, bool consequence)
{
    copy_text(page_->message, message);
    page_->exit = exit;
    page_->consequence = consequence ? 1 : 0;
    page_->phase = Phase::failed;
}

}  // namespace sluice
