#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "coupler/base/error.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/keygen.hpp"

// The command line's grammar. One file, since CLI11 costs 3 s each time it is compiled; what the commands do is
// elsewhere.
namespace {

using namespace sluice;

//! A command's name, and what it does.
using Actions = std::vector<std::pair<CLI::App*, std::function<int()>>>;

void add_scene(CLI::App* command, Options& o)
{
    command->add_option("SCENE", o.choice.scene, "the scene (YAML)")->required();
    command->add_option("--set", o.choice.overrides, "path=value: change the scene, e.g. time.end=0.1")
        ->allow_extra_args(false);
}

void add_run(CLI::App& app, Options& o, Actions& actions)
{
    auto* const run = app.add_subcommand("run", "start every participant of a scene, show progress, collect results");
    add_scene(run, o);
    run->add_option("--out", o.directory, "directory for results (runs/SCENE)");
    run->add_flag("--quiet", o.quiet, "say nothing but errors");
    run->add_flag("!--no-report", o.report, "make no report.html");
    run->add_flag("--json", o.json, "print summary.json at the end");
    actions.emplace_back(run, [&o] { return run_command(o); });
}

void add_resume(CLI::App& app, Options& o, Actions& actions)
{
    auto* const resume = app.add_subcommand("resume", "go on with a stopped run from its newest complete checkpoint");
    resume->add_option("RUN", o.directory, "directory of the run")->required();
    resume->add_option("--set", o.choice.overrides, "path=value: time.end, checkpoint, timeouts or on-death may change")
        ->allow_extra_args(false);
    resume->add_flag("--quiet", o.quiet, "say nothing but errors");
    resume->add_flag("!--no-report", o.report, "make no report.html");
    resume->add_flag("--json", o.json, "print summary.json at the end");
    actions.emplace_back(resume, [&o] { return resume_command(o); });
}

void add_replay(CLI::App& app, Options& o, Actions& actions)
{
    auto* const record = app.add_subcommand("record", "run, and write down every frame that is sent");
    add_scene(record, o);
    record->add_option("--out", o.directory, "directory for results (runs/SCENE)");
    record->add_flag("--quiet", o.quiet, "say nothing but errors");
    record->add_flag("!--no-report", o.report, "make no report.html");
    record->add_flag("--json", o.json, "print summary.json at the end");
    actions.emplace_back(record, [&o] { return record_command(o); });
    auto* const replay = app.add_subcommand("replay",
                                            "run some participants of a recorded run against the recordings "
                                            "of the others");
    replay->add_option("RUN", o.runs, "directory of a run made by sluice record")->required()->expected(1);
    replay->add_option("--only", o.names, "participants that are really started")->required();
    replay->add_option("--set", o.choice.overrides, "path=value: change the scene")->allow_extra_args(false);
    replay->add_option("--out", o.directory, "directory for results (RUN_replay)");
    replay->add_flag("--quiet", o.quiet, "say nothing but errors");
    replay->add_flag("!--no-report", o.report, "make no report.html");
    actions.emplace_back(replay, [&o] { return replay_command(o); });
}

void add_before_run(CLI::App& app, Options& o, Actions& actions)
{
    auto* const check = app.add_subcommand("check", "find every mistake of a scene without running it");
    add_scene(check, o);
    check->add_flag("--quiet", o.quiet, "say nothing but errors");
    check->add_flag("--json", o.json, "mistakes and the rehearsed schedule as JSON");
    actions.emplace_back(check, [&o] { return check_command(o); });
    auto* const graph = app.add_subcommand("graph", "the topology as DOT, or as a picture");
    add_scene(graph, o);
    graph->add_option("-o,--output", o.picture, "a file ending in .svg, .png or .pdf");
    graph->add_flag("--json", o.json, "the topology as JSON");
    actions.emplace_back(graph, [&o] { return graph_command(o); });
}

void add_keygen(CLI::App& app, Options& o, Actions& actions)
{
    auto* const keys = app.add_subcommand("keygen", "keys for participants on several hosts");
    keys->add_option("DIR", o.directory, "where they go; made if needed")->required();
    keys->add_option("SCENE|NAME", o.names, "a scene, or the names of participants")->required();
    actions.emplace_back(keys, [&o] { return keygen(o.directory, o.names); });
}

void add_schema(CLI::App& app, Options& o, Actions& actions)
{
    auto* const schema = app.add_subcommand("schema", "the keys of a scene as JSON Schema, for editors");
    schema->add_option("-o,--output", o.page, "a file instead of standard output");
    schema->add_option("--paths", o.paths_in, "instead: every path in this scene that --set can change");
    actions.emplace_back(schema, [&o] { return schema_command(o); });
}

void add_after_run(CLI::App& app, Options& o, Actions& actions)
{
    auto* const watch = app.add_subcommand("watch", "how far a run is, live; reads its status pages, opens no port");
    watch->add_option("RUN", o.runs, "directory of the run")->required()->expected(1);
    watch->add_flag("--json", o.json, "a line of JSON at every change");
    watch->add_flag("--once", o.once, "one look, then end");
    actions.emplace_back(watch, [&o] { return watch_command(o); });
    auto* const report = app.add_subcommand("report", "one self-contained page about a run, or comparing several");
    report->add_option("RUN", o.runs, "directories of runs")->required();
    report->add_option("-o,--output", o.page, "the page (report.html or comparison.html in the first directory)");
    report->add_flag("--json", o.json, "list the files of the runs as JSON");
    actions.emplace_back(report, [&o] { return report_command(o); });
}

void add_help(CLI::App& app, Options& o, Actions& actions)
{
    auto* const init = app.add_subcommand("init", "a directory with a scene to start from");
    init->add_option("TEMPLATE", o.word, "which; without: the names of all");
    init->add_option("DIR", o.directory, "where (a directory named as the template)");
    actions.emplace_back(init, [&o] { return init_command(o); });
    auto* const doctor = app.add_subcommand("doctor", "what this machine has and lacks, and what to do about it");
    doctor->add_flag("--json", o.json, "as JSON");
    actions.emplace_back(doctor, [&o] { return doctor_command(o); });
    auto* const explain = app.add_subcommand("explain", "what an exit code or a message means, and what to do");
    explain->add_option("WORD", o.word, "an exit code, a whole message or a word of it; without: everything there is");
    explain->add_flag("--json", o.json, "as JSON");
    actions.emplace_back(explain, [&o] { return explain_command(o); });
}

//! The nearest command or option, where a word on the command line is neither; empty if that was not the mistake.
std::string advice(CLI::App const& app, int argc, char** argv)
{
    if (argc < 2) return {};
    std::vector<std::string> names, options;
    CLI::App const* command = nullptr;
    for (auto const* sub : app.get_subcommands({})) {
        names.push_back(sub->get_name());
        if (sub->get_name() == argv[1]) command = sub;
    }
    if (!command && argv[1][0] != '-')
        return std::string("\"") + argv[1] + "\" is not a command." + did_you_mean(argv[1], names);
    for (auto const* option : (command ? command : &app)->get_options())
        for (auto const& name : option->get_lnames()) options.push_back("--" + name);
    for (int i = command ? 2 : 1; i < argc; ++i) {
        std::string_view word = argv[i];
        if (word == "--") break;
        word = word.substr(0, word.find('='));
        if (!word.starts_with("--") || std::find(options.begin(), options.end(), word) != options.end()) continue;
        return std::string(word) + " is not an option of " + (command ? "sluice " + command->get_name() : "sluice") +
               "." + did_you_mean(word, options);
    }
    return {};
}

int refuse(CLI::App const& app, CLI::ParseError const& error, int argc, char** argv)
{
    auto const text = advice(app, argc, argv);
    if (text.empty()) return app.exit(error) == 0 ? 0 : static_cast<int>(Exit::config);
    std::fprintf(stderr, "sluice: %s Try sluice --help.\n", text.c_str());
    return static_cast<int>(Exit::config);
}

}  // namespace

int main(int argc, char** argv)
{
    Options o;
    Actions actions;
    CLI::App app{"Sluice couples solvers that run as separate executables: grains, fluid, continuum."};
    app.require_subcommand(1);
    app.set_version_flag("--version", SLUICE_VERSION);
    add_run(app, o, actions);
    add_resume(app, o, actions);
    add_before_run(app, o, actions);
    add_schema(app, o, actions);
    add_replay(app, o, actions);
    add_keygen(app, o, actions);
    add_after_run(app, o, actions);
    add_help(app, o, actions);
    try {
        app.parse(argc, argv);
        for (auto const& [command, action] : actions)
            if (*command) return action();
        return static_cast<int>(Exit::config);
    } catch (CLI::ParseError const& e) {
        return refuse(app, e, argc, argv);
    } catch (Error const& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.exit());
    } catch (std::exception const& e) {
        std::fprintf(stderr, "sluice: %s (a bug of ours).\n", e.what());
        return static_cast<int>(Exit::internal);
    }
}
