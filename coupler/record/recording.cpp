#include "coupler/record/recording.hpp"

#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/descriptor.hpp"
#include "coupler/record/recording_format.hpp"

namespace sluice {
namespace {

void append_bytes(std::vector<std::byte>& to, std::span<std::byte const> bytes)
{
    to.insert(to.end(), bytes.begin(), bytes.end());
}

template <class Head>
void append_head(std::vector<std::byte>& to, Head head)
{
    head.checksum = recording::checksum_of_head(head);
    append_bytes(to, std::as_bytes(std::span(&head, 1)));
}

}  // namespace

Recording::Recording(std::filesystem::path path, std::uint64_t scene, std::string_view canonical,
                     RecordingOptions const& options)
    : path_(std::move(path)), options_(options), flushed_(std::chrono::steady_clock::now())
{
    require(canonical.size() <= recording::longest_canonical,
            [&] { return Error(path_.string() + ": the scene is too long to be recorded.", Exit::io); });
    make_folder(path_.parent_path());
    file_ = std::make_unique<Descriptor>(path_, O_WRONLY | O_CREAT | O_TRUNC);
    if (file_->get() < 0) throw_io(path_, "open", errno);
    auto const text = std::as_bytes(std::span(canonical));
    recording::FileHead head;
    head.scene = scene;
    head.canonical = text.size();
    head.text_checksum = checksum_of(text);
    append_head(buffer_, head);
    append_bytes(buffer_, text);
    flush();
}

Recording::~Recording()
{
    try {
        flush();
    } catch (...) {
        // whoever needs to know has called close()
    }
}

void Recording::collect(std::uint32_t edge, std::int64_t frame, std::span<std::byte const> bytes)
{
    assert(file_);
    recording::RecordHead head;
    head.edge = edge;
    head.frame = frame;
    head.length = bytes.size();
    head.body_checksum = checksum_of(bytes);
    append_head(buffer_, head);
    append_bytes(buffer_, bytes);
}

void Recording::append(std::uint32_t edge, std::int64_t frame, std::span<std::byte const> bytes)
{
    assert(edge != recording::end_mark);
    collect(edge, frame, bytes);
    ++records_;
    std::chrono::duration<double> const waited = std::chrono::steady_clock::now() - flushed_;
    if (buffer_.size() >= options_.buffer || waited.count() >= options_.flush_interval) flush();
}

void Recording::flush()
{
    if (!file_) return;
    if (int const code = write_all(file_->get(), buffer_)) {
        auto const whole = static_cast<off_t>(length_);
        [[maybe_unused]] bool const cut =
            ::ftruncate(file_->get(), whole) == 0 && ::lseek(file_->get(), whole, SEEK_SET) >= 0;
        throw_io(path_, "append to the recording", code);
    }
    length_ += buffer_.size();
    buffer_.clear();
    flushed_ = std::chrono::steady_clock::now();
}

void Recording::close()
{
    flush();
    collect(recording::end_mark, static_cast<std::int64_t>(records_), {});
    try {
        flush();
    } catch (Error const&) {
        buffer_.clear();  // the mark alone: another close() writes it again
        throw;
    }
    if (::fsync(file_->get()) != 0 && errno != EINVAL) throw_io(path_, "sync", errno);
    if (!file_->close()) throw_io(path_, "close", errno);
    file_.reset();
}

}  // namespace sluice
