#include "coupler/record/atomic_file.hpp"

#include <doctest/doctest.h>

#include "coupler/base/error.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

TEST_CASE("atomic_file: writes, replaces, makes folders, leaves nothing aside")
{
    test::Folder const folder;
    for (Survive const survive : {Survive::kill, Survive::power_loss}) {
        write_atomically(folder / "a/b.txt", "first", survive);
        write_atomically(folder / "a/b.txt", "second", survive);
        CHECK(read_file(folder / "a/b.txt") == "second");
        CHECK_FALSE(std::filesystem::exists(folder / "a/b.txt.partial"));
    }
}

TEST_CASE("atomic_file: the message says what and why")
{
    CHECK_THROWS_WITH_AS(read_file("/nowhere/x"),
                         "/nowhere/x: cannot open: No such file or directory (errno 2). Check the folder and its "
                         "permissions.",
                         Error);
    try {
        write_atomically("/proc/nowhere/x", "text");
        FAIL("no error");
    } catch (Error const& error) {
        CHECK(error.exit() == Exit::io);
    }
}

TEST_CASE("atomic_file: a full disk keeps the old file and no partial one")
{
    test::SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    write_atomically(disk / "x", "old");
    CHECK_THROWS_AS(write_atomically(disk / "x", std::string(2'000'000, 'n')), Error);
    CHECK(read_file(disk / "x") == "old");
    CHECK_FALSE(std::filesystem::exists(disk / "x.partial"));
}
