#include "coupler/cli/check.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/base/scratch_directory.hpp"
#include "coupler/base/window_line.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

std::string words_of(double x)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", x);
    return text;
}

//! The solvers that came with this command, as candidates for a misspelt one: a list, because the folder of an
//! installed `sluice` is full of other people's executables.
std::vector<std::string> solvers_here()
{
    std::ifstream list(own_directory() / "../share/sluice/solvers");
    std::vector<std::string> names;
    for (std::string name; std::getline(list, name);)
        if (!find_executable((own_directory() / name).string()).empty()) names.push_back(name);
    return names;
}

//! The package for want of which a solver of ours was left out when this command was built; empty: it was not. Somebody
//! else's program of that name may be on PATH.
std::string package_missing_for(ParticipantSpec const& spec)
{
    if (spec.solver.empty() || !find_executable((own_directory() / spec.solver).string()).empty()) return {};
    std::ifstream list(own_directory() / "../share/sluice/left_out");
    for (std::string name, package; list >> name >> package;)
        if (name == spec.solver) return package;
    return {};
}

void require_executables(LoadedScene& loaded)
{
    auto const here = solvers_here();
    std::string list;
    for (auto const& name : here) list += (list.empty() ? "" : ", ") + name;
    for (auto const& spec : loaded.scene.participants) {
        auto problem = spec.place;
        if (auto const package = package_missing_for(spec); !package.empty()) {
            problem.text = "participants." + spec.name + ".solver = " + spec.solver +
                           ": was left out when this sluice was built, for want of the package " + package +
                           ". Install it, then build again.";
            loaded.diagnostics->problems.push_back(problem);
            continue;
        }
        auto const name = program_of(spec)[0];
        if (name.empty() || !find_executable(name).empty()) continue;
        auto const near = nearest(name, here);
        problem.text = "participants." + spec.name + (spec.solver.empty() ? ".command" : ".solver") + " = " + name +
                       ": no such executable (solvers here: " + list + "; others are looked for on PATH)." +
                       (near ? " Did you mean " + *near + "?" : "");
        loaded.diagnostics->problems.push_back(problem);
    }
}

//! `LINE:COLUMN: text` or `--set: text`, as it follows `FILE:` in a message; nothing if it is something else.
std::optional<Problem> to_problem(std::string_view text)
{
    constexpr std::string_view set = " --set: ";
    if (text.starts_with(set)) return Problem{1, 1, std::string(text.substr(set.size()))};
    Problem problem;
    for (int* number : {&problem.line, &problem.column}) {
        auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
        if (error != std::errc() || end == text.data() + text.size() || *end != ':') return std::nullopt;
        text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
    }
    if (!text.starts_with(' ')) return std::nullopt;
    problem.text = text.substr(1);
    return problem;
}

//! `file:line:column: text` lines of a participant become problems; anything else is given back.
std::string take_problems(std::string const& output, Diagnostics& diagnostics)
{
    std::istringstream lines(output);
    std::string rest;
    auto const prefix = diagnostics.file + ":";
    for (std::string line; std::getline(lines, line);) {
        auto const problem =
            line.starts_with(prefix) ? to_problem(std::string_view(line).substr(prefix.size())) : std::nullopt;
        if (!problem) {
            rest += line + "\n";
            continue;
        }
        bool const known = std::any_of(diagnostics.problems.begin(), diagnostics.problems.end(), [&](Problem const& p) {
            return p.line == problem->line && p.column == problem->column && p.text == problem->text;
        });
        if (!known) diagnostics.problems.push_back(*problem);
    }
    return rest;
}

//! What a participant proposes as window, taken out of what it says.
std::optional<WindowLine> take_window(std::string& output)
{
    std::istringstream lines(output);
    std::string rest;
    std::optional<WindowLine> found;
    for (std::string line; std::getline(lines, line);)
        if (auto const window = to_window_line(line))
            found = window;
        else
            rest += line + "\n";
    output = rest;
    return found;
}

using Proposals = std::vector<std::pair<std::string, WindowLine>>;

//! The window of a run by the rule of coupler/handshake.cpp: the scene's, else the longest exact one, else the
//! shortest.
std::optional<double> window_of(Scene const& scene, Proposals const& proposals)
{
    double exact = 0, bound = 0;
    for (auto const& [name, line] : proposals)
        if (line.exact)
            exact = std::max(exact, line.seconds);
        else
            bound = bound == 0 ? line.seconds : std::min(bound, line.seconds);
    if (scene.window) return scene.window;
    if (exact > 0) return exact;
    return bound > 0 ? std::optional(std::min(bound, scene.end)) : std::nullopt;
}

//! Every window must be a whole number of the steps of those who cannot do otherwise.
void require_whole_steps(LoadedScene& loaded, Proposals const& proposals, std::optional<double> window)
{
    if (!window || !loaded.diagnostics->problems.empty()) return;
    for (auto const& [name, line] : proposals) {
        double const ratio = *window / line.seconds;
        if (!line.exact || (ratio > 0.5 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio)) continue;
        auto problem = loaded.scene.window_place;
        problem.text = "time.window = " + words_of(*window) + " s is no whole number of the steps of \"" + name +
                       "\" (" + words_of(line.seconds) + " s). " +
                       (loaded.scene.window ? "Use auto." : "Give two of the solvers steps that divide each other.");
        loaded.diagnostics->problems.push_back(problem);
    }
}

//! How a participant's check ended; one that takes longer than a minute does not know --check and is ended.
std::optional<Ending> wait_a_minute(Process& process)
{
    auto const deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!process.poll(std::chrono::seconds(1)))
        if (std::chrono::steady_clock::now() > deadline) return std::nullopt;
    return process.poll();
}

}  // namespace

std::vector<std::string> program_of(ParticipantSpec const& spec)
{
    auto words = spec.command.empty() ? std::vector{spec.solver} : spec.command;
    auto const found = words[0].empty() ? std::filesystem::path() : find_executable(words[0]);
    if (!found.empty()) words[0] = found.string();
    return words;
}

CheckedScene check_scene(SceneChoice const& choice)
{
    CheckedScene checked{load_scene(choice.scene, choice.overrides), {}, {}};
    Scene const& scene = checked.loaded.scene;
    require_executables(checked.loaded);
    ScratchDirectory const answers("sluice-check");  // a file for each participant's answer
    std::vector<std::pair<std::string, Process>> running;
    for (auto const& spec : scene.participants) {
        auto argv = program_of(spec);
        if (!is_identifier(spec.name) || argv[0].empty() || find_executable(argv[0]).empty()) continue;
        if (!package_missing_for(spec).empty()) continue;
        for (std::string const& word : {scene.file.string(), std::string("--as"), spec.name, std::string("--out"),
                                        (answers.path() / "run").string(), std::string("--check")})
            argv.push_back(word);
        for (auto const& change : choice.overrides) argv.insert(argv.end(), {"--set", change});
        running.emplace_back(spec.name, Process(argv, answers.path() / spec.name));
    }
    std::string broken;
    Proposals proposals;
    for (auto& [name, process] : running) {
        auto const ending = wait_a_minute(process);
        auto rest = take_problems(read_file(answers.path() / name), *checked.loaded.diagnostics);
        if (auto const line = take_window(rest)) proposals.emplace_back(name, *line);
        auto const what = !ending               ? std::string("it does not end (does it know --check?)")
                          : ending->signal != 0 ? "signal " + std::to_string(ending->signal)
                                                : "exit " + std::to_string(ending->code);
        if (ending && ending->well())
            checked.remarks.push_back(rest);
        else if (!ending || ending->code != static_cast<int>(Exit::config) || !rest.empty())
            broken += (broken.empty() ? "" : "\n") +
                      ("participant \"" + name + "\" cannot check its configuration: " + what) +
                      (rest.empty() ? "." : ": " + rest);
    }
    checked.window = window_of(scene, proposals);
    require_whole_steps(checked.loaded, proposals, checked.window);
    checked.loaded.diagnostics->throw_if_any();
    require(broken.empty(), [&] { return Error(broken); });
    return checked;
}

}  // namespace sluice
