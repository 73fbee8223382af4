#include "coupler/record/recording.hpp"

#include <doctest/doctest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"
#include "tests/support/repeats.hpp"

using namespace sluice;
using namespace sluice::test;

namespace {

using Bytes = std::vector<std::byte>;
constexpr std::string_view canonical = "time.end = 1\nparticipants.grains.solver = dem\n";

//! The k-th message of a recording: its length and bytes follow from k.
Bytes message(std::uint64_t k)
{
    Bytes bytes((k * 37) % 200);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(k + 3 * i);
    return bytes;
}

void record(Recording& recording, std::uint64_t from, std::uint64_t to)
{
    for (auto k = from; k < to; ++k)
        recording.append(static_cast<std::uint32_t>(k % 3), static_cast<std::int64_t>(k / 3), message(k));
}

struct ReadBack
{
    std::uint64_t records = 0;  //!< that were right
    RecordingReader::End end = RecordingReader::End::not_yet;
    std::string error;
};

ReadBack read_back(std::filesystem::path const& file)
{
    ReadBack back;
    try {
        RecordingReader reader(file);
        while (auto const r = reader.next()) {
            auto const expected = message(back.records);
            REQUIRE(r->edge == back.records % 3);
            REQUIRE(r->frame == static_cast<std::int64_t>(back.records / 3));
            REQUIRE(Bytes(r->bytes.begin(), r->bytes.end()) == expected);
            REQUIRE(reader.records() == ++back.records);
        }
        back.end = reader.end();
    } catch (Error const& error) {
        CHECK(error.exit() == Exit::io);
        back.error = error.what();
    }
    return back;
}

constexpr std::uint64_t few = 30;

//! A closed recording of `few` messages, as text.
std::string small_recording(std::filesystem::path const& file)
{
    Recording recording(file, 7, canonical);
    record(recording, 0, few);
    recording.close();
    return read_file(file);
}

}  // namespace

TEST_CASE("recording: messages come back in order, with the scene they belong to")
{
    Folder const folder;
    for (std::size_t const buffer : {1u, 1000u, 1u << 20}) {
        auto const file = folder / "a/run.rec";
        Recording recording(file, 0xabc, canonical, {.flush_interval = 1e9, .buffer = buffer});
        record(recording, 0, 3000);
        CHECK(recording.records() == 3000);
        recording.close();
        auto const back = read_back(file);
        CHECK(back.records == 3000);
        CHECK(back.end == RecordingReader::End::closed);
        RecordingReader const reader(file);
        CHECK(reader.scene() == 0xabc);
        CHECK(reader.canonical() == canonical);
    }
}

TEST_CASE("recording: an interval bounds what a killed process loses")
{
    Folder const folder;
    Recording recording(folder / "run.rec", 7, canonical, {.flush_interval = 0, .buffer = 1u << 30});
    record(recording, 0, 5);
    auto const back = read_back(folder / "run.rec");
    CHECK(back.records == 5);
    CHECK(back.end == RecordingReader::End::cut_off);
    Recording lazy(folder / "lazy.rec", 7, canonical, {.flush_interval = 1e9, .buffer = 1u << 30});
    record(lazy, 0, 5);
    CHECK(read_back(folder / "lazy.rec").records == 0);
    lazy.flush();
    CHECK(read_back(folder / "lazy.rec").records == 5);
}

TEST_CASE("recording: cut anywhere, it gives every whole record and says that it is cut")
{
    Folder const folder(memory_folder());
    auto const whole = small_recording(folder / "run.rec");
    std::size_t const head = 64 + canonical.size();
    std::vector<std::size_t> ends{head};  // of the records
    for (std::uint64_t k = 0; k < few; ++k) ends.push_back(ends.back() + 40 + message(k).size());
    REQUIRE(ends.back() + 40 == whole.size());
    for (std::size_t size = 0; size < whole.size(); ++size) {
        write_atomically(folder / "cut.rec", whole.substr(0, size));
        auto const back = read_back(folder / "cut.rec");
        if (size < head) {
            REQUIRE_FALSE(back.error.empty());
            continue;
        }
        auto const complete = std::upper_bound(ends.begin(), ends.end(), size) - ends.begin() - 1;
        REQUIRE(back.records == static_cast<std::uint64_t>(complete));
        REQUIRE(back.end == RecordingReader::End::cut_off);
    }
}

TEST_CASE("recording: every flipped bit is found, with the record's number, those before it are whole")
{
    Folder const folder(memory_folder());
    auto const whole = small_recording(folder / "run.rec");
    std::size_t const head = 64 + canonical.size();
    std::mt19937_64 random(5);
    for (int repeat = repeats(4000); repeat > 0; --repeat) {
        auto changed = whole;
        auto const at = static_cast<std::size_t>(random() % whole.size());
        changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 8));
        write_atomically(folder / "bad.rec", changed);
        auto const back = read_back(folder / "bad.rec");
        std::uint64_t record = 0;  // the one that was hit
        for (std::size_t end = head; record <= few && (end += 40 + (record < few ? message(record).size() : 0)) <= at;)
            ++record;
        if (at < head)
            REQUIRE_FALSE(back.error.empty());
        else
            REQUIRE(back.error.find(": record " + std::to_string(record) + " at byte ") != std::string::npos);
        REQUIRE(back.records == (at < head ? 0 : record));
    }
}

TEST_CASE("recording: a killed recorder leaves whole records")
{
    Folder const folder;
    auto const file = folder / "run.rec";
    std::mt19937_64 random(9);
    std::uint64_t most = 0;
    for (int kill = repeats(20); kill > 0; --kill) {
        pid_t const writer = ::fork();
        if (writer == 0) {
            try {
                Recording recording(file, 7, canonical, {.flush_interval = 1e9, .buffer = 5000});
                record(recording, 0, std::uint64_t{1} << 60);
            } catch (...) {
            }
            ::_exit(1);
        }
        std::this_thread::sleep_for(std::chrono::microseconds(2000 + random() % 10'000));
        ::kill(writer, SIGKILL);
        REQUIRE(::waitpid(writer, nullptr, 0) == writer);
        if (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0)
            continue;  // killed before its head
        auto const back = read_back(file);
        REQUIRE(back.error.empty());
        REQUIRE(back.end == RecordingReader::End::cut_off);
        most = std::max(most, back.records);
    }
    CHECK(most > 0);
}

TEST_CASE("recording: a full disk is said, keeps the whole records, and can be tried again")
{
    SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    write_atomically(disk / "ballast", std::string(500'000, 'x'));
    Recording recording(disk / "run.rec", 7, canonical, {.flush_interval = 1e9, .buffer = 20'000});
    std::string said;
    std::uint64_t done = 0;
    try {
        for (; done < 100'000; ++done) record(recording, done, done + 1);
    } catch (Error const& error) {
        CHECK(error.exit() == Exit::io);
        said = error.what();
    }
    CHECK(said.find("No space left on device (errno 28)") != std::string::npos);
    auto const kept = read_back(disk / "run.rec");
    CHECK(kept.error.empty());
    CHECK(kept.records > 1000);
    CHECK(kept.end == RecordingReader::End::cut_off);
    std::filesystem::remove(disk / "ballast");
    recording.close();
    auto const back = read_back(disk / "run.rec");
    CHECK(back.records == done + 1);
    CHECK(back.end == RecordingReader::End::closed);
}

TEST_CASE("recording: what is no recording is refused by name")
{
    Folder const folder;
    write_atomically(folder / "text", std::string(1000, 'x'));
    CHECK(read_back(folder / "text").error ==
          (folder / "text").string() + ": not a recording (needs a recording). Is it the right file?");
    CHECK(read_back(folder / "none").error.find("No such file or directory") != std::string::npos);
    CHECK(read_back(folder.path()).error.find("not a plain file") != std::string::npos);
}
