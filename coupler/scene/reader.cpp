#include "coupler/scene/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

std::string shown(double x)
{
    char text[32];
    auto const end = std::to_chars(text, text + sizeof text, x).ptr;
    return {text, end};
}

//! The whole of `text` as a decimal number; YAML's octal "012" and words such as "1e-5x" are not numbers here.
std::optional<double> to_number(std::string const& text)
{
    char const* first = text.data();
    char const* const last = first + text.size();
    if (first != last && *first == '+') ++first;
    double value = 0;
    auto const [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || first == last) return std::nullopt;
    return value;
}

std::string described(Bounds const& b)
{
    std::string text = "a finite number";
    auto add = [&, first = true](double bound, char const* sign) mutable {
        if (!std::isfinite(bound)) return;
        text = (first ? "" : text + " and ") + (first ? "must be " : "") + sign + shown(bound);
        first = false;
    };
    add(b.above, "> ");
    add(b.min, ">= ");
    add(b.max, "<= ");
    add(b.below, "< ");
    return text;
}

std::string quoted_list(std::vector<std::string_view> const& words)
{
    std::string text;
    for (auto word : words) text += (text.empty() ? "" : ", ") + std::string(word);
    return text;
}

std::string scalar_or_kind(YAML::Node const& node)
{
    if (node.IsScalar()) return node.Scalar();
    return node.IsMap() ? "a mapping" : node.IsSequence() ? "a list" : "nothing";
}

//! A node that is not in the file: a missing one.
bool is_nowhere(YAML::Mark const& mark)
{
    return mark.is_null() || mark.line < 0;
}

}  // namespace

void Diagnostics::throw_if_any() const
{
    if (problems.empty()) return;
    auto sorted = problems;
    std::stable_sort(sorted.begin(), sorted.end(), [](Problem const& a, Problem const& b) {
        return std::pair(a.line, a.column) < std::pair(b.line, b.column);
    });
    std::string text;
    auto place = [&](Problem const& p) {
        for (std::string const& path : overridden)
            if (p.text.starts_with(path) &&
                (p.text.size() == path.size() ||
                 std::string_view(" .:[").find(p.text[path.size()]) != std::string_view::npos))
                return file + ": --set";
        return file + ":" + std::to_string(p.line) + ":" + std::to_string(p.column);
    };
    auto const same = [&](Problem const& a, Problem const& b) { return a.text == b.text && place(a) == place(b); };
    sorted.erase(std::unique(sorted.begin(), sorted.end(), same), sorted.end());
    for (Problem const& p : sorted) text += (text.empty() ? "" : "\n") + place(p) + ": " + p.text;
    throw Error(text, Exit::config);
}

std::optional<std::string> nearest(std::string_view word, std::vector<std::string> const& candidates)
{
    auto distance = [](std::string_view a, std::string_view b) {  // Damerau-Levenshtein, adjacent swaps count 1
        std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
        for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
        std::iota(d[0].begin(), d[0].end(), std::size_t{0});
        for (std::size_t i = 1; i <= a.size(); ++i)
            for (std::size_t j = 1; j <= b.size(); ++j) {
                d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
                if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                    d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
            }
        return d[a.size()][b.size()];
    };
    std::optional<std::string> best;
    std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2);  // farther is no typo
    if (word.size() <= 3) best_distance = 1;
    for (auto const& candidate : candidates) {
        bool const prefix = word.size() >= 3 && candidate.starts_with(word);
        auto const d = prefix ? std::size_t{1} : distance(word, candidate);
        if (d < best_distance || (d == best_distance && !best)) {
            best = candidate;
            best_distance = d;
        }
    }
    return best;
}

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

std::vector<std::string> Reader::keys() const
{
    std::vector<std::string> names;
    if (node_.IsMap())
        for (auto const& entry : node_)
            if (entry.first.IsScalar()) names.push_back(entry.first.Scalar());
    return names;
}

Problem Reader::place(std::string_view key) const
{
    auto const mark = key_node(key).Mark();
    return is_nowhere(mark) ? Problem{} : Problem{mark.line + 1, mark.column + 1, ""};
}

std::optional<YAML::Node> Reader::subtree(std::string_view key)
{
    return find(key);
}

void Reader::record(YAML::Mark const& mark, std::string const& text)
{
    bool const placed = !is_nowhere(mark);
    Problem const problem{placed ? mark.line + 1 : 1, placed ? mark.column + 1 : 1, text};
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

template <class T>
T Reader::note(std::string_view key, T value)
{
    std::string text;
    if constexpr (std::is_same_v<T, bool>)
        text = value ? "true" : "false";
    else if constexpr (std::is_same_v<T, std::string>)
        text = value;
    else if constexpr (std::is_same_v<T, std::vector<double>>) {
        for (double x : value) text += (text.empty() ? "[" : ", ") + shown(x);
        text += "]";
    } else
        text = shown(static_cast<double>(value));
    diagnostics_->effective.emplace_back(path_of(key), text);
    return value;
}

std::optional<double> Reader::parse_number(std::string_view key, YAML::Node const& node, std::string const& path,
                                           Bounds const& b)
{
    std::string const unit = b.unit.empty() ? "" : " " + std::string(b.unit);
    auto const mark = is_nowhere(node.Mark()) ? key_node(key).Mark() : node.Mark();
    auto const value = node.IsScalar() ? to_number(node.Scalar()) : std::nullopt;
    if (!value || !std::isfinite(*value)) {
        record(mark, path + " = " + scalar_or_kind(node) + " is not a number (" + described(b) +
                         (unit.empty() ? "" : ", in" + unit) + ").");
        return std::nullopt;
    }
    if (!(*value > b.above && *value >= b.min && *value <= b.max && *value < b.below)) {
        record(mark, path + " = " + node.Scalar() + unit + " (" + described(b) + ").");
        return std::nullopt;
    }
    return value;
}

std::optional<double> Reader::scalar_number(std::string_view key, Bounds const& b, bool must, bool whole)
{
    auto const node = find(key);
    if (!node) {
        std::string const unit = b.unit.empty() ? "" : ", in " + std::string(b.unit);
        if (must) missing(key, (whole ? "a whole number, " : "") + described(b) + unit);
        return std::nullopt;
    }
    auto const value = parse_number(key, *node, path_of(key), b);
    if (value && whole && (*value != std::floor(*value) || std::abs(*value) > 9.0e15)) {
        record(node->Mark(), path_of(key) + " = " + node->Scalar() + " (must be a whole number).");
        return std::nullopt;
    }
    return value;
}

double Reader::number(std::string_view key, Bounds const& b)
{
    auto const value = scalar_number(key, b, true, false);
    double const harmless = std::isfinite(b.min) ? b.min : std::isfinite(b.above) ? b.above + 1.0 : 1.0;
    return value ? note(key, *value) : harmless;
}

double Reader::number_or(std::string_view key, double fallback, Bounds const& b)
{
    return note(key, scalar_number(key, b, false, false).value_or(fallback));
}

std::optional<double> Reader::number_if(std::string_view key, Bounds const& b)
{
    auto const value = scalar_number(key, b, false, false);
    if (value) note(key, *value);
    return value;
}

std::int64_t Reader::integer(std::string_view key, Bounds const& b)
{
    auto const value = scalar_number(key, b, true, true);
    return static_cast<std::int64_t>(value ? note(key, *value) : std::isfinite(b.min) ? b.min : 1.0);
}

std::int64_t Reader::integer_or(std::string_view key, std::int64_t fallback, Bounds const& b)
{
    auto const value = scalar_number(key, b, false, true);
    return static_cast<std::int64_t>(note(key, value.value_or(static_cast<double>(fallback))));
}

bool Reader::flag_or(std::string_view key, bool fallback)
{
    auto const node = find(key);
    if (!node) return note(key, fallback);
    auto const text = scalar_or_kind(*node);
    if (text != "true" && text != "false") {
        record(node->Mark(), path_of(key) + " = " + text + " (must be true or false).");
        return fallback;
    }
    return note(key, text == "true");
}

std::string Reader::text(std::string_view key)
{
    auto const node = find(key);
    if (!node) {
        missing(key, "a text");
        return {};
    }
    if (!node->IsScalar() || node->Scalar().empty()) {
        record(node->Mark(), path_of(key) + " = " + scalar_or_kind(*node) + " (must be a text).");
        return {};
    }
    return note(key, node->Scalar());
}

std::string Reader::text_or(std::string_view key, std::string_view fallback)
{
    return has(key) ? text(key) : (asked_.emplace(key), note(key, std::string(fallback)));
}

std::optional<std::size_t> Reader::find_choice(std::string_view key, std::vector<std::string_view> const& choices,
                                               bool must)
{
    auto const node = find(key);
    if (!node) {
        if (must) missing(key, "one of: " + quoted_list(choices));
        return std::nullopt;
    }
    auto const word = scalar_or_kind(*node);
    for (std::size_t i = 0; i < choices.size(); ++i)
        if (node->IsScalar() && word == choices[i]) {
            note(key, word);
            return i;
        }
    auto const near = nearest(word, {choices.begin(), choices.end()});
    auto const mark = is_nowhere(node->Mark()) ? key_node(key).Mark() : node->Mark();
    record(mark, path_of(key) + " = " + word + " (must be one of: " + quoted_list(choices) + ")." +
                     (near ? " Did you mean " + *near + "?" : ""));
    return std::nullopt;
}

std::size_t Reader::choice(std::string_view key, std::vector<std::string_view> const& choices)
{
    return find_choice(key, choices, true).value_or(0);
}

std::size_t Reader::choice_or(std::string_view key, std::size_t fallback, std::vector<std::string_view> const& choices)
{
    bool const given = has(key);
    auto const found = find_choice(key, choices, false);
    if (!given) note(key, std::string(choices.at(fallback)));
    return found.value_or(fallback);
}

std::optional<std::vector<double>> Reader::find_numbers(std::string_view key, std::size_t size, Bounds const& b,
                                                        bool must)
{
    auto const node = find(key);
    std::string const needed =
        "a list of " + std::to_string(size) + " numbers" + (b.unit.empty() ? "" : ", in " + std::string(b.unit));
    if (!node) {
        if (must) missing(key, needed);
        return std::nullopt;
    }
    if (!node->IsSequence() || node->size() != size) {
        auto const seen = node->IsSequence() ? "a list of " + std::to_string(node->size()) : scalar_or_kind(*node);
        auto const mark = node->IsSequence() || is_nowhere(node->Mark()) ? key_node(key).Mark() : node->Mark();
        record(mark, path_of(key) + " is " + seen + " (must be " + needed + ").");
        return std::nullopt;
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < size; ++i) {
        auto const value = parse_number(key, (*node)[i], path_of(key) + "[" + std::to_string(i) + "]", b);
        if (value) values.push_back(*value);
    }
    if (values.size() != size) return std::nullopt;
    return note(key, values);
}

std::vector<double> Reader::numbers(std::string_view key, std::size_t size, Bounds const& b)
{
    return find_numbers(key, size, b, true).value_or(std::vector<double>(size, 1.0));
}

std::vector<double> Reader::numbers_or(std::string_view key, std::vector<double> const& fallback, Bounds const& b)
{
    bool const given = has(key);
    auto const found = find_numbers(key, fallback.size(), b, false);
    if (!given) note(key, fallback);
    return found.value_or(fallback);
}

Reader Reader::child(std::string_view key)
{
    auto found = child_if(key);
    if (found) return *found;
    if (!has(key)) missing(key, "a mapping of keys");
    return {YAML::Node(YAML::NodeType::Map), key_node(key), path_of(key), std::make_shared<Diagnostics>(), false};
}

std::optional<Reader> Reader::child_if(std::string_view key)
{
    auto const node = find(key);
    if (!node) return std::nullopt;
    if (!node->IsMap()) {
        record(key_node(key).Mark(), path_of(key) + " is " + scalar_or_kind(*node) + " (must be a mapping of keys).");
        return std::nullopt;
    }
    return Reader(*node, key_node(key), path_of(key), diagnostics_, false);
}

std::vector<Reader> Reader::list(std::string_view key)
{
    std::vector<Reader> readers;
    auto const node = find(key);
    if (!node) return readers;
    if (!node->IsSequence()) {
        record(key_node(key).Mark(), path_of(key) + " is " + scalar_or_kind(*node) + " (must be a list of mappings).");
        return readers;
    }
    for (std::size_t i = 0; i < node->size(); ++i) {
        auto const path = path_of(key) + "[" + std::to_string(i) + "]";
        auto const item = (*node)[i];
        if (item.IsMap())
            readers.emplace_back(item, item, path, diagnostics_, false);
        else
            record(item.Mark(), path + " is " + scalar_or_kind(item) + " (must be a mapping of keys).");
    }
    return readers;
}

std::vector<std::pair<std::string, Reader>> Reader::children(std::string_view key)
{
    std::vector<std::pair<std::string, Reader>> found;
    auto parent = child_if(key);
    if (!parent) {
        if (!has(key)) missing(key, "a mapping of names");
        return found;
    }
    for (auto const& name : parent->keys()) {
        bool const seen = std::any_of(found.begin(), found.end(), [&](auto const& f) { return f.first == name; });
        if (seen) continue;  // given twice: already a problem
        if (auto reader = parent->child_if(name)) found.emplace_back(name, *reader);
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
    for (auto const& name : keys()) {
        if (asked_.contains(name)) continue;
        std::vector<std::string> const known(asked_.begin(), asked_.end());
        std::string list;
        for (auto const& k : known)
            if (!k.empty()) list += (list.empty() ? "" : ", ") + k;
        auto const near = nearest(name, known);
        record(key_node(name).Mark(),
               path_of(name) + " is not a key (keys: " + list + ")." + (near ? " Did you mean " + *near + "?" : ""));
    }
}

}  // namespace sluice
