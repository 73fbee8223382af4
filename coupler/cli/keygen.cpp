#include "coupler/cli/keygen.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"
#include "coupler/transport/keys.hpp"

namespace sluice {
namespace {

std::vector<std::string> names_of(std::vector<std::string> const& scene_or_names)
{
    if (scene_or_names.size() != 1 || is_identifier(scene_or_names[0])) return scene_or_names;
    auto const loaded = load_scene(scene_or_names[0], {});
    auto names = loaded.scene.participant_names();
    if (names.empty()) loaded.diagnostics->throw_if_any();
    require(!names.empty(), [&] { return Error(scene_or_names[0] + ": no participants (needed: a scene)."); });
    return names;
}

void make_directory(std::filesystem::path const& directory)
{
    if (!directory.parent_path().empty()) {
        std::error_code ignored;  // mkdir() says what is wrong
        std::filesystem::create_directories(directory.parent_path(), ignored);
    }
    bool const there = ::mkdir(directory.c_str(), 0700) == 0 || errno == EEXIST;
    require(there, [&] { return Error(directory.string() + ": " + std::strerror(errno) + ".", Exit::io); });
    struct stat info = {};
    bool const safe = ::stat(directory.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && (info.st_mode & 022) == 0;
    require(safe, [&] {
        return Error(directory.string() +
                         ": not a directory that only its owner can change (needed for keys). Use "
                         "another one.",
                     Exit::security);
    });
}

}  // namespace

int keygen(std::filesystem::path const& directory, std::vector<std::string> const& scene_or_names)
{
    auto names = names_of(scene_or_names);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    for (auto const& name : names)
        require(is_identifier(name), [&] {
            return Error("keygen: \"" + name + "\" cannot name a participant (letters, digits, _ and -).");
        });
    make_directory(directory);
    require_no_keys(directory, names);
    for (auto const& name : names) make_key_pair(directory, name);
    std::printf(
        "%s: keys of %zu participants. Each host needs this directory with all NAME.public and only the\n"
        "NAME.secret of the participants that run there; in the scene: security: {keys: %s}\n",
        directory.c_str(), names.size(), directory.c_str());
    return 0;
}

}  // namespace sluice
