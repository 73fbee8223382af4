#include "coupler/scene/reader.hpp"

#include <algorithm>
#include <map>

#include "coupler/scene/words.hpp"

namespace sluice {

using words::is_nowhere;
using words::seen;

namespace {

constexpr std::size_t most_problems = 1000;  // of one document; nobody reads on

//! No control characters: a scene must not speak to the terminal.
std::string printable(std::string text)
{
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
    return text;
}

}  // namespace

Reader::Reader(YAML::Node node, YAML::Node key, std::string path, std::shared_ptr<Diagnostics> diagnostics,
               bool outermost)
    : node_(node), key_(key), path_(std::move(path)), diagnostics_(std::move(diagnostics)), outermost_(outermost)
{
    if (!node_.IsMap()) return;
    std::map<std::string, YAML::Mark> seen;  // yaml-cpp keeps duplicate keys in silence, the first wins
    for (auto const& entry : node_) {
        if (!entry.first.IsScalar()) {
            record(entry.first.Mark(), (path_.empty() ? "" : path_ + ": ") + "a key must be a word.");
            continue;
        }
        auto const name = entry.first.Scalar();
        auto const [first, is_new] = seen.emplace(name, entry.first.Mark());
        if (!is_new)
            record(entry.first.Mark(), path_of(name) + " is given twice (first in line " +
                                           std::to_string(first->second.line + 1) + "). Keep one.");
    }
}

std::string Reader::path_of(std::string_view key) const
{
    return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

YAML::Node Reader::key_node(std::string_view key) const
{
    for (auto const& entry : node_)
        if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.first;
    return key_;
}

std::optional<YAML::Node> Reader::find(std::string_view key)
{
    asked_.emplace(key);
    if (!node_.IsMap()) return std::nullopt;
    for (auto const& entry : node_)
        if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.second;
    return std::nullopt;
}

bool Reader::has(std::string_view key) const
{
    return node_.IsMap() && node_[std::string(key)].IsDefined();
}
bool Reader::is_scalar(std::string_view key) const
{
    return has(key) && node_[std::string(key)].IsScalar();
}
bool Reader::is_list(std::string_view key) const
{
    return has(key) && node_[std::string(key)].IsSequence();
}

std::vector<std::string> Reader::keys() const
{
    std::vector<std::string> names;
    if (node_.IsMap())
        for (auto const& entry : node_)
            if (entry.first.IsScalar()) names.push_back(entry.first.Scalar());
    return names;
}

//! Where a value stands; for a block mapping or list the parser only knows its first item, so it is where the key is.
YAML::Mark Reader::value_mark(std::string_view key, YAML::Node const& value) const
{
    auto const key_mark = key_node(key).Mark();
    bool const written_null = value.IsNull() && value.Mark().line == key_mark.line;
    bool const block = !value.IsScalar() && !written_null && value.Style() != YAML::EmitterStyle::Flow;
    return block || is_nowhere(value.Mark()) ? key_mark : value.Mark();
}

Problem Reader::at(YAML::Mark const& mark) const
{
    if (is_nowhere(mark)) return {};
    return {mark.line + 1, diagnostics_->column(mark.line + 1, mark.column), ""};
}

Problem Reader::place(std::string_view key) const
{
    return at(key_node(key).Mark());
}

std::optional<YAML::Node> Reader::subtree(std::string_view key)
{
    learn(key, {.kind = Key::Kind::open, .path = {}});
    return find(key);
}

void Reader::record(YAML::Mark const& mark, std::string const& text)
{
    if (diagnostics_->problems.size() >= most_problems) return;
    auto problem = at(mark);
    problem.text = printable(text);
    for (Problem const& p : diagnostics_->problems)
        if (p.line == problem.line && p.column == problem.column && p.text == problem.text) return;
    diagnostics_->problems.push_back(problem);
}

void Reader::missing(std::string_view key, std::string_view needed)
{
    std::string const hint = [&]() -> std::string {
        std::vector<std::string> unknown;
        for (auto const& name : keys())
            if (!asked_.contains(name)) unknown.push_back(name);
        auto const near = nearest(key, unknown);
        return near ? " Is \"" + *near + "\" meant?" : "";
    }();
    auto mark = key_.Mark();
    if (is_nowhere(mark)) mark = node_.Mark();
    record(mark, path_of(key) + " is missing (" + std::string(needed) + ")." + hint);
}

void Reader::problem(std::string_view key, std::string const& text)
{
    asked_.emplace(key);
    if (key.empty()) {
        auto const mark = is_nowhere(key_.Mark()) ? node_.Mark() : key_.Mark();
        record(mark, (path_.empty() ? "" : path_ + ": ") + text);
    } else
        record(key_node(key).Mark(), path_of(key) + ": " + text);
}

void Reader::refuse(std::string_view key, std::string const& text)
{
    auto const node = find(key);
    if (!node) return problem(key, text);
    record(value_mark(key, *node), path_of(key) + " = " + seen(*node) + " " + text);
}

void Reader::warn(std::string_view key, std::string const& text)
{
    auto const node = find(key);
    auto warning = node ? at(value_mark(key, *node)) : place(key);
    warning.text = printable(path_of(key) + (node ? " = " + seen(*node) + " " : ": ") + text);
    if (diagnostics_->warnings.size() < most_problems) diagnostics_->warnings.push_back(warning);
}

void Reader::learn(std::string_view key, Key what) const
{
    if (!diagnostics_->keys) return;
    what.path = key.empty() ? path_ : path_of(key);
    diagnostics_->keys->push_back(std::move(what));
}

Reader Reader::child(std::string_view key)
{
    learn(key, {.kind = Key::Kind::mapping, .path = {}, .required = true});
    if (auto found = find_child(key)) return *found;
    if (!has(key)) missing(key, "a mapping of keys");
    return nothing_at(key);
}

Reader Reader::nothing_at(std::string_view key) const
{
    return {YAML::Node(YAML::NodeType::Map), key_node(key), path_of(key), std::make_shared<Diagnostics>(), false};
}

Reader Reader::child_or_empty(std::string_view key)
{
    if (auto found = child_if(key)) return *found;
    return {YAML::Node(YAML::NodeType::Map), key_node(key), path_of(key), diagnostics_, false};
}

std::optional<Reader> Reader::child_if(std::string_view key)
{
    learn(key, {.kind = Key::Kind::mapping, .path = {}});
    return find_child(key);
}

std::optional<Reader> Reader::find_child(std::string_view key)
{
    auto const node = find(key);
    if (!node) return std::nullopt;
    if (!node->IsMap()) {
        refuse(key, "(must be a mapping of keys).");
        return std::nullopt;
    }
    return Reader(*node, key_node(key), path_of(key), diagnostics_, false);
}

std::vector<Reader> Reader::list(std::string_view key)
{
    learn(key, {.kind = Key::Kind::list, .path = {}});
    std::vector<Reader> readers;
    auto const node = find(key);
    if (!node) return readers;
    if (!node->IsSequence()) {
        refuse(key, "(must be a list of mappings).");
        return readers;
    }
    for (std::size_t i = 0; i < node->size(); ++i) {
        auto const path = path_of(key) + "[" + std::to_string(i) + "]";
        auto const item = (*node)[i];
        if (item.IsMap())
            readers.emplace_back(item, item, path, diagnostics_, false);
        else
            record(item.Mark(), path + " = " + seen(item) + " (must be a mapping of keys).");
    }
    return readers;
}

std::vector<std::pair<std::string, Reader>> Reader::children(std::string_view key)
{
    learn(key, {.kind = Key::Kind::named, .path = {}, .required = true});
    if (!has(key)) missing(key, "a mapping of names");
    return find_children(key);
}

std::vector<std::pair<std::string, Reader>> Reader::children_if(std::string_view key)
{
    learn(key, {.kind = Key::Kind::named, .path = {}});
    return find_children(key);
}

std::vector<std::pair<std::string, Reader>> Reader::find_children(std::string_view key)
{
    std::vector<std::pair<std::string, Reader>> found;
    auto parent = find_child(key);
    if (!parent) return found;
    for (auto const& name : parent->keys()) {
        bool const seen = std::any_of(found.begin(), found.end(), [&](auto const& f) { return f.first == name; });
        if (seen) continue;  // given twice: already a problem
        auto reader = parent->find_child(name);
        found.emplace_back(name, reader ? *reader : parent->nothing_at(name));  // the name is there, others speak of it
    }
    return found;
}

void Reader::finish()
{
    finish_collecting();
    if (outermost_) diagnostics_->throw_if_any();
}

void Reader::finish_collecting()
{
    if (!node_.IsMap()) return;
    std::vector<std::string> known;
    for (auto const& key : asked_)
        if (!key.empty()) known.push_back(key);
    for (auto const& entry : node_) {
        if (!entry.first.IsScalar() || asked_.contains(entry.first.Scalar())) continue;
        if (diagnostics_->problems.size() >= most_problems) return;
        auto const name = entry.first.Scalar();
        record(entry.first.Mark(),
               path_of(name) + " is not a key (keys: " + list_of(known) + ")." + did_you_mean(name, known));
    }
}

}  // namespace sluice
