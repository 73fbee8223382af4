#include "coupler/scene/scene.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

//! Names of files that a run's directory has for itself.
constexpr std::string_view reserved[] = {"archive", "series", "summary", "scene", "trace", "report", "mpirun"};

//! tcp://127.A.B.C:PORT, with numbers only: a name could lead anywhere.
bool is_loopback(std::string const& address)
{
    int part[3] = {}, port = 0, length = 0;
    int const found =
        std::sscanf(address.c_str(), "tcp://127.%3d.%3d.%3d:%5d%n", &part[0], &part[1], &part[2], &port, &length);
    bool const whole = found == 4 && static_cast<std::size_t>(length) == address.size();
    return whole && std::all_of(part, part + 3, [](int p) { return p >= 0 && p < 256; }) && port >= 1024 &&
           port <= 65000;
}

std::vector<std::string> participant_names(Scene const& scene)
{
    std::vector<std::string> names;
    for (auto const& p : scene.participants) names.push_back(p.name);
    return names;
}

void read_time(Reader& root, Scene& scene)
{
    auto time = root.child("time");
    scene.end = time.number("end", {.above = 0.0, .unit = "s"});
    if (time.is_scalar("window") && time.subtree("window")->Scalar() == "auto")
        ;  // the solvers choose
    else
        scene.window = time.number_if("window", {.above = 0.0, .unit = "s"});
    if (scene.window && *scene.window > scene.end)
        time.problem("window", "longer than the whole run (must be <= time.end).");
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
    if (!root.has("data")) return;
    for (auto& [name, reader] : root.children("data")) {
        DataSpec spec{name, {}};
        for (auto const& known : vocabulary())
            if (known.name == name) reader.problem("", "is built in (choose another name).");
        for (auto& [column, c] : reader.children("columns")) {
            auto const shape = c.choice_or("shape", 0, {"scalar", "vector", "spin"});
            spec.columns.push_back({column, static_cast<Shape>(shape), c.text("unit")});
            c.finish();
        }
        if (spec.columns.empty()) reader.problem("columns", "no column (at least one).");
        if (spec.columns.size() > 30) reader.problem("columns", "more than 30 columns.");
        reader.finish();
        scene.data.push_back(spec);
    }
}

void read_command(Reader& reader, ParticipantSpec& spec)
{
    auto const node = reader.subtree("command");
    if (!node) return;
    if (node->IsScalar()) spec.command.push_back(node->Scalar());
    if (node->IsSequence())
        for (auto const& word : *node) spec.command.push_back(word.IsScalar() ? word.Scalar() : "");
    bool const whole = std::none_of(spec.command.begin(), spec.command.end(), [](auto const& w) { return w.empty(); });
    if (spec.command.empty() || !whole)
        reader.problem("command", "must be a program, or a list: program and arguments.");
}

void read_participants(Reader& root, LoadedScene& loaded)
{
    Scene& scene = loaded.scene;
    for (auto& [name, reader] : root.children("participants")) {
        ParticipantSpec spec{.name = name, .solver = {}, .command = {}, .host = {}, .place = {}};
        if (!is_identifier(name)) reader.problem("", "not a name (letters, digits, _ and -; at most 64).");
        if (std::find(std::begin(reserved), std::end(reserved), name) != std::end(reserved))
            reader.problem("", "the results have files of this name. Choose another one.");
        read_command(reader, spec);
        if (spec.command.empty()) spec.solver = reader.text("solver");
        if (!spec.solver.empty() && !is_identifier(spec.solver))
            reader.problem("solver", "not the name of an executable (letters, digits, _ and -).");
        spec.place = reader.place(spec.command.empty() ? "solver" : "command");
        auto const config = reader.subtree("config");
        bool const map = config && config->IsMap();
        if (config && !map) reader.problem("config", "must be a mapping of keys.");
        YAML::Node const empty(YAML::NodeType::Map);
        auto const node = map ? *config : empty;
        loaded.configs.emplace_back(node, reader.key_of("config"), reader.path() + ".config", loaded.diagnostics, true);
        reader.finish();
        scene.participants.push_back(spec);
    }
    if (root.has("participants") && scene.participants.empty())
        root.problem("participants", "nobody takes part (at least one).");
}

int find_participant(Reader& edge, std::string_view key, Scene const& scene)
{
    auto const name = edge.text(key);
    int const index = scene.index_of(name);
    if (index < 0 && !name.empty()) {
        auto const near = nearest(name, participant_names(scene));
        edge.problem(key, "no participant \"" + name + "\"." + (near ? " Did you mean " + *near + "?" : ""));
    }
    return index;
}

void read_edge(Reader& reader, Scene& scene)
{
    Edge edge;
    edge.from = find_participant(reader, "from", scene);
    edge.to = find_participant(reader, "to", scene);
    std::vector<std::string_view> names;
    for (auto const& d : scene.data) names.push_back(d.name);
    edge.data = static_cast<int>(reader.choice("data", names));
    auto const mistakes = reader.diagnostics()->problems.size();
    edge.lag = static_cast<int>(reader.integer_or("lag", 0, {.min = 0, .max = 1}));
    bool const lag_known = reader.diagnostics()->problems.size() == mistakes;
    bool const predicts = reader.has("predict");
    edge.predict = static_cast<int>(reader.choice_or("predict", 0, {"none", "linear", "quadratic"}));
    edge.sample = static_cast<Sampling>(reader.choice_or("sample", 1, {"hold", "linear"}));
    if (predicts && edge.predict > 0 && edge.lag == 0 && lag_known)
        reader.problem("predict", "without a lag there is nothing to predict (needs lag: 1).");
    if (edge.from >= 0 && edge.from == edge.to) reader.problem("to", "the same participant as \"from\".");
    reader.finish();
    edge.place = reader.place("data");
    edge.path = reader.path() + ".data";
    if (edge.from < 0 || edge.to < 0) return;
    for (Edge const& other : scene.edges)
        if (other.from == edge.from && other.to == edge.to && other.data == edge.data)
            reader.problem("data", "this coupling stands here twice. Keep one.");
    scene.edges.push_back(edge);
}

void read_couplings(Reader& root, Scene& scene)
{
    for (auto& reader : root.list("couplings")) read_edge(reader, scene);
    auto const circle = lag0_circle(scene);
    if (circle.empty()) return;
    std::string names;
    for (auto const& name : circle) names += (names.empty() ? "" : " -> ") + name;
    root.problem("couplings", "the lag-0 edges form a circle, each would wait for the other: " + names +
                                  " (give one of them lag: 1).");
}

void read_rest(Reader& root, Scene& scene)
{
    if (root.is_scalar("frame"))
        root.choice_or("frame", 0, {"inertial"});
    else if (root.has("frame"))
        root.problem("frame", "must be inertial: no solver here runs in a rotating frame.");
    scene.transport = static_cast<TransportKind>(root.choice_or("transport", 0, {"auto", "shm", "zmq", "mpi"}));
    scene.address = root.text_or("address", "ipc");
    if (scene.address == "ipc") scene.address.clear();
    if (!scene.address.empty() && scene.transport == TransportKind::mpi)
        root.problem("address", "has no meaning with transport: mpi. Leave it out.");
    if (!scene.address.empty() && !is_loopback(scene.address))
        root.problem("address", "= " + scene.address +
                                    " (must be ipc or tcp://127.0.0.1:PORT, PORT from 1024 to 65000; " +
                                    "beyond this host frames would travel unencrypted).");
    if (auto output = root.child_if("output")) {
        scene.output_interval = output->number_or("interval", 0.0, {.min = 0.0, .unit = "s"});
        scene.series_interval = output->number_or("series", scene.output_interval, {.min = 0.0, .unit = "s"});
        scene.coarsen = static_cast<int>(output->integer_or("coarsen", 1, {.min = 1, .max = 64}));
        output->finish();
    }
    if (auto timeouts = root.child_if("timeouts")) {
        scene.connect_timeout = timeouts->number_or("connect", 60.0, {.above = 0.0, .max = 1e6, .unit = "s"});
        scene.silence_timeout = timeouts->number_or("silence", 10.0, {.min = 0.5, .max = 1e6, .unit = "s"});
        timeouts->finish();
    }
}

void seal(LoadedScene& loaded)
{
    Scene& scene = loaded.scene;
    for (auto const& [path, value] : loaded.diagnostics->effective) scene.canonical += path + " = " + value + "\n";
    scene.hash = XXH3_64bits(scene.canonical.data(), scene.canonical.size());
}

std::string read_text(std::filesystem::path const& file)
{
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

}  // namespace

bool is_identifier(std::string const& name)
{
    return !name.empty() && name.size() <= 64 &&
           name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
               std::string::npos;
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
    auto root = read_yaml_file(file, overrides);
    LoadedScene loaded;
    loaded.diagnostics = root.diagnostics();
    Scene& scene = loaded.scene;
    scene.file = file;
    scene.text = read_text(file);
    scene.overrides = overrides;
    root.integer("sluice", {.min = 1, .max = 1});
    scene.title = root.text_or("title", file.stem().string());
    scene.dimension = static_cast<int>(root.integer_or("dimension", 2, {.min = 2, .max = 3}));
    read_gravity(root, scene);
    read_time(root, scene);
    read_data(root, scene);
    read_participants(root, loaded);
    read_couplings(root, scene);
    read_rest(root, scene);
    root.finish_collecting();
    seal(loaded);
    return loaded;
}

}  // namespace sluice
