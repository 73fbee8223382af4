#include "coupler/scene/scene.hpp"

#include <xxhash.h>

#include <algorithm>

#include "coupler/scene/parts.hpp"

namespace sluice {
namespace {

//! The first participant that waits for nobody in its own window.
int default_pace(Scene const& scene)
{
    for (std::size_t p = 0; p < scene.participants.size(); ++p)
        if (std::none_of(scene.edges.begin(), scene.edges.end(),
                         [&](Edge const& e) { return e.to == static_cast<int>(p) && e.lag == 0; }))
            return static_cast<int>(p);
    return 0;
}

//! After the couplings: who paces a scene depends on them.
void read_time(Reader& root, Scene& scene)
{
    auto time = root.child("time");
    scene.end = time.number("end", {.above = 0.0, .unit = "s"});
    scene.window = time.number_unless("window", "auto", {.above = 0.0, .unit = "s"});
    if (scene.window && time.has("end") && *scene.window > scene.end)
        time.refuse("window", "is longer than the whole run (must be <= time.end).");
    scene.window_place = time.place("window");
    auto const pace = time.name_of_if("pace", "participant", scene.participant_names());
    scene.pace = pace ? static_cast<int>(*pace) : default_pace(scene);
    time.finish();
}

void read_gravity(Reader& root, Scene& scene)
{
    auto const g = root.numbers_or("gravity", std::vector<double>(static_cast<std::size_t>(scene.dimension), 0.0),
                                   {.unit = "m/s2"});
    std::copy(g.begin(), g.end(), scene.gravity.begin());
}

void read_data(Reader& root, Scene& scene)
{
    scene.data = vocabulary();
    for (auto& [name, reader] : root.children_if("data")) {
        DataSpec spec{name, {}, reader.flag_or("meshless", false)};
        for (auto const& known : vocabulary())
            if (known.name == name) reader.problem("", "is built in (choose another name).");
        for (auto& [column, c] : reader.children("columns")) {
            auto const shape = c.choice_or("shape", 0, {"scalar", "vector", "spin"});
            spec.columns.push_back({column, static_cast<Shape>(shape), read_unit(c)});
            if (spec.meshless && column == "position")
                c.problem("", "meshless data have no place in space. Leave the column out, or meshless.");
            c.finish();
        }
        if (spec.columns.empty() && reader.has("columns")) reader.problem("columns", "no column (at least one).");
        if (spec.columns.size() > 30) reader.problem("columns", "more than 30 columns.");
        reader.finish();
        scene.data.push_back(spec);
    }
}

void read_participants(Reader& root, LoadedScene& loaded)
{
    Scene& scene = loaded.scene;
    auto const mistakes = root.diagnostics()->problems.size();
    for (auto& [name, reader] : root.children("participants")) {
        ParticipantSpec spec;
        spec.name = name;
        if (!is_identifier(name)) reader.problem("", "not a name (letters, digits, _ and -; at most 64).");
        if (auto const& taken = reserved_names(); std::find(taken.begin(), taken.end(), name) != taken.end())
            reader.problem("", "the results have files of this name. Choose another one.");
        spec.command = reader.words("command");
        if (reader.has("command") && reader.has("solver")) reader.problem("command", "stands beside solver. Keep one.");
        spec.solver = reader.has("command") ? reader.word_if("solver") : reader.word("solver");
        if (!spec.command.empty()) spec.solver.clear();
        if (!spec.solver.empty() && !is_identifier(spec.solver))
            reader.refuse("solver", "is not the name of an executable (letters, digits, _ and -).");
        spec.host = read_host(reader);
        spec.ranks = static_cast<int>(reader.integer_or("ranks", 1, {.min = 1, .max = 256}));
        spec.place = reader.place(spec.command.empty() ? "solver" : "command");
        auto const config = reader.subtree("config");
        bool const map = config && config->IsMap();
        if (config && !map) reader.refuse("config", "(must be a mapping of keys).");
        YAML::Node const empty(YAML::NodeType::Map);
        auto const node = map ? *config : empty;
        loaded.configs.emplace_back(node, reader.key_of("config"), reader.path() + ".config", loaded.diagnostics, true);
        reader.finish();
        scene.participants.push_back(spec);
    }
    if (scene.participants.empty() && root.has("participants") && root.diagnostics()->problems.size() == mistakes)
        root.problem("participants", "nobody takes part (at least one).");
    if (scene.participants.size() > 256)
        root.problem("participants", std::to_string(scene.participants.size()) + " of them (at most 256).");
}

std::optional<Box> read_region(Reader& edge, Scene const& scene, DataSpec const* data)
{
    auto reader = edge.child_if("region");
    if (!reader) return std::nullopt;
    Box box;
    auto const d = static_cast<std::size_t>(scene.dimension);
    auto const mistakes = reader->diagnostics()->problems.size();
    auto const min = reader->numbers("min", d, {.unit = "m"}), max = reader->numbers("max", d, {.unit = "m"});
    bool const readable = reader->diagnostics()->problems.size() == mistakes;
    for (std::size_t axis = 0; axis < d && readable; ++axis) {
        if (!(min[axis] < max[axis]))
            reader->problem("max", std::string(1, "xyz"[axis]) + " is not above that of min (an empty region).");
        box.min[axis] = min[axis];
        box.max[axis] = max[axis];
    }
    reader->finish();
    bool const placed = data && std::any_of(data->columns.begin(), data->columns.end(), [](ColumnSpec const& c) {
                            return c.name == "position" && c.shape == Shape::vector;
                        });
    if (data && !placed)
        edge.problem("region", data->name + " has no column position of shape vector: its points are nowhere.");
    return box;
}

void read_edge(Reader& reader, Scene& scene)
{
    Edge edge;
    auto const before = reader.diagnostics()->problems.size();
    auto const names = scene.participant_names();
    auto const from = reader.name_of("from", "participant", names), to = reader.name_of("to", "participant", names);
    auto const data = reader.name_of("data", "data", scene.data_names());
    auto const mistakes = reader.diagnostics()->problems.size();
    edge.lag = static_cast<int>(reader.integer_or("lag", 0, {.min = 0, .max = 1}));
    bool const lag_known = reader.diagnostics()->problems.size() == mistakes;
    edge.predict = static_cast<int>(reader.choice_or("predict", 0, {"none", "linear", "quadratic"}));
    edge.sample = static_cast<Sampling>(reader.choice_or("sample", 1, {"hold", "linear"}));
    if (edge.predict > 0 && edge.lag == 0 && lag_known)
        reader.refuse("predict", "has nothing to predict without a lag (needs lag: 1).");
    if (from && from == to) reader.refuse("to", "is the same participant as \"from\".");
    edge.region = read_region(reader, scene, data ? &scene.data[*data] : nullptr);
    reader.finish();
    edge.place = reader.place("data");
    edge.path = reader.path() + ".data";
    if (!from || !to || !data || from == to) return;
    edge.from = static_cast<int>(*from);
    edge.to = static_cast<int>(*to);
    edge.data = static_cast<int>(*data);
    for (Edge const& other : scene.edges)
        if (other.from == edge.from && other.to == edge.to && other.data == edge.data)
            reader.problem("data", "this coupling stands here twice. Keep one.");
    if (reader.diagnostics()->problems.size() > before)
        edge.lag = 1;  // what was meant is not known: no part of a circle
    scene.edges.push_back(edge);
}

//! Returns whether all of them are known as they are meant.
bool read_couplings(Reader& root, Scene& scene)
{
    auto const before = root.diagnostics()->problems.size();
    for (auto& reader : root.list("couplings")) read_edge(reader, scene);
    bool const known = root.diagnostics()->problems.size() == before;
    auto const circle = lag0_circle(scene);
    if (circle.empty()) return known;
    std::string names;
    for (auto const& name : circle) names += (names.empty() ? "" : " -> ") + name;
    root.problem("couplings", "the lag-0 edges form a circle, each would wait for the other: " + names +
                                  " (give one of them lag: 1).");
    return known;
}

void read_checkpoint(Reader& root, Scene& scene)
{
    auto checkpoint = root.child_or_empty("checkpoint");
    scene.checkpoint.interval = checkpoint.number_or("interval", 600.0, {.min = 0.0, .unit = "s"});
    scene.checkpoint.windows = checkpoint.integer_or("windows", 0, {.min = 0});
    scene.checkpoint.keep = static_cast<int>(checkpoint.integer_or("keep", 2, {.min = 1, .max = 1000}));
    checkpoint.finish();
    scene.restart_on_death = root.choice_or("on-death", 0, {"stop", "restart"}) == 1;
    if (scene.restart_on_death && scene.checkpoint.interval == 0 && scene.checkpoint.windows == 0)
        root.problem("on-death", "restart without checkpoints (needs checkpoint.interval or checkpoint.windows > 0).");
    if (scene.restart_on_death && scene.transport == TransportKind::mpi)
        root.problem("on-death",
                     "restart contradicts transport: mpi (mpirun ends the whole job when one process dies). Take zmq, "
                     "shm or auto.");
}

void read_rest(Reader& root, Scene& scene)
{
    read_frame(root, scene);
    read_checkpoint(root, scene);
    auto ledger = root.child_or_empty("ledger");
    scene.ledger_tolerance = ledger.number_or("tolerance", 1e-9, {.above = 0.0, .max = 1.0});
    scene.on_violation = static_cast<OnViolation>(ledger.choice_or("on-violation", 0, {"warn", "stop", "off"}));
    auto energy = ledger.child_or_empty("energy");
    scene.energy_every = energy.integer_or("every", 199, {.min = 0});
    scene.energy_tolerance = energy.number_or("tolerance", 0.1, {.above = 0.0});
    energy.finish();
    ledger.finish();
    auto output = root.child_or_empty("output");
    scene.output_interval = output.number_or("interval", 0.0, {.min = 0.0, .unit = "s"});
    scene.series_interval = output.number_or("series", scene.output_interval, {.min = 0.0, .unit = "s"});
    scene.coarsen = static_cast<int>(output.integer_or("coarsen", 1, {.min = 1, .max = 64}));
    output.finish();
    auto timeouts = root.child_or_empty("timeouts");
    scene.connect_timeout = timeouts.number_or("connect", 60.0, {.above = 0.0, .max = 1e6, .unit = "s"});
    scene.silence_timeout = timeouts.number_or("silence", 10.0, {.min = 0.5, .max = 1e6, .unit = "s"});
    scene.window_timeout = timeouts.number_or("window", 0.0, {.min = 0.0, .max = 1e9, .unit = "s"});
    timeouts.finish();
}

void seal(LoadedScene& loaded)
{
    Scene& scene = loaded.scene;
    for (auto const& [path, value] : loaded.diagnostics->effective) scene.canonical += path + " = " + value + "\n";
    scene.hash = XXH3_64bits(scene.canonical.data(), scene.canonical.size());
}

}  // namespace

std::vector<std::string_view> const& reserved_names()
{
    static std::vector<std::string_view> const names = {"archive", "series", "summary", "scene",
                                                        "trace",   "report", "mpirun"};
    return names;
}

bool is_identifier(std::string const& name)
{
    return !name.empty() && name.size() <= 64 &&
           name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
               std::string::npos;
}

std::vector<std::string> Scene::participant_names() const
{
    std::vector<std::string> names;
    for (auto const& p : participants) names.push_back(p.name);
    return names;
}

std::vector<std::string> Scene::data_names() const
{
    std::vector<std::string> names;
    for (auto const& d : data) names.push_back(d.name);
    return names;
}

int Scene::index_of(std::string_view participant) const
{
    for (std::size_t i = 0; i < participants.size(); ++i)
        if (participants[i].name == participant) return static_cast<int>(i);
    return -1;
}

std::vector<std::string> lag0_circle(Scene const& scene)
{
    auto const n = scene.participants.size();
    std::vector<int> state(n, 0);  // 0 unseen, 1 on the path, 2 done
    std::vector<int> path;
    std::vector<std::string> circle;
    auto visit = [&](auto&& self, int p) -> bool {
        auto const at = static_cast<std::size_t>(p);
        if (state[at] == 2) return false;
        if (state[at] == 1) {
            for (auto it = std::find(path.begin(), path.end(), p); it != path.end(); ++it)
                circle.push_back(scene.participants[static_cast<std::size_t>(*it)].name);
            circle.push_back(scene.participants[at].name);
            return true;
        }
        state[at] = 1;
        path.push_back(p);
        for (Edge const& e : scene.edges)
            if (e.from == p && e.lag == 0 && self(self, e.to)) return true;
        path.pop_back();
        state[at] = 2;
        return false;
    };
    for (std::size_t p = 0; p < n; ++p)
        if (visit(visit, static_cast<int>(p))) break;
    return circle;
}

LoadedScene load_scene(std::filesystem::path const& file, std::vector<std::string> const& overrides)
{
    return load_scene_text(read_scene_file(file), file, overrides);
}

LoadedScene load_scene_text(std::string const& text, std::filesystem::path const& file,
                            std::vector<std::string> const& overrides, std::vector<Key>* keys)
{
    auto root = read_yaml(text, file.string(), overrides);
    root.diagnostics()->keys = keys;
    LoadedScene loaded;
    loaded.diagnostics = root.diagnostics();
    Scene& scene = loaded.scene;
    scene.file = file;
    scene.text = text;
    scene.overrides = overrides;
    root.integer("sluice", {.min = 1, .max = 1});
    scene.title = root.text_or("title", file.stem().string());
    scene.dimension = static_cast<int>(root.integer_or("dimension", 2, {.min = 2, .max = 3}));
    read_gravity(root, scene);
    read_data(root, scene);
    read_participants(root, loaded);
    bool const couplings_known = read_couplings(root, scene);
    read_time(root, scene);
    read_implicit(root, scene, couplings_known);
    read_network(root, scene);
    read_rest(root, scene);
    root.finish_collecting();
    seal(loaded);
    return loaded;
}

}  // namespace sluice
