#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>

#include "coupler/base/error.hpp"
#include "coupler/scene/reader.hpp"
#include "coupler/scene/syntax.hpp"

namespace sluice {
namespace {

constexpr std::size_t largest_text = 1u << 20;  // bytes; yaml-cpp looks keys up linearly, 1e5 keys take 0.7 s
constexpr int deepest = 32;
constexpr int most_nodes = 100'000;

std::string place_of(YAML::Mark const& mark, Diagnostics const& where)
{
    return where.file + ":" + std::to_string(mark.line + 1) + ":" +
           std::to_string(where.column(mark.line + 1, mark.column));
}

//! Counts what a recursive reader would visit: an alias bomb expands here and is stopped, not in the readers. Shown at
//! the key of the scene (`top`) that it is in: where an alias stands is not known.
void count_nodes(YAML::Node const& node, int depth, int& nodes, Diagnostics const& where, YAML::Mark const& top)
{
    require(depth <= deepest, [&] {
        return Error(place_of(node.Mark(), where) + ": nested deeper than " + std::to_string(deepest) +
                     " levels. Flatten the scene.");
    });
    require(++nodes <= most_nodes, [&] {
        return Error(place_of(top, where) + ": more than " + std::to_string(most_nodes) +
                     " nodes, aliases expanded. Shorten the scene.");
    });
    if (node.IsMap())
        for (auto const& entry : node)
            count_nodes(entry.second, depth + 1, nodes, where, depth == 0 ? entry.first.Mark() : top);
    else if (node.IsSequence())
        for (auto const& item : node) count_nodes(item, depth + 1, nodes, where, top);
}

//! The line (1-based) of the `---` that begins a second document whose content is at `mark`, if there is one.
std::optional<std::size_t> second_document(std::string const& text, YAML::Mark const& mark)
{
    std::size_t line = 1;
    std::optional<std::size_t> found;
    for (std::size_t at = 0; at < text.size() && static_cast<int>(line) <= mark.line + 1; ++line) {
        if (text.compare(at, 3, "---") == 0) found = line;
        at = std::min(text.find('\n', at), text.size() - 1) + 1;
    }
    return found;
}

//! Counts the documents of a text, and where the last one started.
class Documents : public YAML::EventHandler
{
 public:
    int count = 0;
    YAML::Mark start;

    void OnDocumentStart(YAML::Mark const& mark) override { ++count, start = mark; }
    void OnDocumentEnd() override {}
    void OnNull(YAML::Mark const&, YAML::anchor_t) override {}
    void OnAlias(YAML::Mark const&, YAML::anchor_t) override {}
    void OnScalar(YAML::Mark const&, std::string const&, YAML::anchor_t, std::string const&) override {}
    void OnSequenceStart(YAML::Mark const&, std::string const&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(YAML::Mark const&, std::string const&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnMapEnd() override {}
};

//! One YAML document, or an empty node for an empty text. Throws YAML::Exception on bad syntax. `where` turns a mark
//! into the place that a message starts with. Not LoadAll(): yaml-cpp 0.7 finds documents without end where a text goes
//! on with a stray `,` or `]`.
template <class Where>
YAML::Node load_one(std::string const& text, Where&& where)
{
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Documents documents;
    while (documents.count < 2 && parser.HandleNextDocument(documents)) continue;
    require(documents.count < 2, [&] {
        auto mark = documents.start;
        auto const line = second_document(text, mark);
        if (!line) return Error(where(mark) + ": the text goes on after its YAML document (needed: one document).");
        mark.line = static_cast<int>(*line) - 1;
        mark.column = 0;
        return Error(where(mark) + ": 2 YAML documents or more (needed: one). Remove this line and what follows.");
    });
    return YAML::Load(text);
}

//! What a message of the parser often comes from.
std::string hint_of(std::string const& message)
{
    if (message == YAML::ErrorMsg::MAP_VALUE)
        return " A text with \": \" in it needs quotes; a key needs a line of its own.";
    if (message.find("flow not found") != message.npos) return " Is a comma missing before this?";
    if (message == YAML::ErrorMsg::END_OF_MAP) return " Is this line indented like those that it belongs to?";
    if (message == YAML::ErrorMsg::UNKNOWN_TOKEN) return " Put the text in quotes.";
    return "";
}

//! The message about a text that is no YAML, at the quote or bracket that was left open if that is what it is about.
Error syntax_error(YAML::Exception const& e, Diagnostics const& where)
{
    if (auto const tab = tab_before(where.text, e.mark.line))
        return Error(where.file + ":" + std::to_string(e.mark.line + 1) + ":" + std::to_string(*tab + 1) +
                     ": a tab indents this line (YAML takes spaces alone: " + e.msg + "). Use spaces.");
    bool const open = e.msg == YAML::ErrorMsg::EOF_IN_SCALAR || e.msg.find("not found") != e.msg.npos;
    auto const opening = open ? open_before(where.text, e.mark.line, e.mark.column) : std::nullopt;
    if (!opening) return Error(place_of(e.mark, where) + ": " + e.msg + " (the text is not YAML)." + hint_of(e.msg));
    YAML::Mark mark;
    mark.line = opening->line;
    mark.column = opening->offset;
    return Error(place_of(mark, where) + ": this " + opening->sign +
                 " is not closed on its line (the text is not YAML: " + e.msg + " in line " +
                 std::to_string(e.mark.line + 1) + "). Close it.");
}

//! The last scalar of a tree in the order of the text, keys included.
void find_last(YAML::Node const& node, YAML::Node& last)
{
    if (node.IsScalar() && node.Mark().pos >= last.Mark().pos) last.reset(node);
    if (node.IsMap())
        for (auto const& entry : node) find_last(entry.first, last), find_last(entry.second, last);
    else if (node.IsSequence())
        for (auto const& item : node) find_last(item, last);
}

//! The parser takes a line end for the end of a quoted text that is not closed, if nothing follows: it looks away.
void require_last_quote_closed(YAML::Node const& root, Diagnostics const& where)
{
    YAML::Node last(YAML::NodeType::Scalar);
    find_last(root, last);
    if (last.Tag() != "!") return;
    auto const end = where.text.find_last_not_of(" \t\r\n");
    std::string_view const whole(where.text.data(), end + 1);
    auto const lines = std::count(whole.begin(), whole.end(), '\n');
    auto const line_begin = whole.rfind('\n') + 1;  // npos + 1 is 0
    auto const mark = last.Mark();
    bool const lone = lines == mark.line && static_cast<int>(whole.size() - line_begin) == mark.column + 1;
    bool closed = !lone;
    try {
        if (closed) YAML::Load(std::string(whole));
    } catch (YAML::Exception const&) {
        closed = false;
    }
    require(closed, [&] { return Error(place_of(mark, where) + ": this quote is not closed. Close it."); });
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

//! The tree with another value at a path that is there, or with one more key at its end. What lies on the path is made
//! anew, with the same other children: what an alias of it shows does not change.
YAML::Node with_value(YAML::Node const& node, std::span<std::string const> path, YAML::Node const& value)
{
    if (path.empty()) return value;
    YAML::Node copy(node.Type());
    copy.SetStyle(node.Style());
    bool placed = false;
    std::size_t index = 0;
    if (node.IsSequence())
        for (auto const& item : node)
            copy.push_back(std::to_string(index++) == path[0] ? with_value(item, path.subspan(1), value)
                                                              : YAML::Node(item));
    else
        for (auto const& entry : node) {
            bool const here = !placed && entry.first.IsScalar() && entry.first.Scalar() == path[0];
            placed = placed || here;
            copy.force_insert(entry.first, here ? with_value(entry.second, path.subspan(1), value) : entry.second);
        }
    if (node.IsMap() && !placed)
        copy.force_insert(path[0], with_value(YAML::Node(YAML::NodeType::Map), path.subspan(1), value));
    return copy;
}

//! Makes sure that a path is in the scene, or may be made there: a new key or a block of keys that looks like none that
//! is there. Who reads the scene refuses keys that nobody knows.
void require_path(YAML::Node const& root, std::vector<std::string> const& names, std::string const& text)
{
    YAML::Node node = root;
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto const child = node.IsMap() || node.IsSequence() ? child_of(node, names[i]) : YAML::Node();
        bool const there = (node.IsMap() || node.IsSequence()) && child.IsDefined();
        bool const last = i + 1 == names.size();
        if (there) {
            if (!last) node.reset(child);
            continue;
        }
        if (last && node.IsMap()) return;
        std::vector<std::string> known;
        if (node.IsMap())
            for (auto const& entry : node)
                if (entry.first.IsScalar()) known.push_back(entry.first.Scalar());
        auto const hint = did_you_mean(names[i], known);
        require(node.IsMap() && hint.empty(), [&] {
            return Error("--set " + text + ": \"" + names[i] + "\" is not in the scene." +
                         (hint.empty() ? " Check the path." : hint));
        });
        return;
    }
}

//! Sets `path=value` in the tree; a path's parts are keys or list indices. The nodes on the path forget where they
//! stood in the text if there are aliases, so only then are they copied.
void apply_override(YAML::Node& root, std::string const& text, bool aliases)
{
    auto const split = text.find('=');
    require(split != std::string::npos && split > 0,
            [&] { return Error("--set " + text + ": no \"=\" (needed: path=value, e.g. time.end=0.1)."); });
    std::stringstream parts(text.substr(0, split));
    std::vector<std::string> names;
    for (std::string part; std::getline(parts, part, '.');) names.push_back(part);
    require_path(root, names, text);
    try {
        auto const value = load_one(text.substr(split + 1), [&](YAML::Mark const&) { return "--set " + text; });
        if (aliases) {
            root.reset(with_value(root, names, value));
            return;
        }
        YAML::Node node = root;
        for (std::size_t i = 0; i + 1 < names.size(); ++i) {
            if (!child_of(node, names[i]).IsDefined()) node[names[i]] = YAML::Node(YAML::NodeType::Map);
            node.reset(child_of(node, names[i]));
        }
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
    auto diagnostics = std::make_shared<Diagnostics>();
    diagnostics->read(file, text);
    YAML::Node root;
    try {
        root = load_one(text, [&](YAML::Mark const& mark) { return place_of(mark, *diagnostics); });
    } catch (YAML::Exception const& e) {
        throw syntax_error(e, *diagnostics);
    }
    int nodes = 0;
    count_nodes(root, 0, nodes, *diagnostics, root.Mark());
    require_last_quote_closed(root, *diagnostics);
    require(root.IsMap(), [&] {
        bool const nowhere = root.Mark().is_null();  // a text of nothing, or of comments alone
        auto const place = nowhere ? file + ":1:1" : place_of(root.Mark(), *diagnostics);
        return Error(place + ": not a mapping of keys (a scene starts with \"sluice: 1\").");
    });
    for (auto const& change : overrides) {
        apply_override(root, change, text.find('*') != std::string::npos);
        diagnostics->overridden.push_back(reader_path(change));
        count_nodes(root, 0, nodes = 0, *diagnostics, root.Mark());
    }
    return {root, root, "", diagnostics, true};
}

std::string read_scene_file(std::filesystem::path const& file)
{
    std::ifstream in(file, std::ios::binary);
    require(in.good() && !std::filesystem::is_directory(file),
            [&] { return Error(file.string() + ": cannot be read (needed: a scene in YAML). Check the path."); });
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

Reader read_yaml_file(std::filesystem::path const& file, std::vector<std::string> const& overrides)
{
    return read_yaml(read_scene_file(file), file.string(), overrides);
}

}  // namespace sluice
