#include "participants/liggghts/source.hpp"

#include <fstream>
#include <utility>

#include "coupler/base/error.hpp"
#include "coupler/scene/beside_scene.hpp"
#include "participants/liggghts/script.hpp"

namespace liggghts {
namespace {

using dem::Measure;

void refuse(sluice::Reader& reader, std::vector<Refusal> const& refusals)
{
    for (auto const& [key, text] : refusals) reader.problem(key, text);
    reader.diagnostics()->throw_if_any();
}

//! Measures of grains whose laws we do not know: what their places say.
void read_what_places_say(sluice::Reader& reader, dem::Config& config)
{
    config.measures = dem::read_measures(reader, config);
    bool const stated = config.measures.stated;
    for (Measure const m : {Measure::energies, Measure::drift, Measure::force_chains}) {
        if (stated && config.measures[m].wanted)
            reader.problem("measures",
                           "asks for energies, drift or force_chains, but the laws of a script are not "
                           "known here. Leave them out, or have the script print its own.");
        config.measures[m].wanted = false;
    }
    if (!stated) config.measures[Measure::contacts].wanted = false;  // the walls of a script are not known
}

}  // namespace

Source read_source(sluice::Reader reader, int dimension, dem::Vec3 gravity)
{
    Source source;
    if (!reader.has("script")) {
        source.config = dem::read_config(reader, dimension, gravity);
        refuse(reader, refusals(source.config));
        return source;
    }
    source.script = sluice::beside_scene(reader, reader.text("script"));
    if (!std::filesystem::exists(source.script)) reader.refuse("script", "cannot be read: there is no such file.");
    source.config.dimension = dimension;
    source.config.gravity = gravity;
    source.config.density = 1.0;  // nobody asks: the script says each grain's
    source.config.step = reader.number("step", {.above = 0.0, .max = 1.0, .unit = "s"});
    read_what_places_say(reader, source.config);
    reader.finish();
    return source;
}

void run_script(Engine& engine, std::filesystem::path const& script, std::filesystem::path const& restart)
{
    std::ifstream in(script);
    sluice::require(in.good(), [&] {
        return sluice::Error(script.string() + ": cannot be read. Check the path and its permissions.",
                             sluice::Exit::io);
    });
    auto const of_ours = [&](std::string const& name, std::string const& value) {
        engine.command("variable " + name + " string \"" + value + "\"", "variable " + name);
    };
    of_ours("resumed", restart.empty() ? "0" : "1");
    of_ours("restart", restart.empty() ? "none" : restart.string());
    of_ours("folder", std::filesystem::absolute(script).parent_path().string());
    std::string command;
    int begun = 0, number = 0;
    for (std::string line; std::getline(in, line);) {
        ++number;
        if (command.empty()) begun = number;
        auto const last = line.find_last_not_of(" \t\r");
        line.erase(last == std::string::npos ? 0 : last + 1);
        if (!line.empty() && line.back() == '&') {  // the command goes on
            command += line.substr(0, line.size() - 1);
            continue;
        }
        command += line;
        if (!command.empty()) engine.command(command, script.string() + ":" + std::to_string(begun));
        command.clear();
    }
    if (!command.empty()) engine.command(command, script.string() + ":" + std::to_string(begun));
}

}  // namespace liggghts
