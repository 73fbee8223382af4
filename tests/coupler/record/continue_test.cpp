// A run that was stopped goes on: what it recorded up to then stays, what came later goes, and the files end up as
// those of a run that was never stopped.

#include <doctest/doctest.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <syscall.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>

#include "coupler/base/error.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/image_series.hpp"
#include "coupler/record/point_series.hpp"
#include "coupler/record/table.hpp"
#include "tests/coupler/record/folder.hpp"
#include "tests/support/archive_content.hpp"

using namespace sluice;

namespace {

std::vector<std::string> const headers{"time [s]", "run_out [m]"};

double time_at(int step)
{
    return step * 0.1;
}

void append_rows(Table& table, int begin, int end)
{
    for (int k = begin; k < end; ++k) table.append(std::vector{time_at(k), 1.0 / (k + 1)});
}

void append_points(PointSeries& series, int begin, int end)
{
    for (int k = begin; k < end; ++k) {
        std::int64_t const id[] = {1, 2};
        double const position[] = {0.5 * k, 0, 1, 2};
        series.append(time_at(k), id, std::vector<PointColumn>{{"position", "m", 2, position}});
    }
}

Lattice const lattice{{0, 0, 0}, {1, 1, 1}, {2, 1, 0}};

void append_images(ImageSeries& series, int begin, int end)
{
    for (int k = begin; k < end; ++k) {
        float const pressure[] = {static_cast<float>(k), 7};
        series.append(time_at(k), std::vector<CellColumn>{{"pressure", "Pa", 1, pressure}});
    }
}

void append_steps(Archive& archive, int begin, int end)
{
    for (int k = begin; k < end; ++k) {
        std::vector<double> const value(500, k + 0.25);
        std::vector<float> const field(2000, static_cast<float>(k));
        std::vector<std::int64_t> const id(500, 100 + k);
        archive.append(time_at(k),
                       std::vector<ArchiveDataset>{{"value", "m", std::span(value), {500}},
                                                   {"id", "", std::span(id), {500}},
                                                   {"field", "Pa", std::span(field), {40, 50}, Pack::deflate}});
    }
}

ArchiveFact const fact{"scene_hash", std::string("42")};

//! Every file below a folder, by name, with its bytes.
std::vector<std::pair<std::string, std::string>> files_of(std::filesystem::path const& folder)
{
    std::vector<std::pair<std::string, std::string>> files;
    for (auto const& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files.emplace_back(entry.path().lexically_relative(folder).string(), read_file(entry.path()));
    std::ranges::sort(files);
    return files;
}

//! A child process that appends `steps` steps, killed at its `fatal`-th call that writes to a file. How many it had
//! appended by then; nothing when it came to its end before, -1 when processes cannot be traced here.
std::optional<int> killed_at_write(std::filesystem::path const& path, int steps, int fatal)
{
    auto* const appended = static_cast<int volatile*>(
        ::mmap(nullptr, sizeof(int), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    pid_t const child = ::fork();
    if (child == 0) {
        ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
        std::raise(SIGSTOP);
        Archive archive(path, {&fact, 1});
        for (int k = 0; k < steps; ++k) {
            append_steps(archive, k, k + 1);
            *appended = k + 1;
        }
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    bool const traced = ::ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL) == 0;
    for (int writes = 0; traced && writes < fatal;) {
        ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
        ::waitpid(child, &status, 0);
        if (!WIFSTOPPED(status)) return std::nullopt;
        __ptrace_syscall_info call{};
        ::ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof call, &call);
        if (call.op == PTRACE_SYSCALL_INFO_ENTRY &&
            (call.entry.nr == SYS_pwrite64 || call.entry.nr == SYS_write || call.entry.nr == SYS_ftruncate))
            ++writes;
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
    int const count = traced ? *appended : -1;
    ::munmap(const_cast<int*>(appended), sizeof(int));
    return count;
}

}  // namespace

TEST_CASE("continue: a table, a point series and an image series end up as if they had never been stopped")
{
    test::Folder const whole;
    {
        Table table(whole / "grains.csv", headers);
        PointSeries points(whole.path(), "grains");
        ImageSeries images(whole.path(), "water", lattice);
        append_rows(table, 0, 9);
        append_points(points, 0, 9);
        append_images(images, 0, 9);
    }
    for (int kept = 0; kept <= 6; ++kept) {
        CAPTURE(kept);
        test::Folder const cut;
        {
            Table table(cut / "grains.csv", headers);
            PointSeries points(cut.path(), "grains");
            ImageSeries images(cut.path(), "water", lattice);
            append_rows(table, 0, 6);
            append_points(points, 0, 6);
            append_images(images, 0, 6);
        }
        double const until = kept == 0 ? -1 : time_at(kept - 1);
        Table table(cut / "grains.csv", headers, until);
        PointSeries points(cut.path(), "grains", Precision::float64, until);
        ImageSeries images(cut.path(), "water", lattice, until);
        CHECK(points.frames() == static_cast<std::size_t>(kept));
        CHECK(images.frames() == static_cast<std::size_t>(kept));
        append_rows(table, kept, 9);
        append_points(points, kept, 9);
        append_images(images, kept, 9);
        CHECK(files_of(cut.path()) == files_of(whole.path()));
    }
}

TEST_CASE("continue: a row cut off anywhere, in the header too, is no obstacle")
{
    test::Folder const folder;
    {
        Table table(folder / "t.csv", headers);
        append_rows(table, 0, 4);
    }
    std::string const whole = read_file(folder / "t.csv");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        write_atomically(folder / "t.csv", whole.substr(0, length));
        auto const rows =
            std::max<std::ptrdiff_t>(0, std::count(whole.begin(), whole.begin() + static_cast<long>(length), '\n') - 1);
        Table table(folder / "t.csv", headers, 1e9);
        append_rows(table, static_cast<int>(rows), 4);
        REQUIRE(read_file(folder / "t.csv") == whole);
    }
}

TEST_CASE("continue: files that are not there are begun")
{
    test::Folder const folder;
    Table table(folder / "t.csv", headers, 0.5);
    PointSeries const points(folder.path(), "grains", Precision::float64, 0.5);
    Archive archive(folder / "a.h5", {&fact, 1}, 0.5);
    append_rows(table, 6, 7);
    append_steps(archive, 6, 7);
    CHECK(read_file(folder / "t.csv") == "time [s],run_out [m]\n0.6000000000000001,0.14285714285714285\n");
    CHECK(points.frames() == 0);
    CHECK(archive.steps() == 1);
    CHECK(archive.remark(0).empty());
    CHECK(archive.remark(2).find("not there. It goes on with 1 of 2 earlier steps") != std::string::npos);
}

TEST_CASE("continue: a table with other columns and frames without their collection are refused and left alone")
{
    test::Folder const folder;
    {
        Table table(folder / "t.csv", headers);
        append_rows(table, 0, 3);
        PointSeries points(folder.path(), "grains");
        append_points(points, 0, 3);
    }
    std::filesystem::remove(folder / "grains.pvd");
    auto const before = files_of(folder.path());
    std::vector<std::string> const other{"time [s]", "height [m]"};
    CHECK_THROWS_WITH_AS(Table(folder / "t.csv", other, 0.1),
                         ((folder / "t.csv").string() + ": begins with `time [s],run_out [m]` (this run's rows have "
                                                        "`time [s],height [m]`). Put it elsewhere and resume again.")
                             .c_str(),
                         Error);
    CHECK_THROWS_AS(PointSeries(folder.path(), "grains", Precision::float64, 0.1), Error);
    CHECK(files_of(folder.path()) == before);
    write_atomically(folder / "grains.pvd", "");  // what a power loss may leave
    CHECK_THROWS_AS(PointSeries(folder.path(), "grains", Precision::float64, 0.1), Error);
    CHECK(files_of(folder.path()).size() == before.size() + 1);
}

TEST_CASE("continue: frames of a killed run that its collection does not list are removed, others stay")
{
    test::Folder const folder;
    {
        PointSeries points(folder.path(), "grains");
        append_points(points, 0, 3);
    }
    write_atomically(folder / "grains/grains_000003.vtp", "written, but not listed yet");
    write_atomically(folder / "grains/grains_000004.vtp.partial", "half");
    write_atomically(folder / "grains/grains_000005.vtp.mine", "a user's");
    write_atomically(folder / "grains/grains_note.vtp", "a user's");
    PointSeries const points(folder.path(), "grains", Precision::float64, time_at(2));
    CHECK(points.frames() == 3);
    std::vector<std::string> names;
    for (auto const& [name, bytes] : files_of(folder.path())) names.push_back(name);
    CHECK(names == std::vector<std::string>{"grains.pvd", "grains/grains_000000.vtp", "grains/grains_000001.vtp",
                                            "grains/grains_000002.vtp", "grains/grains_000005.vtp.mine",
                                            "grains/grains_note.vtp"});
}

TEST_CASE("continue: an archive ends up with the content of one that was never stopped")
{
    if (!archive::has_reader()) {
        MESSAGE("skipped: needs python3-h5py");
        return;
    }
    test::Folder const folder;
    {
        Archive whole(folder / "whole.h5", {&fact, 1});
        append_steps(whole, 0, 9);
        whole.close();
    }
    auto const expected = archive::content(folder / "whole.h5");
    REQUIRE(expected.size() > 1000);
    for (int const kept : {0, 1, 4, 6}) {
        CAPTURE(kept);
        {
            Archive cut(folder / "cut.h5", {&fact, 1});
            append_steps(cut, 0, 6);
        }
        Archive resumed(folder / "cut.h5", {&fact, 1}, kept == 0 ? -1 : time_at(kept - 1));
        CHECK(resumed.steps() == static_cast<std::size_t>(kept));
        CHECK(resumed.remark(static_cast<std::size_t>(kept)).empty());
        append_steps(resumed, kept, 9);
        resumed.close();
        CHECK(archive::content(folder / "cut.h5") == expected);
        CHECK(!std::filesystem::exists(folder / "cut.h5.partial"));
    }
}

TEST_CASE("continue: an archive that cannot be read is put aside, and said so")
{
    test::Folder const folder;
    write_atomically(folder / "a.h5", "not HDF5");
    Archive archive(folder / "a.h5", {&fact, 1}, 0.5);
    CHECK(archive.steps() == 0);
    CHECK(archive.remark(6).find("a.h5: could not be read up to t = 0.5 s (step 0: it does not open") !=
          std::string::npos);
    CHECK(archive.remark(6).find("0 of 6 earlier steps") != std::string::npos);
    CHECK(read_file(folder / "a.h5.damaged") == "not HDF5");
    append_steps(archive, 6, 7);
    archive.close();
    CHECK(archive.steps() == 1);
}

TEST_CASE("continue: an archive whose run is killed at any of its writes keeps every step")
{
    test::Folder const folder;
    for (int fatal = 1;; ++fatal) {
        std::filesystem::remove(folder / "a.h5");
        auto const appended = killed_at_write(folder / "a.h5", 10, fatal);
        if (!appended) {
            CHECK(fatal > 50);
            return;
        }
        if (*appended < 0) {
            MESSAGE("skipped: processes cannot be traced here");
            return;
        }
        if (*appended == 0) continue;
        CAPTURE(fatal);
        Archive const archive(folder / "a.h5", {&fact, 1}, time_at(*appended - 1));
        REQUIRE(archive.remark(static_cast<std::size_t>(*appended)).empty());
        REQUIRE(archive.steps() == static_cast<std::size_t>(*appended));
    }
}
