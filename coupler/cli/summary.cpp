#include "coupler/cli/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;
using std::filesystem::path;

constexpr char const* seconds[] = {"compute_seconds", "wait_seconds", "exchange_seconds", "wall_seconds"};

Json read_object(path const& file)
{
    if (!std::filesystem::exists(file)) return nullptr;
    auto found = Json::parse(read_file(file), nullptr, false);
    return found.is_object() ? found : Json(nullptr);
}

double number(Json const& object, char const* key)
{
    auto const found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::int64_t integer(Json const& object, char const* key)
{
    auto const found = object.find(key);
    return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

//! What a process said of this part of the run, with seconds and bytes of its earlier parts added.
Json of_member(path const& directory, std::string const& member, int earlier)
{
    Json own = read_object(directory / ".sluice" / (member + ".json"));
    if (own.is_null()) return own;
    for (int part = 0; part < earlier; ++part) {
        auto const before = read_object(part_summary(directory, member, part));
        if (before.is_null()) continue;
        for (auto const* key : seconds) own[key] = number(own, key) + number(before, key);
        own["bytes_sent"] = integer(own, "bytes_sent") + integer(before, "bytes_sent");
        auto const waits = before.value("waits_for", Json::object());
        for (auto const& [name, waited] : waits.items())
            if (waited.is_number())
                own["waits_for"][name] = number(own["waits_for"], name.c_str()) + waited.get<double>();
    }
    return own;
}

//! One entry from what the ranks of a participant said.
Json merged(ParticipantSpec const& spec, std::vector<Json> const& ranks)
{
    auto const said = [](Json const& r) { return !r.is_null(); };
    if (std::none_of(ranks.begin(), ranks.end(), said))
        return {{"name", spec.name}, {"solver", spec.solver}, {"exit", nullptr}};
    if (ranks.size() == 1) return ranks[0];
    Json const* busiest = nullptr;
    for (auto const& rank : ranks)
        if (said(rank) && (!busiest || number(rank, seconds[0]) > number(*busiest, seconds[0]))) busiest = &rank;
    Json entry = *busiest;
    entry["name"] = spec.name;
    entry["bytes_sent"] = 0;
    entry["warnings"] = Json::array();
    auto listed = Json::array();
    if (said(ranks[0])) entry["facts"] = ranks[0].value("facts", Json::object());
    for (auto const& rank : ranks) {
        if (!said(rank)) {
            entry["exit"] = nullptr;
            continue;
        }
        listed.push_back(rank);
        entry["bytes_sent"] = integer(entry, "bytes_sent") + integer(rank, "bytes_sent");
        if (!entry["exit"].is_null()) entry["exit"] = std::max(integer(entry, "exit"), integer(rank, "exit"));
        auto const warnings = rank.value("warnings", Json::array());
        for (auto const& warning : warnings)
            if (warning.is_string())
                entry["warnings"].push_back(rank.value("name", "") + ": " + warning.get<std::string>());
    }
    entry["ranks"] = listed;
    return entry;
}

//! What messages travelled by, as the participants said: "shm", or "shm, zmq" where they differ.
std::string transport_of(Scene const& scene, Json const& participants)
{
    std::vector<std::string> kinds;
    for (auto const& p : participants)
        if (auto const kind = p.value("transport", ""); !kind.empty()) kinds.push_back(kind);
    std::sort(kinds.begin(), kinds.end());
    kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
    std::string text;
    for (auto const& kind : kinds) text += (text.empty() ? "" : ", ") + kind;
    constexpr char const* asked[] = {"auto", "shm", "zmq", "mpi"};
    return text.empty() ? asked[static_cast<int>(scene.transport)] : text;
}

}  // namespace

Json summarise(Scene const& scene, path const& directory, RunEnding const& ending, std::vector<double> const& parts)
{
    Json participants = Json::array();
    std::int64_t windows = 0;
    double window_seconds = 0, end_time = 0;
    auto const members = members_of_crew(scene);
    int const earlier = std::max(0, static_cast<int>(parts.size()) - 1);
    for (std::size_t p = 0; p < scene.participants.size(); ++p) {
        std::vector<Json> ranks;
        for (auto const& member : members)
            if (member.participant == static_cast<int>(p)) ranks.push_back(of_member(directory, member.name, earlier));
        participants.push_back(merged(scene.participants[p], ranks));
        auto const& entry = participants.back();
        windows = std::max(windows, integer(entry, "windows"));
        window_seconds = std::max(window_seconds, number(entry, "window_seconds"));
        end_time = std::max(end_time, number(entry, "end_time"));
    }
    Json summary = {{"title", scene.title},
                    {"scene", scene.file.filename().string()},
                    {"dimension", scene.dimension},
                    {"gravity", std::vector<double>(scene.gravity.begin(), scene.gravity.begin() + scene.dimension)},
                    {"windows", windows},
                    {"window_seconds", window_seconds},
                    {"end_time", end_time},
                    {"wall_seconds", std::accumulate(parts.begin(), parts.end(), 0.0)},
                    {"exit", ending.exit},
                    {"message", ending.message},
                    {"version", SLUICE_VERSION},
                    {"scene_hash", fmt::format("{:016x}", scene.hash)},
                    {"transport", transport_of(scene, participants)},
                    {"participants", participants}};
    if (parts.size() > 1) summary["parts"] = parts;
    if (ending.restarts > 0) summary["restarts"] = ending.restarts;
    return summary;
}

}  // namespace sluice
