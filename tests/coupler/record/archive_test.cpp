#include "coupler/record/archive.hpp"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/folder.hpp"

using namespace sluice;

namespace {

constexpr std::size_t count = 2000;

struct Step
{
    std::vector<std::int64_t> id = std::vector<std::int64_t>(count, 7);
    std::vector<double> position = std::vector<double>(2 * count, 0.25);
    std::vector<float> field;

    explicit Step(std::size_t cells) : field(cells)
    {
        unsigned state = 1;
        for (float& value : field) value = static_cast<float>(state = state * 1664525U + 1013904223U);  // no deflate
    }
    std::vector<ArchiveDataset> datasets() const
    {
        return {{"id", "", std::span(id), {count}},
                {"position", "m", std::span(position), {count, 2}},
                {"pressure", "Pa", std::span(field), {field.size() / 50, 50}, Pack::deflate}};
    }
};

//! Appends until it fails; exit code of the child process, so that a crash at exit shows.
template <class Prepare>
int fill_in_child(std::filesystem::path const& path, Prepare prepare)
{
    pid_t const child = ::fork();
    if (child == 0) {
        prepare();
        int code = 0;
        try {
            Archive archive(path);
            Step const step(5000);
            for (int i = 0; i < 1000; ++i) archive.append(i, step.datasets());
        } catch (Error const& error) {
            std::ofstream(path.string() + ".message") << error.what();
            code = static_cast<int>(error.exit());
        }
        std::exit(code);  // runs the exit handlers
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

//! h5py's view: the number of steps, all of them whole; -1 when the file does not open.
int whole_steps(std::filesystem::path const& path)
{
    std::string const script =
        "import h5py,sys\nf=h5py.File(sys.argv[1])\ns=f['steps']\n"
        "assert all(s[k]['position'].shape==(2000,2) and (s[k]['id'][:]==7).all() and s[k]['pressure'][0,0]!=0 for k "
        "in "
        "s)\nsys.exit(len(s))";
    int const status = std::system(("/usr/bin/python3 -c \"" + script + "\" " + path.string()).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool has_h5py()
{
    return std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") == 0;
}

}  // namespace

TEST_CASE("archive: two equal runs write equal bytes")
{
    test::Folder const folder;
    Step const step(5000);
    for (char const* name : {"a.h5", "b.h5"}) {
        ArchiveFact const facts[] = {
            {"version", std::string("1")}, {"origin", std::vector{0.0, 1.0}}, {"rate", 2.0}, {"empty", std::string()}};
        Archive archive(folder / name, facts);
        for (int i = 0; i < 3; ++i) archive.append(0.1 * i, step.datasets());
        archive.close();
        ::usleep(1'100'000);  // modification times count seconds
    }
    CHECK(read_file(folder / "a.h5") == read_file(folder / "b.h5"));
}

TEST_CASE("archive: HDF5 takes no more room than is reserved")
{
    test::Folder const folder;
    std::size_t const overhead = 64 * 1024;  // below the room that is reserved for a step
    Archive archive(folder / "a.h5");
    for (std::size_t cells : {std::size_t{50}, std::size_t{5000}, std::size_t{2'000'000}}) {
        Step const step(cells);
        for (int i = 0; i < 40; ++i) {
            auto const before = std::filesystem::file_size(folder / "a.h5");
            archive.append(i, step.datasets());
            auto const raw = count * 24 + cells * 4;
            REQUIRE(std::filesystem::file_size(folder / "a.h5") - before <= raw + raw / 64 + overhead);
            if (cells > 5000 && i > 2) break;
        }
    }
}

TEST_CASE("archive: a killed run keeps every appended step")
{
    test::Folder const folder;
    pid_t const child = ::fork();
    if (child == 0) {
        Archive archive(folder / "a.h5");
        Step const step(5000);
        for (int i = 0; i < 25; ++i) archive.append(i, step.datasets());
        ::kill(::getpid(), SIGKILL);
    }
    ::waitpid(child, nullptr, 0);
    if (has_h5py()) CHECK(whole_steps(folder / "a.h5") == 25);
}

TEST_CASE("archive: a full disk is one error, no crash at exit, and a file that opens")
{
    test::SmallDisk const disk;
    if (!disk.mounted()) {
        MESSAGE("skipped: a small file system can only be mounted by root");
        return;
    }
    CHECK(fill_in_child(disk / "a.h5", [] {}) == static_cast<int>(Exit::io));
    if (has_h5py()) CHECK(whole_steps(disk / "a.h5") == 12);
}

TEST_CASE("archive: when HDF5's own write fails it is one error, no crash at exit, and a file that opens")
{
    // A file-size limit: blocks may be reserved beyond it, but not written.
    test::Folder const folder;
    int const code = fill_in_child(folder / "a.h5", [] {
        std::signal(SIGXFSZ, SIG_IGN);
        rlimit const limit{1'000'000, 1'000'000};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    });
    CHECK(code == static_cast<int>(Exit::io));
    CHECK(read_file(folder / "a.h5.message").find("File too large") != std::string::npos);
    if (has_h5py()) CHECK(whole_steps(folder / "a.h5") > 5);
}

TEST_CASE("archive: after HDF5 itself failed no step is taken and nothing crashes")
{
    test::Folder const folder;
    Archive archive(folder / "a.h5");
    std::vector<double> const values{1, 2};
    ArchiveDataset const twice[] = {{"x", "", std::span(values), {2}}, {"x", "", std::span(values), {2}}};
    CHECK_THROWS_AS(archive.append(0, twice), Error);
    CHECK_THROWS_AS(archive.append(1, {}), Error);
    CHECK(archive.steps() == 0);
}

TEST_CASE("archive: an impossible folder is an error with a reason")
{
    CHECK_THROWS_AS(Archive("/proc/nowhere/a.h5"), Error);
    CHECK_THROWS_AS(link_archives("/proc/nowhere/a.h5", {}), Error);
}
