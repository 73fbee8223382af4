#include <doctest/doctest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <thread>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/checkpoints.hpp"
#include "tests/coupler/record/folder.hpp"
#include "tests/support/fault_row.hpp"

using namespace sluice;
using namespace sluice::test;

namespace {

constexpr std::size_t values = 2000;  // 16 kB a part

//! Goes on from the newest checkpoint and writes one after the other until it is killed; exits 1 if that fails.
[[noreturn]] void write_for_ever(CheckpointStore const& store)
{
    try {
        auto const found = store.newest();
        if (!found.manifest) ::_exit(1);
        store.discard_after(found.manifest->window);
        for (auto window = found.manifest->window + 1;; ++window) write_checkpoint(store, window, values);
    } catch (...) {
    }
    ::_exit(1);
}

pid_t start_writer(CheckpointStore const& store)
{
    pid_t const writer = ::fork();
    if (writer == 0) write_for_ever(store);
    return writer;
}

//! True if it was still writing when it was killed.
bool kill_writer(pid_t writer)
{
    int status = 0;
    ::kill(writer, SIGKILL);
    return ::waitpid(writer, &status, 0) == writer && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
}

//! Waits until a later window than this one is complete, a minute at most. The writer may be far ahead of it by then.
bool completed_after(CheckpointStore const& store, std::int64_t window)
{
    for (int wait = 0; wait < 60'000; ++wait) {
        auto const found = store.newest();
        if (found.manifest && found.manifest->window > window) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

}  // namespace

TEST_CASE("checkpoint: a writer killed at any moment leaves a complete generation, and the next one goes on from it")
{
    Folder const folder(memory_folder());
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 0, values);
    std::mt19937_64 random(23);
    std::int64_t window = 0;
    int passed_over = 0;
    Row row("F23", "writer of checkpoints killed", {.brief = 50, .stated = 500});
    while (row.next()) {
        int const kill = row.round();
        pid_t const writer = start_writer(store);
        bool const late = kill % 2 == 1;  // half of them after a checkpoint: between the manifest and the next one
        bool const in_time = !late || completed_after(store, window);
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 40'000));
        REQUIRE(kill_writer(writer));
        REQUIRE(in_time);
        passed_over += !store.newest().note.empty();
        auto const now = trusted_window(store, values);
        REQUIRE(now >= window + late);
        window = now;
    }
    MESSAGE(row.repeats() << " kills, " << window << " checkpoints, " << passed_over
                          << " times one was left unfinished");
}

TEST_CASE("checkpoint: a full disk is said, and the generation before stays valid")
{
    SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    CheckpointStore const store(disk / "run", 2);
    store.prepare();
    write_checkpoint(store, 10);
    for (std::int64_t window = 20; window < 60; window += 10) {
        auto const said =
            io_error([&] { write_checkpoint(store, window, 60'000); });  // 480 kB a part, the disk has 1 MB
        CHECK(has(said, "No space left on device (errno 28). Free some space"));
        CHECK(has(said, ".part: cannot write "));
        CHECK(trusted_window(store) == 10);
        store.discard_after(10);
    }
    write_checkpoint(store, 60);
    CHECK(trusted_window(store) == 60);
}

TEST_CASE("checkpoint: a disk that is full when the manifest comes keeps the generation before")
{
    SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    CheckpointStore const store(disk / "run", 2);
    store.prepare();
    write_checkpoint(store, 10);
    auto manifest = manifest_of(20);
    for (auto const& member : members) manifest.members.push_back(store.write_part(20, member, part_of(20, member)));
    std::string const rest(1'000'000, 'x');
    for (std::size_t size = rest.size(); size > 0; size /= 2)
        io_error([&] { write_atomically(disk / ("rest" + std::to_string(size)), rest.substr(0, size)); });
    CHECK(has(io_error([&] { store.commit(manifest); }), "manifest.json: cannot write "));
    CHECK(trusted_window(store) == 10);
}

TEST_CASE("checkpoint: a read-only file system is said, and its checkpoints can be read")
{
    SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    CheckpointStore const store(disk / "run", 2);
    store.prepare();
    write_checkpoint(store, 10);
    REQUIRE(::mount("", disk.path().c_str(), "", MS_REMOUNT | MS_RDONLY, "") == 0);
    CHECK(has(io_error([&] { write_checkpoint(store, 20); }), "Read-only file system (errno 30)"));
    CHECK(has(io_error([&] { store.discard_after(0); }), "Read-only file system"));
    CHECK(trusted_window(store) == 10);
}

TEST_CASE("checkpoint: a folder without permission is said")
{
    if (::geteuid() == 0) {
        MESSAGE("skipped: root may write everywhere; the read-only file system is tried instead");
        return;
    }
    Folder const folder;
    CheckpointStore const store(folder.path(), 2);
    store.prepare();
    write_checkpoint(store, 10);
    std::filesystem::permissions(store.directory(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    CHECK(has(io_error([&] { write_checkpoint(store, 20); }), "Permission denied (errno 13)"));
    CHECK(trusted_window(store) == 10);
    std::filesystem::permissions(store.directory(), std::filesystem::perms::owner_all);
}

TEST_CASE("checkpoint: a folder that was taken away is not silently made anew")
{
    Folder const folder;
    CheckpointStore const store(folder / "run", 2);
    store.prepare();
    write_checkpoint(store, 10);
    std::filesystem::rename(folder / "run", folder / "elsewhere");
    CHECK(has(io_error([&] { write_checkpoint(store, 20); }),
              "cannot make the folder: No such file or directory (errno 2)"));
    CHECK_FALSE(std::filesystem::exists(folder / "run"));
    CHECK(trusted_window(CheckpointStore(folder / "elsewhere", 2)) == 10);
}
