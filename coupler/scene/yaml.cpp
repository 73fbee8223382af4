#include <fstream>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/scene/reader.hpp"

namespace sluice {
namespace {

constexpr std::size_t largest_text = 1u << 20;  // bytes; yaml-cpp looks keys up linearly, 1e5 keys take 0.7 s
constexpr int deepest = 32;
constexpr int most_nodes = 100'000;

//! Counts what a recursive reader would visit: an alias bomb expands here and is stopped, not in the readers.
void count_nodes(YAML::Node const& node, int depth, int& nodes, std::string const& file)
{
    auto const place = file + ":" + std::to_string(node.Mark().line + 1) + ":" + std::to_string(node.Mark().column + 1);
    require(depth <= deepest, [&] {
        return Error(place + ": nested deeper than " + std::to_string(deepest) + " levels. Flatten the scene.");
    });
    require(++nodes <= most_nodes, [&] {
        return Error(place + ": more than " + std::to_string(most_nodes) +
                     " nodes, aliases expanded. Shorten the scene.");
    });
    if (node.IsMap())
        for (auto const& entry : node) count_nodes(entry.second, depth + 1, nodes, file);
    else if (node.IsSequence())
        for (auto const& item : node) count_nodes(item, depth + 1, nodes, file);
}

//! Sets `path=value` in the tree; a path's parts are keys or list indices. The last key may be new, its parents may
//! not.
void apply_override(YAML::Node const& root, std::string const& text)
{
    auto const split = text.find('=');
    require(split != std::string::npos && split > 0,
            [&] { return Error("--set " + text + ": no \"=\" (needed: path=value, e.g. time.end=0.1)."); });
    YAML::Node node = root;
    std::stringstream parts(text.substr(0, split));
    std::vector<std::string> names;
    for (std::string part; std::getline(parts, part, '.');) names.push_back(part);
    auto fail = [&](std::string const& part) {
        throw Error("--set " + text + ": \"" + part + "\" is not in the scene. Check the path.");
    };
    for (std::size_t i = 0; i < names.size(); ++i) {
        bool const last = i + 1 == names.size();
        YAML::Node next;
        if (node.IsSequence()) {
            std::size_t index = 0;
            try {
                index = std::stoul(names[i]);
            } catch (std::exception const&) {
                fail(names[i]);
            }
            if (index >= node.size()) fail(names[i]);
            next.reset(node[index]);
        } else if (node.IsMap()) {
            if (!last && !node[names[i]]) fail(names[i]);
            next.reset(node[names[i]]);
        } else
            fail(names[i]);
        if (last) {
            try {
                next = YAML::Load(text.substr(split + 1));
            } catch (YAML::Exception const& e) {
                throw Error("--set " + text + ": " + e.msg + ".");
            }
        }
        node.reset(next);
    }
}

//! The path of an override as readers write it: "couplings.1.lag=0" -> "couplings[1].lag".
std::string reader_path(std::string const& change)
{
    std::stringstream parts(change.substr(0, change.find('=')));
    std::string path;
    for (std::string part; std::getline(parts, part, '.');) {
        bool const index = !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
        path += index ? "[" + part + "]" : (path.empty() ? "" : ".") + part;
    }
    return path;
}

}  // namespace

Reader read_yaml(std::string const& text, std::string const& file, std::vector<std::string> const& overrides)
{
    require(text.size() <= largest_text,
            [&] { return Error(file + ": larger than 1 MB (a scene is a few kB). Is it the right file?"); });
    YAML::Node root;
    try {
        auto documents = YAML::LoadAll(text);
        require(documents.size() <= 1, [&] {
            return Error(file + ": " + std::to_string(documents.size()) + " YAML documents (needed: one).");
        });
        if (!documents.empty()) root = documents[0];
    } catch (YAML::Exception const& e) {
        throw Error(file + ":" + std::to_string(e.mark.line + 1) + ":" + std::to_string(e.mark.column + 1) + ": " +
                    e.msg + " (the text is not YAML).");
    }
    int nodes = 0;
    count_nodes(root, 0, nodes, file);
    require(root.IsMap(),
            [&] { return Error(file + ":1:1: not a mapping of keys (a scene starts with \"sluice: 1\")."); });
    auto diagnostics = std::make_shared<Diagnostics>();
    diagnostics->file = file;
    for (auto const& change : overrides) {
        apply_override(root, change);
        diagnostics->overridden.push_back(reader_path(change));
    }
    return {root, root, "", diagnostics, true};
}

Reader read_yaml_file(std::filesystem::path const& file, std::vector<std::string> const& overrides)
{
    std::ifstream in(file, std::ios::binary);
    require(in.good() && !std::filesystem::is_directory(file),
            [&] { return Error(file.string() + ": cannot be read (needed: a scene in YAML). Check the path."); });
    std::stringstream text;
    text << in.rdbuf();
    return read_yaml(text.str(), file.string(), overrides);
}

}  // namespace sluice
