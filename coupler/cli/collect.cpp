#include "coupler/cli/collect.hpp"

#include <fmt/format.h>

#include <cmath>

#include "coupler/base/error.hpp"
#include "coupler/cli/summary.hpp"
#include "coupler/record/archive.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/record/collection.hpp"
#include "coupler/record/table.hpp"
#include "coupler/record/trace.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;
using std::filesystem::path;

//! The files that exist of all participants and of their processes, by ending: "grains.csv", "water:1.csv", ...
std::vector<std::pair<std::string, path>> files_of(Scene const& scene, path const& directory, char const* ending)
{
    std::vector<std::pair<std::string, path>> found;
    for (auto const& spec : scene.participants)
        if (auto const file = directory / (spec.name + ending); std::filesystem::exists(file))
            found.emplace_back(spec.name, file);
    for (auto const& member : members_of_crew(scene))
        if (auto const file = directory / (member.name + ending);
            member.name.find(':') != member.name.npos && std::filesystem::exists(file))
            found.emplace_back(member.name, file);
    return found;
}

std::vector<path> paths_of(std::vector<std::pair<std::string, path>> const& named)
{
    std::vector<path> paths;
    for (auto const& [name, file] : named) paths.push_back(file);
    return paths;
}

}  // namespace

Json collect(Scene const& scene, path const& directory, RunEnding const& ending, std::vector<double> const& parts)
{
    auto const summary = summarise(scene, directory, ending, parts);
    write_atomically(directory / "summary.json", summary.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    std::vector<TablePart> tables;
    for (auto const& [name, file] : files_of(scene, directory, ".csv"))
        if (name != "series") tables.push_back({name, file});
    if (!tables.empty()) merge_tables(tables, directory / "series.csv");
    if (auto const series = paths_of(files_of(scene, directory, ".pvd")); !series.empty())
        merge_collections(series, directory / (scene.file.stem().string() + ".pvd"));
    std::vector<ArchiveLink> links;
    for (auto const& [name, file] : files_of(scene, directory, ".h5")) links.push_back({name, file.filename()});
    for (auto const& [name, file] : files_of(scene, directory, ".measures.h5"))
        links.push_back({name + ".measures", file.filename()});
    if (!links.empty()) link_archives(directory / "archive.h5", links);
    std::vector<path> traces;
    for (auto const& member : members_of_crew(scene))
        if (auto const file = directory / ".sluice" / (member.name + ".trace.json"); std::filesystem::exists(file))
            traces.push_back(file);
    if (!traces.empty()) merge_traces(traces, directory / "trace.json");
    return summary;
}

namespace {

//! "water -> grains: load: staggering makes 0.4 % of the work moved ..." for each process that looked at an edge.
std::string work_lines(Json const& participant)
{
    std::string text;
    for (auto const& rank : participant.value("ranks", Json::array())) text += work_lines(rank);
    for (auto const& entry : participant.value("ledger", Json::array())) {
        auto const energy = entry.value("energy", Json::object());
        double const moved = energy.value("moved [J]", 0.0), made = energy.value("made [J]", 0.0);
        auto const windows = energy.value("windows", std::int64_t{0});
        if (windows == 0 || !(moved > 0)) continue;
        text +=
            fmt::format("{}: staggering {} {:.2g} % of the work moved ({} windows looked at)\n",
                        entry.value("edge", ""), made < 0 ? "takes" : "makes", 100 * std::abs(made) / moved, windows);
    }
    return text;
}

}  // namespace

std::string time_table(Json const& summary)
{
    double const wall = summary.value("wall_seconds", 0.0);
    std::string text = fmt::format("{:<16} {:<8} {:>10} {:>20} {:>20} {:>20}\n", "participant", "solver", "wall s",
                                   "compute s", "wait s", "exchange s");
    for (auto const& p : summary.at("participants")) {
        double const own = p.value("wall_seconds", 0.0);
        auto cell = [&](char const* key) {
            double const s = p.value(key, 0.0);
            return fmt::format("{:.2f} ({:4.1f} %)", s, own > 0 ? 100 * s / own : 0.0);
        };
        text += fmt::format("{:<16} {:<8} {:>10.2f} {:>20} {:>20} {:>20}\n", p.value("name", ""),
                            path(p.value("solver", "")).filename().string(), own, cell("compute_seconds"),
                            cell("wait_seconds"), cell("exchange_seconds"));
    }
    for (auto const& p : summary.at("participants")) text += work_lines(p);
    return text + fmt::format("{} windows of {:.6g} s in {:.1f} s\n", summary.value("windows", std::int64_t{0}),
                              summary.value("window_seconds", 0.0), wall);
}

bool make_report(std::vector<path> const& runs, path const& page, std::string& why_not)
{
    auto const script = own_directory() / "../share/sluice/report/report.py";
    std::vector<std::string> argv{"/usr/bin/python3", script.string()};
    for (auto const& run : runs) argv.push_back(run.string());
    argv.insert(argv.end(), {"--out", page.string()});
    auto const log = page.string() + ".log";
    bool well = false;
    try {
        well = Process(argv, log).wait().well();
    } catch (Error const&) {  // no Python: said below
    }
    if (!well)
        why_not = "no report: " + last_lines(log, 3) +
                  "\n  (needed: the packages python3-numpy, python3-h5py and python3-matplotlib).";
    std::filesystem::remove(log);
    return well;
}

}  // namespace sluice
