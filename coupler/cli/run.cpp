#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <numeric>

#include "coupler/base/error.hpp"
#include "coupler/base/name_lock.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/collect.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/hosts.hpp"
#include "coupler/cli/launch.hpp"
#include "coupler/cli/run_record.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/checkpoint.hpp"

namespace sluice {
namespace {

using std::filesystem::path;

//! Keeps a second run out of a directory while one is going on there.
NameLock lock_directory(path const& directory)
{
    std::error_code error;
    std::filesystem::create_directories(directory / ".sluice", error);
    require(!error, [&] { return Error(directory.string() + ": " + error.message() + ". Use --out.", Exit::io); });
    return NameLock(directory / ".sluice" / "run.lock", directory.string() + ": another run is going on there");
}

//! Puts the results together and shows the table of times, or with --json the summary.
void collect_and_show(Options const& o, Scene const& scene, RunEnding const& ending, RunRecord const& record)
{
    try {
        record.write(o.directory);
        auto const summary = collect(scene, o.directory, ending, record.parts);
        if (o.json)
            print_json(summary);
        else if (!o.quiet)
            std::fputs(time_table(summary).c_str(), stdout);
    } catch (Error const& e) {  // what ended the run goes before what cannot be put together
        if (ending.exit == 0) throw;
        std::fprintf(stderr, "%s\n", e.what());
    }
}

//! Starts all, waits, collects. The directory is locked and made ready.
int carry_out(Options const& o, CheckedScene const& checked, RunRecord record, Begin begin, UserSignals& signals)
{
    Scene const& scene = checked.loaded.scene;
    if (!o.quiet)
        for (auto const& remark : checked.remarks) std::fputs(remark.c_str(), stderr);
    require_hosts(scene, o.directory);
    std::vector<std::string> names;
    for (auto const& member : members_of_crew(scene)) names.push_back(member.name);
    Progress progress(names, o.quiet);
    auto const ending = launch(scene, o.directory, progress, begin, "sluice resume " + o.directory.string(), signals);
    if (ending.exit != 0) std::fprintf(stderr, "%s\n", ending.message.c_str());
    record.parts.push_back(ending.wall_seconds);
    collect_and_show(o, scene, ending, record);
    if (ending.exit != 0) return ending.exit;
    std::string why_not;
    if (o.report && !make_report({o.directory}, o.directory / "report.html", why_not))
        std::fprintf(stderr, "%s\n", why_not.c_str());
    if (!o.quiet && !o.json) std::printf("results: %s\n", o.directory.c_str());
    return 0;
}

//! The scene that a run began with: the file itself while it is as it was, so that paths beside it still lead
//! somewhere, else the run's copy.
path scene_of(path const& run, RunRecord const& record, bool quiet)
{
    auto const copy = run / "scene.yaml";
    std::error_code none;
    if (std::filesystem::exists(record.scene, none) && read_file(record.scene) == read_file(copy)) return record.scene;
    if (!quiet)
        std::fprintf(stderr,
                     "%s is not what this run began with: going on with the copy in %s. Paths in it that are "
                     "relative to the scene now start there.\n",
                     record.scene.c_str(), run.c_str());
    return copy;
}

void require_checkpoint(Options const& o, Scene const& scene)
{
    auto const found = CheckpointStore(o.directory, scene.checkpoint.keep).newest();
    require(found.manifest.has_value(), [&] {
        return Error(o.directory.string() + ": no complete checkpoint to go on from. " + found.note +
                         "\nStart the run anew: sluice run.",
                     Exit::io);
    });
    require(found.manifest->scene == physics_hash(scene), [&] {
        return Error(o.directory.string() +
                         ": its checkpoint is of another scene. Only time.end, checkpoint, timeouts and on-death may "
                         "change.",
                     Exit::protocol);
    });
    if (!found.note.empty()) std::fprintf(stderr, "%s\n", found.note.c_str());
    if (!o.quiet)
        std::fprintf(stderr, "going on from window %lld (t = %.6g s)\n", static_cast<long long>(found.manifest->window),
                     static_cast<double>(found.manifest->ticks) * found.manifest->tick);
}

}  // namespace

int run_command(Options o)
{
    UserSignals signals;
    if (o.directory.empty()) o.directory = path("runs") / o.choice.scene.stem();
    auto const checked = check_scene(o.choice);
    Scene const& scene = checked.loaded.scene;
    NameLock const lock = lock_directory(o.directory);
    remove_old_results(scene, o.directory);
    write_atomically(o.directory / "scene.yaml", scene.text);
    RunRecord const record{.scene = std::filesystem::absolute(o.choice.scene).lexically_normal(),
                           .started = std::filesystem::current_path(),
                           .set = o.choice.overrides,
                           .parts = {}};
    record.write(o.directory);
    return carry_out(o, checked, record, Begin::anew, signals);
}

int resume_command(Options o)
{
    UserSignals signals;
    require(std::filesystem::is_directory(o.directory), [&] {
        return Error(o.directory.string() + ": no such directory (needed: the directory of a run).", Exit::io);
    });
    o.directory = std::filesystem::absolute(o.directory).lexically_normal();
    auto record = RunRecord::read(o.directory);
    NameLock const lock = lock_directory(o.directory);
    if (::chdir(record.started.c_str()) != 0 && !o.quiet)
        std::fprintf(stderr, "%s, where this run was started, is no longer there: relative paths now start here.\n",
                     record.started.c_str());
    record.set.insert(record.set.end(), o.choice.overrides.begin(), o.choice.overrides.end());
    o.choice = {scene_of(o.directory, record, o.quiet), record.set};
    auto const checked = check_scene(o.choice);
    require_checkpoint(o, checked.loaded.scene);
    put_part_aside(checked.loaded.scene, o.directory, static_cast<int>(record.parts.size()));
    record.write(o.directory);
    return carry_out(o, checked, record, Begin::resumed, signals);
}

}  // namespace sluice
