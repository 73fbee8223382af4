#include "coupler/record/table.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

namespace {

std::vector<std::string> const headers{"time [s]", "run_out [m]"};

}

TEST_CASE("table: rows arrive at once and read back to the last bit")
{
    test::Folder const folder;
    Table table(folder / "t.csv", headers);
    double const third = 1.0 / 3.0;
    table.append(std::vector{0.1, third});
    std::string const text = read_file(folder / "t.csv");  // the table is still open
    CHECK(text == "time [s],run_out [m]\n0.1,0.3333333333333333\n");
    CHECK(std::stod(text.substr(text.rfind(',') + 1)) == third);
}

TEST_CASE("table: a header with a comma is refused")
{
    test::Folder const folder;
    std::vector<std::string> const bad{"time [s]", "a,b"};
    CHECK_THROWS_AS(Table(folder / "t.csv", bad), Error);
}

TEST_CASE("table: merging joins by time, leaves gaps empty, drops an unfinished row")
{
    test::Folder const folder;
    write_atomically(folder / "a.csv", "time [s],run_out [m]\n0,1\n0.2,2\n");
    write_atomically(folder / "b.csv", "time [s],p [Pa],v [m/s]\n0,5,6\n0.1,7,8\n0.2,9");
    TablePart const parts[] = {{"grains", folder / "a.csv"}, {"water", folder / "b.csv"}};
    merge_tables(parts, folder / "m.csv");
    CHECK(read_file(folder / "m.csv") ==
          "time [s],grains.run_out [m],water.p [Pa],water.v [m/s]\n0,1,5,6\n0.1,,7,8\n0.2,2,,\n");
}

TEST_CASE("table: a file that is no table is an error with its line")
{
    test::Folder const folder;
    write_atomically(folder / "a.csv", "time [s],x\nzero,1\n");
    TablePart const parts[] = {{"grains", folder / "a.csv"}};
    CHECK_THROWS_WITH_AS(merge_tables(parts, folder / "m.csv"),
                         ((folder / "a.csv").string() + ":2: time `zero` is not a number.").c_str(), Error);
    write_atomically(folder / "a.csv", "");
    CHECK_THROWS_AS(merge_tables(parts, folder / "m.csv"), Error);
    write_atomically(folder / "a.csv", "time [s],x\n1\n");
    CHECK_THROWS_AS(merge_tables(parts, folder / "m.csv"), Error);
}

TEST_CASE("table: a full disk leaves whole rows only")
{
    test::SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    Table table(disk / "t.csv", headers);
    bool failed = false;
    for (int i = 0; i < 200'000 && !failed; ++i) {
        try {
            table.append(std::vector{0.001 * i, std::sqrt(i)});
        } catch (Error const& error) {
            failed = true;
            CHECK(error.exit() == Exit::io);
        }
    }
    CHECK(failed);
    CHECK(read_file(disk / "t.csv").back() == '\n');
}
