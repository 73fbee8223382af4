#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

class Descriptor;

struct RecordingOptions
{
    double flush_interval = 1.0;    //!< s of wall time between hand-overs to the system, looked at in append()
    std::size_t buffer = 1u << 20;  //!< B collected at most before a hand-over
};

//! The messages of a run in the order they came, one file: a head of 64 bytes, the scene's canonical text, then
//! records, each with an edge, a frame number, a length and XXH3 checksums of its head and its bytes. A killed process
//! loses what was not handed over; what was, up to the last whole record, can be read.
class Recording
{
 public:
    //! Replaces an earlier file; missing folders are made. Throws Error (Exit::io).
    Recording(std::filesystem::path path, std::uint64_t scene, std::string_view canonical,
              RecordingOptions const& options = {});
    Recording(Recording const&) = delete;
    Recording& operator=(Recording const&) = delete;
    ~Recording();  //!< hands over what it can; without close() the recording reads as cut off

    //! Throws Error (Exit::io), e.g. when the disk is full: the file then ends with a whole record, and what was
    //! collected, this record included, is kept: flush() tries again.
    void append(std::uint32_t edge, std::int64_t frame, std::span<std::byte const> bytes);
    void flush();
    void close();  //!< flush, a mark that this is the end, and a sync to the disk; nothing may follow

    std::uint64_t records() const { return records_; }

 private:
    void collect(std::uint32_t edge, std::int64_t frame, std::span<std::byte const> bytes);
    std::filesystem::path path_;
    RecordingOptions options_;
    std::unique_ptr<Descriptor> file_;
    std::vector<std::byte> buffer_;
    std::uint64_t length_ = 0;  //!< B of whole records in the file
    std::uint64_t records_ = 0;
    std::chrono::steady_clock::time_point flushed_;
};

//! Reads a recording from its begin to its end, one record at a time; takes the memory of the largest record.
class RecordingReader
{
 public:
    enum class End
    {
        not_yet,
        closed,  //!< the recorder came to its end
        cut_off  //!< it did not; every whole record was read
    };
    struct Record
    {
        std::uint32_t edge = 0;
        std::int64_t frame = 0;
        std::span<std::byte const> bytes;  //!< valid until the next call
    };

    //! Throws Error (Exit::io) if it is not a recording or its head is damaged.
    explicit RecordingReader(std::filesystem::path path);
    RecordingReader(RecordingReader const&) = delete;
    RecordingReader& operator=(RecordingReader const&) = delete;
    ~RecordingReader();

    //! The next record; nothing at the end. Throws Error (Exit::io) with the number (from 0) of a damaged record; a
    //! length is compared with what the file has before anything is allocated.
    std::optional<Record> next();

    std::uint64_t scene() const { return scene_; }               //!< its hash
    std::string const& canonical() const { return canonical_; }  //!< its text
    std::uint64_t records() const { return records_; }           //!< read so far
    End end() const { return end_; }

 private:
    bool read(std::span<std::byte> into);
    std::uint64_t left() const { return length_ - position_; }
    [[noreturn]] void refuse(std::string const& why) const;
    std::filesystem::path path_;
    std::unique_ptr<Descriptor> file_;
    std::uint64_t length_ = 0, position_ = 0, start_ = 0;  //!< B: of the file, read, and where this record starts
    std::uint64_t scene_ = 0;
    std::string canonical_;
    std::uint64_t records_ = 0;
    End end_ = End::not_yet;
    std::vector<std::byte> bytes_;
};

}  // namespace sluice
