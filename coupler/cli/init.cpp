#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "coupler/base/error.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/cli/schema.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

using std::filesystem::path;

//! The directories below share/sluice/templates, by name.
std::vector<std::string> templates(path const& home)
{
    std::vector<std::string> names;
    std::error_code none;
    for (auto const& entry : std::filesystem::directory_iterator(home, none))
        if (entry.is_directory()) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    require(!names.empty(), [&] {
        return Error(home.string() + ": no templates (needed: share/sluice/templates of the installation).", Exit::io);
    });
    return names;
}

}  // namespace

int init_command(Options o)
{
    auto const home = own_directory() / "../share/sluice/templates";
    auto const names = templates(home);
    if (o.word.empty()) {
        for (auto const& name : names) std::printf("%s\n", name.c_str());
        return 0;
    }
    require(std::find(names.begin(), names.end(), o.word) != names.end(), [&] {
        return Error("sluice init " + o.word + ": no such template (templates: " + list_of(names) + ")." +
                     did_you_mean(o.word, names));
    });
    if (o.directory.empty()) o.directory = o.word;
    std::vector<std::pair<path, std::string>> files{{"scene.schema.json", scene_schema().dump(1) + "\n"}};
    for (auto const& entry : std::filesystem::directory_iterator(home / o.word))
        files.emplace_back(entry.path().filename(), read_file(entry.path()));
    for (auto const& [name, text] : files)
        require(!std::filesystem::exists(o.directory / name), [&, &file = name] {
            return Error((o.directory / file).string() +
                             ": is there already (nothing is overwritten). Name another "
                             "directory: sluice init " +
                             o.word + " DIR.",
                         Exit::io);
        });
    for (auto const& [name, text] : files) write_atomically(o.directory / name, text);
    std::printf("%s\n", fmt::format("{0}: ready. Look at {0}/scene.yaml, then: cd {0} && sluice check scene.yaml && "
                                    "sluice run scene.yaml",
                                    o.directory.string())
                            .c_str());
    return 0;
}

}  // namespace sluice
