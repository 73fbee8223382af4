#include <algorithm>
#include <cstdio>

#include "coupler/base/error.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/collect.hpp"
#include "coupler/cli/commands.hpp"

namespace sluice {
namespace {

using std::filesystem::path;

//! Every result of a run, hidden files aside: path below the run's directory and size in bytes.
nlohmann::ordered_json files_of(path const& run)
{
    std::vector<std::pair<std::string, std::uintmax_t>> found;
    for (auto it = std::filesystem::recursive_directory_iterator(run); it != decltype(it)(); ++it) {
        if (it->path().filename().string().starts_with("."))
            it.disable_recursion_pending();
        else if (it->is_regular_file())
            found.emplace_back(it->path().lexically_relative(run).string(), it->file_size());
    }
    std::sort(found.begin(), found.end());
    auto files = nlohmann::ordered_json::array();
    for (auto const& [name, bytes] : found) files.push_back({{"file", name}, {"bytes", bytes}});
    return files;
}

}  // namespace

int report_command(Options o)
{
    if (o.page.empty()) o.page = o.runs[0] / (o.runs.size() == 1 ? "report.html" : "comparison.html");
    for (auto const& run : o.runs)
        require(std::filesystem::exists(run / "summary.json"),
                [&] { return Error(run.string() + ": no summary.json (needed: the directory of a run).", Exit::io); });
    std::string why_not;
    require(make_report(o.runs, o.page, why_not), [&] { return Error(why_not, Exit::io); });
    if (!o.json) {
        std::printf("%s\n", o.page.c_str());
        return 0;
    }
    nlohmann::ordered_json answer = {{"page", o.page.string()}, {"runs", nlohmann::ordered_json::array()}};
    for (auto const& run : o.runs) answer["runs"].push_back({{"directory", run.string()}, {"files", files_of(run)}});
    print_json(answer);
    return 0;
}

}  // namespace sluice
