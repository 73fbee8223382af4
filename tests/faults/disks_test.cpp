// Rows F15, F16 and F22 of the fault matrix: disks that are full, taken away, read-only, broken; checkpoints that are
// damaged.

#include <cerrno>

#include "coupler/record/atomic_file.hpp"
#include "tests/coupler/record/damage.hpp"
#include "tests/faults/matrix.hpp"

using namespace matrix;

namespace {

bool may_mount(Case const& c)
{
    return shell::run({"/usr/bin/unshare", "-rm", "/bin/true"}, c.log()).exit == 0;
}

//! Runs the scene of `c` on a small disk of its own; `then` happens to it, in a shell, once there is a checkpoint:
//! $disk is its folder. What is then on it is in scratch/saved, its run in `run`.
shell::Result on_small_disk(Case const& c, std::string const& then)
{
    auto const disk = c.scratch.path().string() + "/disk";
    auto words = c.command();
    words[4] = disk + "/run";
    std::ofstream(c.scratch.path() / "script")
        << "disk=" << disk << "\nmount -t tmpfs -o size=2m none $disk || exit 99\n"
        << joined(words) << " & run=$!\n"
        << "while ! ls $disk/run/checkpoints/*/manifest.json >/dev/null 2>&1; do\n"
        << "  kill -0 $run 2>/dev/null || break; sleep 0.01\ndone\n"
        << then << "\nbegin=$(date +%s%N)\nwait $run; code=$?\n"
        << "echo \"ended after $(( ($(date +%s%N) - begin) / 1000000 )) ms\"\n"
        << "rm -f $disk/full\ncp -r $disk/run " << c.scratch.path().string() << "/saved\nexit $code\n";
    return bash(c, "mkdir -p " + disk + "; exec unshare -rm /bin/bash " + c.scratch.path().string() + "/script 2>&1");
}

//! What was saved can be resumed, with room.
void check_saved_resumes(Case const& c)
{
    auto const resumed =
        shell::run({sluice_command, "resume", c.scratch.path() / "saved", "--no-report", "--quiet"}, c.log());
    CHECK_MESSAGE(resumed.exit == 0, resumed.output);
}

double seconds_after(shell::Result const& result)
{
    auto const at = result.output.find("ended after ");
    return at == std::string::npos ? 1e9 : std::stod(result.output.substr(at + 12)) / 1000;
}

std::string const fill = "cat /dev/zero >$disk/full 2>/dev/null";

struct Kind
{
    std::string name, keys, says;
};

}  // namespace

TEST_CASE(
    "F15: a disk that is full when results, a checkpoint or the log are written: said, and the last checkpoint is "
    "valid")
{
    Kind const outputs[] = {{"table", "records: table, points: 500", "from.csv"},
                            {"series", "records: series", "disk/run/from"},
                            {"archive", "records: archive, points: 100", "from.h5"}};
    Kind const checkpoint{"checkpoint", "points: 1", "checkpoint"}, log{"log", "says: 100", "the log"};
    for (std::string const what : {"output", "checkpoint", "log"}) {
        Row row("F15", "disk full: " + what, {.brief = what == "output" ? 3 : 1, .stated = 20});
        while (row.next()) {
            auto const& kind = what == "output" ? outputs[row.round() % 3] : what == "log" ? log : checkpoint;
            CAPTURE(kind.name);
            bool const often = kind.name == "checkpoint";
            Case c(stream_scene("nap: 0.005, " + kind.keys, "",
                                "checkpoint: {windows: " + std::string(often ? "20" : "40") + "}\n", "0.4"));
            if (!may_mount(c)) return row.skip("nobody can mount a small disk of their own here (unshare -rm)");
            auto const result = on_small_disk(c, fill);
            CHECK(result.exit == 7);
            CHECK(has(result.output, "No space left on device"));
            CHECK(has(result.output, "participant \""));
            CHECK(has(result.output, "in window "));
            CHECK(has(result.output, " (t = "));
            if (!often) CHECK(has(first_line(result), "participant \"from\" stopped in window "));
            CHECK(has(result.output, kind.says));
            CHECK(result.output.find("was ended by signal") == std::string::npos);  // no crash
            CHECK(shell::processes_with(c.scratch.path().string() + "/disk/run") == 0);
            row.took(seconds_after(result), often ? 0.005 * 20 * 3 + 1 : 1.0);
            check_saved_resumes(c);
        }
    }
}

TEST_CASE("F16: the directory of results is taken away, read-only, or its disk breaks")
{
    Row row("F16", "directory removed, read-only, EIO", {.brief = 4, .stated = 20});
    while (row.next()) {
        auto const keys = "nap: 0.005, records: " + std::string(row.round() / 4 % 2 == 0 ? "series" : "table");
        Case c(stream_scene(keys, "", "checkpoint: {windows: 20}\n", "0.6"));
        CAPTURE(row.round());
        int const kind = row.round() % 4;
        auto const trigger = c.scratch.path() / "broken";
        std::vector<std::string> words{"/usr/bin/env", "LD_PRELOAD=" FAILING_DISK, "SLUICE_FAILING_DISK=" + c.out(),
                                       "SLUICE_DISK_FAILS=" + trigger.string()};
        auto const command = c.command();
        words.insert(words.end(), command.begin(), command.end());
        shell::Background run(kind >= 2 ? words : command, c.log());
        REQUIRE(c.pid_in_window("from", 50) > 0);
        auto const aside = c.scratch.path() / "elsewhere";
        if (kind == 0) std::filesystem::rename(c.out(), aside);
        if (kind == 1) std::filesystem::rename(c.out() + "/checkpoints", aside);
        if (kind >= 2) {
            std::ofstream(trigger.string() + ".partial") << (kind == 2 ? EROFS : EIO);
            std::filesystem::rename(trigger.string() + ".partial", trigger);
        }
        auto const result = run.wait(30);
        row.took(result.seconds, 1.0 + 20 * 0.01);  // a checkpoint every 20 windows
        CHECK(result.exit == 7);
        CHECK(has(result.output, kind == 3   ? "Input/output error"
                                 : kind == 2 ? "Read-only file system"
                                             : "No such file or directory"));
        CHECK(has(result.output, "participant \""));
        CHECK(has(result.output, "in window "));
        CHECK(c.leftovers() == 0);
        if (kind == 0) {
            CHECK(!std::filesystem::exists(c.out() + "/checkpoints"));  // not silently made anew
            std::filesystem::remove_all(c.out());
            std::filesystem::rename(aside, c.out());
        }
        if (kind == 1) std::filesystem::rename(aside, c.out() + "/checkpoints");
        std::filesystem::remove(trigger);
        check_resumes(c);
    }
    Case file(scene());
    std::ofstream(file.out()) << "a file where the directory should be";
    auto const result = file.run();
    CHECK(result.exit == 7);
    CHECK(says(result, file.out()));
}

TEST_CASE("F22: a damaged checkpoint is found by the command, and the one before is taken and named")
{
    auto const whole = undisturbed("0.2");
    Case c(scene("", "", "checkpoint: {windows: 60}\n"));
    REQUIRE(c.run({"--set", "time.end=0.2"}).exit == 0);
    REQUIRE(c.checkpoints() == std::vector<std::int64_t>{120, 180});
    auto const saved = c.scratch.path() / "saved";
    std::filesystem::copy(c.out(), saved, std::filesystem::copy_options::recursive);
    Row row("F22", "damaged checkpoint, sluice resume", {.brief = 3, .stated = 100});
    while (row.next()) {
        std::filesystem::remove_all(c.out());
        std::filesystem::copy(saved, c.out(), std::filesystem::copy_options::recursive);
        std::vector<std::filesystem::path> files;
        for (auto const& entry : std::filesystem::directory_iterator(c.out() + "/checkpoints/180"))
            files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        REQUIRE(files.size() == 3);
        std::string damage;
        {
            sluice::test::Damage const done(files[static_cast<std::size_t>(row.round()) % 3], random_numbers());
            damage = done.text();
            auto const result = c.resume();
            CAPTURE(damage);
            CHECK(result.exit == 0);
            CHECK(has(result.output, "checkpoint of window 180 is passed over: "));
            CHECK(has(result.output, "going on from the one of window 120."));
            CHECK(end_of(c) == whole);
        }
    }
}
