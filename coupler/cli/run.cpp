#include <cstdio>

#include "coupler/base/error.hpp"
#include "coupler/base/name_lock.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/collect.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/launch.hpp"
#include "coupler/record/atomic_file.hpp"

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
void collect_and_show(Options const& o, Scene const& scene, RunEnding const& ending)
{
    try {
        auto const summary = collect(scene, o.directory, ending);
        if (o.json)
            print_json(summary);
        else if (!o.quiet)
            std::fputs(time_table(summary).c_str(), stdout);
    } catch (Error const& e) {  // what ended the run goes before what cannot be put together
        if (ending.exit == 0) throw;
        std::fprintf(stderr, "%s\n", e.what());
    }
}

}  // namespace

int run_command(Options o)
{
    if (o.directory.empty()) o.directory = path("runs") / o.choice.scene.stem();
    auto const checked = check_scene(o.choice);
    Scene const& scene = checked.loaded.scene;
    NameLock const lock = lock_directory(o.directory);
    write_atomically(o.directory / "scene.yaml", scene.text);
    if (!o.quiet)
        for (auto const& remark : checked.remarks) std::fputs(remark.c_str(), stderr);
    Progress progress(scene, o.quiet);
    auto const ending = launch(scene, o.directory, progress);
    if (ending.exit != 0) std::fprintf(stderr, "%s\n", ending.message.c_str());
    collect_and_show(o, scene, ending);
    if (ending.exit != 0) return ending.exit;
    std::string why_not;
    if (o.report && !make_report({o.directory}, o.directory / "report.html", why_not))
        std::fprintf(stderr, "%s\n", why_not.c_str());
    if (!o.quiet && !o.json) std::printf("results: %s\n", o.directory.c_str());
    return 0;
}

}  // namespace sluice
