#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "coupler/base/error.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/hosts.hpp"
#include "coupler/cli/rehearsal.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;

std::string joined(std::vector<std::string> const& words, char const* between)
{
    std::string text;
    for (auto const& word : words) text += (text.empty() ? "" : between) + word;
    return text;
}

//! What the rehearsal shows that is no mistake, as it follows `warning: `.
std::vector<std::string> remarks_on(Scene const& scene, Rehearsal const& rehearsal)
{
    std::vector<std::string> remarks;
    for (auto const& name : rehearsal.alone)
        remarks.push_back("participant \"" + name + "\" has no coupling: it runs beside the others. Is one missing?");
    for (auto const& name : rehearsal.unread)
        remarks.push_back("nobody reads what \"" + name + "\" computes: it follows the others only.");
    for (auto const& name : rehearsal.leading)
        remarks.push_back("\"" + name + "\" reads nobody: nothing that the others do acts on it.");
    if (!scene.window) return remarks;
    double const windows = scene.end / *scene.window;
    if (std::abs(windows - std::round(windows)) > 1e-9 * std::max(1.0, windows))
        remarks.push_back(
            fmt::format("time.end = {:.10g} s is no whole number of windows of {:.10g} s: the last one ends "
                        "at {:.10g} s.",
                        scene.end, *scene.window, std::ceil(windows) * *scene.window));
    return remarks;
}

std::string scheme(Rehearsal const& rehearsal)
{
    auto const chain = joined(rehearsal.critical, " -> ");
    if (rehearsal.critical.size() < 2) return "all participants compute at once";
    return fmt::format("one after the other in a window: {} ({:.3g} computations long)", chain,
                       rehearsal.units_per_window);
}

Json as_json(CheckedScene const& checked, Rehearsal const& rehearsal, std::vector<std::string> const& remarks)
{
    Json warnings = Json::array();
    for (auto const& line : checked.loaded.diagnostics->sorted(checked.loaded.diagnostics->warnings))
        warnings.push_back(mistakes_of(line)[0]);
    for (auto const& text : remarks) warnings.push_back({{"text", text}});
    Json solvers = Json::object();  // all of them have answered, in the scene's order, else there were mistakes
    for (std::size_t p = 0; p < checked.remarks.size(); ++p)
        solvers[checked.loaded.scene.participants.at(p).name] = checked.remarks[p];
    return {{"scene", checked.loaded.scene.file.string()},
            {"ok", true},
            {"mistakes", Json::array()},
            {"warnings", warnings},
            {"solvers", solvers},
            {"window_seconds", checked.window ? Json(*checked.window) : Json(nullptr)},
            {"schedule", {{"critical", rehearsal.critical}, {"computations_per_window", rehearsal.units_per_window}}}};
}

void require_no_deadlock(Scene const& scene, Rehearsal const& rehearsal)
{
    require(rehearsal.waits.empty(), [&] {
        return Error(scene.file.string() + ": deadlock: " + joined(rehearsal.waits, "; ") +
                     " (nobody can go on). Give one of these couplings lag: 1.");
    });
}

//! Who waits for whom in a scene that was refused, if its participants would all wait.
std::vector<std::string> waits_in(SceneChoice const& choice)
{
    try {
        return rehearse(load_scene(choice.scene, choice.overrides).scene).waits;
    } catch (Error const&) {  // no YAML, no file: already said
        return {};
    }
}

int check(Options const& o)
{
    auto const checked = check_scene(o.choice);
    auto const& diagnostics = *checked.loaded.diagnostics;
    Scene const& scene = checked.loaded.scene;
    auto const rehearsal = rehearse(scene);
    require_no_deadlock(scene, rehearsal);
    if (!scene.remote.empty()) require_hosts(scene, {});  // else they are started by hand, wherever that is
    auto const remarks = remarks_on(scene, rehearsal);
    if (o.json) {
        print_json(as_json(checked, rehearsal, remarks));
        return 0;
    }
    for (auto const& line : diagnostics.sorted(diagnostics.warnings)) std::printf("%s (a warning)\n", line.c_str());
    for (auto const& text : remarks) std::printf("%s: warning: %s\n", scene.file.c_str(), text.c_str());
    if (!o.quiet) {
        for (auto const& remark : checked.remarks) std::fputs(remark.c_str(), stdout);
        if (checked.window)
            std::printf("%s\n", fmt::format("{:.0f} windows of {:.6g} s", std::ceil(scene.end / *checked.window - 1e-9),
                                            *checked.window)
                                    .c_str());
        if (scene.participants.size() > 1) std::printf("%s\n", scheme(rehearsal).c_str());
    }
    std::printf("%s: ok\n", o.choice.scene.c_str());
    return 0;
}

}  // namespace

int check_command(Options const& o)
{
    try {
        return check(o);
    } catch (Error const& e) {
        auto const waits = waits_in(o.choice);
        if (o.json)
            print_json({{"scene", o.choice.scene.string()},
                        {"ok", false},
                        {"exit", static_cast<int>(e.exit())},
                        {"mistakes", mistakes_of(e.what())},
                        {"waits", waits}});
        else {
            std::fprintf(stderr, "%s\n", e.what());
            for (auto const& wait : waits) std::fprintf(stderr, "  deadlock: %s\n", wait.c_str());
        }
        return static_cast<int>(e.exit());
    }
}

}  // namespace sluice
