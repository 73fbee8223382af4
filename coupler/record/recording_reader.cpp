#include <cerrno>

#include "coupler/base/error.hpp"
#include "coupler/record/descriptor.hpp"
#include "coupler/record/recording.hpp"
#include "coupler/record/recording_format.hpp"

namespace sluice {
namespace {

template <class Head>
std::span<std::byte> bytes_of(Head& head)
{
    return std::as_writable_bytes(std::span(&head, 1));
}

}  // namespace

RecordingReader::RecordingReader(std::filesystem::path path)
    : path_(std::move(path)), file_(std::make_unique<Descriptor>(path_, O_RDONLY | O_NONBLOCK))
{
    auto const refuse = [&](std::string const& why) {
        throw Error(path_.string() + ": " + why + " (needs a recording). Is it the right file?", Exit::io);
    };
    if (file_->get() < 0) throw_io(path_, "open", errno);
    length_ = length_of(*file_, path_);
    recording::FileHead head;
    if (!read(bytes_of(head))) refuse("shorter than a recording's head");
    if (head.magic != recording::FileHead{}.magic) refuse("not a recording");
    if (head.version != recording::FileHead{}.version)
        refuse("version " + std::to_string(head.version) + " of the format, not " +
               std::to_string(recording::FileHead{}.version));
    if (!checksum_fits(head.checksum, recording::checksum_of_head(head))) refuse("its head is damaged");
    if (head.canonical > recording::longest_canonical || head.canonical > left()) refuse("cut off in the scene's text");
    canonical_.resize(head.canonical);
    auto const text = std::as_writable_bytes(std::span(canonical_));
    if (!read(text)) refuse("cut off in the scene's text");
    if (!checksum_fits(head.text_checksum, checksum_of(text))) refuse("the scene's text is damaged");
    scene_ = head.scene;
}

RecordingReader::~RecordingReader() = default;

bool RecordingReader::read(std::span<std::byte> into)
{
    if (into.size() > left()) return false;
    auto const count = read_full(file_->get(), into);
    if (count < 0) throw_io(path_, "read", errno);
    position_ += static_cast<std::uint64_t>(count);
    return static_cast<std::size_t>(count) == into.size();
}

void RecordingReader::refuse(std::string const& why) const
{
    throw Error(path_.string() + ": record " + std::to_string(records_) + " at byte " + std::to_string(start_) + ": " +
                    why + ". The records before it are whole.",
                Exit::io);
}

std::optional<RecordingReader::Record> RecordingReader::next()
{
    if (end_ != End::not_yet) return std::nullopt;
    auto const cut_off = [&] {
        end_ = End::cut_off;
        return std::nullopt;
    };
    recording::RecordHead head;
    start_ = position_;
    if (!read(bytes_of(head))) return cut_off();
    if (head.magic != recording::RecordHead{}.magic || !checksum_fits(head.checksum, recording::checksum_of_head(head)))
        refuse("its head is damaged");
    if (head.edge == recording::end_mark) {
        if (head.length != 0 || head.frame != static_cast<std::int64_t>(records_) || left() != 0)
            refuse("the end is marked, but not where the records end");
        end_ = End::closed;
        return std::nullopt;
    }
    if (head.length > left()) return cut_off();
    bytes_.resize(head.length);
    if (!read(bytes_)) return cut_off();
    if (!checksum_fits(head.body_checksum, checksum_of(bytes_))) refuse("its bytes are damaged");
    ++records_;
    return Record{head.edge, head.frame, bytes_};
}

}  // namespace sluice
