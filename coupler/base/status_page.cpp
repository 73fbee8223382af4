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
    int const flags = mode == Mode::create ? O_RDWR | O_CREAT | O_CLOEXEC : O_RDWR | O_CLOEXEC;
    int const descriptor = ::open(file.c_str(), flags, 0600);
    if (descriptor < 0 && mode == Mode::open) return;
    require(descriptor >= 0, [&] { return Error(file.string() + ": " + std::strerror(errno) + ".", Exit::io); });
    bool const sized = ::ftruncate(descriptor, sizeof(StatusPage)) == 0;
    void* const memory =
        sized ? ::mmap(nullptr, sizeof(StatusPage), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0) : MAP_FAILED;
    ::close(descriptor);
    require(memory != MAP_FAILED, [&] { return Error(file.string() + ": " + std::strerror(errno) + ".", Exit::io); });
    page_ = mode == Mode::create ? new (memory) StatusPage : static_cast<StatusPage*>(memory);
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
