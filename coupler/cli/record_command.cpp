#include <cstdlib>

#include "coupler/base/error.hpp"
#include "coupler/base/status_page.hpp"
#include "coupler/cli/commands.hpp"

namespace sluice {

int record_command(Options const& options)
{
    ::setenv(record_frames, "1", 1);  // every process of the run writes down what it sends
    return run_command(options);
}

int replay_command(Options options)
{
    auto const run = std::filesystem::absolute(options.runs.at(0));
    options.choice.scene = run / "scene.yaml";
    require(std::filesystem::exists(options.choice.scene), [&] {
        return Error(run.string() + ": no scene.yaml (needed: the directory of a run made by sluice record).",
                     Exit::io);
    });
    auto const loaded = load_scene(options.choice.scene, options.choice.overrides);
    loaded.diagnostics->throw_if_any();
    auto const names = loaded.scene.participant_names();
    for (auto const& alone : options.names)
        require(loaded.scene.index_of(alone) >= 0, [&] {
            return Error(options.choice.scene.string() + ": no participant \"" + alone +
                         "\" (participants: " + list_of(names) + ")." + did_you_mean(alone, names));
        });
    for (auto const& spec : loaded.scene.participants) {
        if (std::find(options.names.begin(), options.names.end(), spec.name) != options.names.end()) continue;
        auto const file = run / "recordings" / (spec.name + ".rec");
        require(std::filesystem::exists(file), [&] {
            return Error(file.string() + ": missing (needed: what \"" + spec.name +
                             "\" sent in the run; made by sluice record; of participants with one process).",
                         Exit::io);
        });
        for (auto const& group : loaded.scene.implicit)
            require(!group.has(loaded.scene.index_of(spec.name)), [&] {
                return Error(options.choice.scene.string() + ": \"" + spec.name +
                             "\" is in an implicit group: it answers what the others do, and cannot be replayed.");
            });
        auto const path = "participants." + spec.name;
        options.choice.overrides.push_back(path + (spec.command.empty() ? ".solver" : ".command") + "=sluice_replay");
        options.choice.overrides.push_back(path + ".config.recording=" + file.string());
    }
    if (options.directory.empty()) options.directory = run.string() + "_replay";
    return run_command(options);
}

}  // namespace sluice
