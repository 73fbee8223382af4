#include <charconv>
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

//! One YAML document, or an empty node for an empty text. Throws YAML::Exception on bad syntax.
YAML::Node load_one(std::string const& text, std::string const& where)
{
    auto documents = YAML::LoadAll(text);
    require(documents.size() <= 1,
            [&] { return Error(where + ": " + std::to_string(documents.size()) + " YAML documents (needed: one)."); });
    return documents.empty() ? YAML::Node() : documents[0];
}

//! The child of a mapping or list by its key or index; an undefined node if there is none.
YAML::Node child_of(YAML::Node const& node, std::string const& name)
{
    if (node.IsMap()) return node[name];
    std::size_t index = 0;
    auto const [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
    bool const number = error == std::errc() && end == name.data() + name.size();
    if (node.IsSequence() && number && index < node.size()) return node[index];
    return YAML::Node(YAML::NodeType::Undefined);
}

//! Sets `path=value` in the tree; a path's parts are keys or list indices. The last key may be new, its parents may
//! not.
void apply_override(YAML::Node const& root, std::string const& text)
{
    auto const split = text.find('=');
    require(split != std::string::npos && split > 0,
            [&] { return Error("--set " + text + ": no \"=\" (needed: path=value, e.g. time.end=0.1)."); });
    std::stringstream parts(text.substr(0, split));
    std::vector<std::string> names;
    for (std::string part; std::getline(parts, part, '.');) names.push_back(part);
    YAML::Node node = root;
    for (std::size_t i = 0; i < names.size(); ++i) {
        bool const last = i + 1 == names.size();
        bool const there = (node.IsMap() || node.IsSequence()) && child_of(node, names[i]).IsDefined();
        require(there || (last && node.IsMap()),
                [&] { return Error("--set " + text + ": \"" + names[i] + "\" is not in the scene. Check the path."); });
        if (!last) node.reset(child_of(node, names[i]));
    }
    try {
        auto const value = load_one(text.substr(split + 1), "--set " + text);
        if (node.IsSequence())
            node[std::stoul(names.back())] = value;
        else
            node[names.back()] = value;
    } catch (YAML::Exception const& e) {
        throw Error("--set " + text + ": " + e.msg + ".");
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

//! The line (1-based) of the first byte that is not UTF-8; 0: there is none.
int line_of_foreign_byte(std::string const& text)
{
    int line = 1, following = 0;
    for (unsigned char const c : text) {
        bool const continues = (c & 0xc0) == 0x80;
        if (continues != (following > 0)) return line;
        following = continues            ? following - 1
                    : c < 0x80           ? 0
                    : (c & 0xe0) == 0xc0 ? 1
                    : (c & 0xf0) == 0xe0 ? 2
                    : (c & 0xf8) == 0xf0 ? 3
                                         : -1;
        if (following < 0) return line;
        line += c == '\n';
    }
    return following > 0 ? line : 0;
}

}  // namespace

Reader read_yaml(std::string const& text, std::string const& file, std::vector<std::string> const& overrides)
{
    require(text.size() <= largest_text,
            [&] { return Error(file + ": larger than 1 MB (a scene is a few kB). Is it the right file?"); });
    int const foreign = line_of_foreign_byte(text);
    require(foreign == 0, [&] {
        return Error(file + ":" + std::to_string(foreign) + ":1: not UTF-8 in this line. Save the file as UTF-8.");
    });
    YAML::Node root;
    try {
        root = load_one(text, file);
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
        count_nodes(root, 0, nodes = 0, file);
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
