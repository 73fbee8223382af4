#include <algorithm>
#include <cmath>

#include "coupler/scene/reader.hpp"
#include "coupler/scene/words.hpp"

namespace sluice {

using namespace words;

namespace {

std::string quoted_list(std::vector<std::string_view> const& choices)
{
    return list_of({choices.begin(), choices.end()});
}

}  // namespace

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
    auto const mark = value_mark(key, node);
    auto const value = node.IsScalar() ? to_number(node.Scalar()) : std::nullopt;
    if (value && is_quoted(node)) {
        record(mark, path + " = \"" + seen(node) + "\" is a text, not a number. Leave the quotes out.");
        return std::nullopt;
    }
    if (!value || !std::isfinite(*value)) {
        record(mark, path + " = " + seen(node) + " is not a number (" + described(b) +
                         (unit.empty() ? "" : ", in" + unit) + ").");
        return std::nullopt;
    }
    if (!(*value > b.above && *value >= b.min && *value <= b.max && *value < b.below)) {
        record(mark, path + " = " + seen(node) + unit + " (" + described(b) + ").");
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
        refuse(key, "(must be a whole number).");
        return std::nullopt;
    }
    return value;
}

double Reader::number(std::string_view key, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::number, .path = {}, .required = true, .bounds = b});
    auto const value = scalar_number(key, b, true, false);
    double const harmless = std::isfinite(b.min) ? b.min : std::isfinite(b.above) ? b.above + 1.0 : 1.0;
    return value ? note(key, *value) : harmless;
}

double Reader::number_or(std::string_view key, double fallback, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::number, .path = {}, .bounds = b, .fallback = shown(fallback)});
    return note(key, scalar_number(key, b, false, false).value_or(fallback));
}

std::optional<double> Reader::number_if(std::string_view key, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::number, .path = {}, .bounds = b});
    auto const value = scalar_number(key, b, false, false);
    if (value) note(key, *value);
    return value;
}

std::int64_t Reader::integer(std::string_view key, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::integer, .path = {}, .required = true, .bounds = b});
    auto const value = scalar_number(key, b, true, true);
    return static_cast<std::int64_t>(value ? note(key, *value) : std::isfinite(b.min) ? b.min : 1.0);
}

std::optional<std::int64_t> Reader::integer_if(std::string_view key, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::integer, .path = {}, .bounds = b});
    auto const value = scalar_number(key, b, false, true);
    if (!value) return std::nullopt;
    return static_cast<std::int64_t>(note(key, *value));
}

std::int64_t Reader::integer_or(std::string_view key, std::int64_t fallback, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::integer, .path = {}, .bounds = b, .fallback = std::to_string(fallback)});
    auto const value = scalar_number(key, b, false, true);
    return static_cast<std::int64_t>(note(key, value.value_or(static_cast<double>(fallback))));
}

std::vector<std::pair<std::string, double>> Reader::number_map(Bounds const& b)
{
    learn("", {.kind = Key::Kind::number_map, .path = {}, .bounds = b});
    std::vector<std::pair<std::string, double>> found;
    std::set<std::string> seen_already;
    for (auto const& name : keys())
        if (seen_already.insert(name).second)
            if (auto const value = scalar_number(name, b, false, false)) found.emplace_back(name, note(name, *value));
    return found;
}

bool Reader::flag_or(std::string_view key, bool fallback)
{
    learn(key, {.kind = Key::Kind::flag, .path = {}, .fallback = fallback ? "true" : "false"});
    auto const node = find(key);
    if (!node) return note(key, fallback);
    auto const value = to_flag(*node);
    if (!value) {
        refuse(key, "(must be true or false).");
        return fallback;
    }
    return note(key, *value);
}

std::string Reader::find_text(std::string_view key, bool word)
{
    auto const node = find(key);
    if (!node) {
        missing(key, "a text");
        return {};
    }
    if (!node->IsScalar() || node->Scalar().empty()) {
        refuse(key, "(must be a text).");
        return {};
    }
    if (word && !is_quoted(*node) && (to_flag(*node) || looks_like_number(node->Scalar()))) {
        refuse(key, "is not a text for YAML (put it in quotes if it is meant).");
        return {};
    }
    return note(key, node->Scalar());
}

std::string Reader::text(std::string_view key)
{
    learn(key, {.kind = Key::Kind::text, .path = {}, .required = true});
    return find_text(key, false);
}

std::string Reader::text_or(std::string_view key, std::string_view fallback)
{
    learn(key, {.kind = Key::Kind::text, .path = {}, .fallback = std::string(fallback)});
    return has(key) ? find_text(key, false) : (asked_.emplace(key), note(key, std::string(fallback)));
}

std::string Reader::text_if(std::string_view key)
{
    learn(key, {.kind = Key::Kind::text, .path = {}});
    return has(key) ? find_text(key, false) : (asked_.emplace(key), std::string());
}

std::string Reader::word(std::string_view key)
{
    learn(key, {.kind = Key::Kind::word, .path = {}, .required = true});
    return find_text(key, true);
}

std::string Reader::word_if(std::string_view key)
{
    learn(key, {.kind = Key::Kind::word, .path = {}});
    return has(key) ? find_text(key, true) : (asked_.emplace(key), std::string());
}

std::string Reader::word_or(std::string_view key, std::string_view fallback)
{
    learn(key, {.kind = Key::Kind::word, .path = {}, .fallback = std::string(fallback)});
    return has(key) ? find_text(key, true) : (asked_.emplace(key), note(key, std::string(fallback)));
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
    refuse(key, "(must be one of: " + quoted_list(choices) + ")." +
                    (node->IsScalar() ? did_you_mean(word, {choices.begin(), choices.end()}) : ""));
    return std::nullopt;
}

std::size_t Reader::choice(std::string_view key, std::vector<std::string_view> const& choices)
{
    learn(key, {.kind = Key::Kind::choice, .path = {}, .required = true, .words = {choices.begin(), choices.end()}});
    return find_choice(key, choices, true).value_or(0);
}

std::size_t Reader::choice_or(std::string_view key, std::size_t fallback, std::vector<std::string_view> const& choices)
{
    learn(key, {.kind = Key::Kind::choice,
                .path = {},
                .words = {choices.begin(), choices.end()},
                .fallback = std::string(choices.at(fallback))});
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
        auto const what = node->IsSequence() ? "a list of " + std::to_string(node->size()) : seen(*node);
        record(value_mark(key, *node), path_of(key) + " is " + what + " (must be " + needed + ").");
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
    learn(key, {.kind = Key::Kind::numbers, .path = {}, .required = true, .bounds = b, .size = size});
    return find_numbers(key, size, b, true).value_or(std::vector<double>(size, 1.0));
}

std::vector<double> Reader::numbers_or(std::string_view key, std::vector<double> const& fallback, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::numbers, .path = {}, .bounds = b, .size = fallback.size()});
    bool const given = has(key);
    auto const found = find_numbers(key, fallback.size(), b, false);
    if (!given) note(key, fallback);
    return found.value_or(fallback);
}

std::optional<double> Reader::number_unless(std::string_view key, std::string_view word, Bounds const& b)
{
    learn(key, {.kind = Key::Kind::number,
                .path = {},
                .bounds = b,
                .words = {std::string(word)},
                .fallback = std::string(word)});
    auto const node = find(key);
    if (!node || (node->IsScalar() && node->Scalar() == word)) {
        note(key, std::string(word));
        return std::nullopt;
    }
    if (node->IsScalar() && !to_number(node->Scalar())) {
        refuse(key, "is neither " + std::string(word) + " nor a number (" + described(b) +
                        (b.unit.empty() ? "" : ", in " + std::string(b.unit)) + ")." +
                        did_you_mean(node->Scalar(), {std::string(word)}));
        return std::nullopt;
    }
    auto const value = scalar_number(key, b, false, false);
    if (value) note(key, *value);
    return value;
}

std::vector<std::string> Reader::words(std::string_view key)
{
    learn(key, {.kind = Key::Kind::texts, .path = {}});
    auto const node = find(key);
    if (!node) return {};
    std::vector<std::string> found;
    if (node->IsScalar()) found.push_back(node->Scalar());
    if (node->IsSequence())
        for (auto const& word : *node) found.push_back(word.IsScalar() ? word.Scalar() : "");
    bool const whole = std::none_of(found.begin(), found.end(), [](auto const& w) { return w.empty(); });
    if (found.empty() || !whole) {
        refuse(key, "(must be a text, or a list of texts).");
        return {};
    }
    std::string text;
    for (auto const& word : found) text += (text.empty() ? "" : " ") + word;
    note(key, text);
    return found;
}

std::optional<std::size_t> Reader::find_name(std::string_view key, std::string const& path, YAML::Node const& node,
                                             std::string_view kind, std::vector<std::string> const& known)
{
    if (known.empty()) return std::nullopt;  // what defines the names is missing, and that is said elsewhere
    auto const word = scalar_or_kind(node);
    auto const found = std::find(known.begin(), known.end(), word);
    if (node.IsScalar() && found != known.end()) return static_cast<std::size_t>(found - known.begin());
    record(value_mark(key, node), path + " = " + seen(node) + " (there is no such " + std::string(kind) + ": " +
                                      list_of(known) + ")." + (node.IsScalar() ? did_you_mean(word, known) : ""));
    return std::nullopt;
}

std::optional<std::size_t> Reader::name_of_if(std::string_view key, std::string_view kind,
                                              std::vector<std::string> const& known)
{
    learn(key, {.kind = Key::Kind::name, .path = {}});
    auto const node = find(key);
    if (!node) return std::nullopt;
    auto const found = find_name(key, path_of(key), *node, kind, known);
    if (found) note(key, known[*found]);
    return found;
}

std::optional<std::size_t> Reader::name_of(std::string_view key, std::string_view kind,
                                           std::vector<std::string> const& known)
{
    learn(key, {.kind = Key::Kind::name, .path = {}, .required = true});
    auto const node = find(key);
    if (!node) {
        missing(key, "a " + std::string(kind) + ": " + list_of(known));
        return std::nullopt;
    }
    auto const found = find_name(key, path_of(key), *node, kind, known);
    if (found) note(key, known[*found]);
    return found;
}

std::vector<std::size_t> Reader::names_of(std::string_view key, std::string_view kind,
                                          std::vector<std::string> const& known, std::size_t least)
{
    learn(key, {.kind = Key::Kind::names, .path = {}, .required = true, .size = least});
    std::vector<std::size_t> found;
    auto const node = find(key);
    std::string const needed = "a list of at least " + std::to_string(least) + " " + std::string(kind) + "s";
    if (!node) {
        missing(key, needed);
        return found;
    }
    if (!node->IsSequence() || node->size() < least) {
        auto const what = node->IsSequence() ? "a list of " + std::to_string(node->size()) : seen(*node);
        record(value_mark(key, *node), path_of(key) + " is " + what + " (must be " + needed + ").");
        return found;
    }
    std::string text;
    std::set<std::string> already;
    for (std::size_t i = 0; i < node->size(); ++i) {
        auto const item = (*node)[i];
        auto const path = path_of(key) + "[" + std::to_string(i) + "]";
        if (item.IsScalar() && !already.insert(item.Scalar()).second) {
            record(item.Mark(), path + " = " + seen(item) + " stands here twice. Keep one.");
            continue;
        }
        auto const index = find_name(key, path, item, kind, known);
        if (!index) continue;
        found.push_back(*index);
        text += (text.empty() ? "" : ", ") + known[*index];
    }
    note(key, "[" + text + "]");
    return found;
}

}  // namespace sluice
