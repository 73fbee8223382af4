#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "coupler/base/error.hpp"
#include "coupler/base/name_lock.hpp"
#include "coupler/cli/check.hpp"
#include "coupler/cli/collect.hpp"
#include "coupler/cli/graph.hpp"
#include "coupler/cli/keygen.hpp"
#include "coupler/cli/launch.hpp"
#include "coupler/record/atomic_file.hpp"

namespace {

using namespace sluice;
using std::filesystem::path;

//! Keeps a second run out of a directory while one is going on there.
NameLock lock_directory(path const& directory)
{
    std::error_code error;
    std::filesystem::create_directories(directory / ".sluice", error);
    require(!error, [&] { return Error(directory.string() + ": " + error.message() + ". Use --out.", Exit::io); });
    return NameLock(directory / ".sluice" / "run.lock", directory.string() + ": another run is going on there");
}

struct Options
{
    SceneChoice choice;
    path directory;
    bool quiet = false;
    bool report = true;
    path picture;
    std::vector<path> runs;
    path page;
    std::vector<std::string> names;
};

int run_scene(Options& o)
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
    try {
        auto const summary = collect(scene, o.directory, ending);
        if (!o.quiet) std::fputs(time_table(summary).c_str(), stdout);
    } catch (Error const& e) {  // what ended the run goes before what cannot be put together
        if (ending.exit == 0) throw;
        std::fprintf(stderr, "%s\n", e.what());
    }
    if (ending.exit != 0) return ending.exit;
    std::string why_not;
    if (o.report && !make_report({o.directory}, o.directory / "report.html", why_not))
        std::fprintf(stderr, "%s\n", why_not.c_str());
    if (!o.quiet) std::printf("results: %s\n", o.directory.c_str());
    return 0;
}

int check_only(Options const& o)
{
    auto const checked = check_scene(o.choice);
    if (!o.quiet)
        for (auto const& remark : checked.remarks) std::fputs(remark.c_str(), stdout);
    std::printf("%s: ok\n", o.choice.scene.c_str());
    return 0;
}

int draw_graph(Options const& o)
{
    auto const loaded = load_scene(o.choice.scene, o.choice.overrides);
    loaded.diagnostics->throw_if_any();
    auto const dot = to_dot(loaded.scene);
    if (o.picture.empty())
        std::cout << dot;
    else
        draw(dot, o.picture);
    return 0;
}

int report_runs(Options& o)
{
    if (o.page.empty()) o.page = o.runs[0] / (o.runs.size() == 1 ? "report.html" : "comparison.html");
    for (auto const& run : o.runs)
        require(std::filesystem::exists(run / "summary.json"),
                [&] { return Error(run.string() + ": no summary.json (needed: the directory of a run).", Exit::io); });
    std::string why_not;
    require(make_report(o.runs, o.page, why_not), [&] { return Error(why_not, Exit::io); });
    std::printf("%s\n", o.page.c_str());
    return 0;
}

//! The message of a parse error, with the nearest subcommand if that was the mistake.
std::string advice(CLI::App const& app, int argc, char** argv)
{
    if (argc < 2 || argv[1][0] == '-') return {};
    std::vector<std::string> names;
    for (auto const* sub : app.get_subcommands({})) {
        if (sub->get_name() == argv[1]) return {};
        names.push_back(sub->get_name());
    }
    auto const near = nearest(argv[1], names);
    return std::string("\"") + argv[1] + "\" is not a command." + (near ? " Did you mean " + *near + "?" : "");
}

}  // namespace

int main(int argc, char** argv)
{
    Options o;
    CLI::App app{"Sluice couples solvers that run as separate executables: grains, fluid, continuum."};
    app.require_subcommand(1);
    app.set_version_flag("--version", SLUICE_VERSION);
    auto with_scene = [&](CLI::App* sub) {
        sub->add_option("SCENE", o.choice.scene, "the scene (YAML)")->required();
        sub->add_option("--set", o.choice.overrides, "path=value: change the scene, e.g. time.end=0.1")
            ->allow_extra_args(false);
        return sub;
    };
    auto* const run =
        with_scene(app.add_subcommand("run", "start every participant of a scene, show progress, collect results"));
    run->add_option("--out", o.directory, "directory for results (runs/SCENE)");
    run->add_flag("--quiet", o.quiet, "say nothing but errors");
    run->add_flag("!--no-report", o.report, "make no report.html");
    auto* const check = with_scene(app.add_subcommand("check", "find every mistake of a scene without running it"));
    check->add_flag("--quiet", o.quiet, "say nothing but errors");
    auto* const graph = with_scene(app.add_subcommand("graph", "the topology as DOT, or as a picture"));
    graph->add_option("-o,--output", o.picture, "a file ending in .svg, .png or .pdf");
    auto* const report = app.add_subcommand("report", "one self-contained page about a run, or comparing several");
    report->add_option("RUN", o.runs, "directories of runs")->required();
    report->add_option("-o,--output", o.page, "the page (report.html or comparison.html in the first directory)");
    auto* const keys = app.add_subcommand("keygen", "keys for participants on several hosts");
    keys->add_option("DIR", o.directory, "where they go; made if needed")->required();
    keys->add_option("SCENE|NAME", o.names, "a scene, or the names of participants")->required();
    try {
        app.parse(argc, argv);
        if (*keys) return keygen(o.directory, o.names);
        if (*run) return run_scene(o);
        if (*check) return check_only(o);
        if (*graph) return draw_graph(o);
        return report_runs(o);
    } catch (CLI::ParseError const& e) {
        if (auto const text = advice(app, argc, argv); !text.empty()) {
            std::fprintf(stderr, "sluice: %s Try sluice --help.\n", text.c_str());
            return static_cast<int>(Exit::config);
        }
        return app.exit(e) == 0 ? 0 : static_cast<int>(Exit::config);
    } catch (Error const& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    } catch (std::exception const& e) {
        std::fprintf(stderr, "sluice: %s (a bug of ours).\n", e.what());
        return static_cast<int>(Exit::internal);
    }
}
