#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "coupler/scene/reader.hpp"

//! How readers put what they see into words; for the files of this folder.
namespace sluice::words {

inline std::string shown(double x)
{
    char text[32];
    auto const end = std::to_chars(text, text + sizeof text, x).ptr;
    return {text, end};
}

//! The whole of `text` as a decimal number; YAML's octal "0o12" and words such as "1e-5x" are not numbers here.
inline std::optional<double> to_number(std::string const& text)
{
    char const* first = text.data();
    char const* const last = first + text.size();
    if (first != last && *first == '+' && first + 1 != last && first[1] != '-') ++first;
    double value = 0;
    auto const [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || first == last) return std::nullopt;
    return value;
}

//! Written in quotes (or with a tag): a text, whatever it says.
inline bool is_quoted(YAML::Node const& node)
{
    return node.Tag() == "!";
}

//! true or false as YAML's core schema writes them, without quotes.
inline std::optional<bool> to_flag(YAML::Node const& node)
{
    if (!node.IsScalar() || is_quoted(node)) return std::nullopt;
    for (char const* word : {"true", "True", "TRUE"})
        if (node.Scalar() == word) return true;
    for (char const* word : {"false", "False", "FALSE"})
        if (node.Scalar() == word) return false;
    return std::nullopt;
}

//! What YAML's core schema takes for a number: decimal, hexadecimal, octal, .inf, .nan.
inline bool looks_like_number(std::string const& text)
{
    auto const digits_only = [](std::string_view rest, char const* digits) {
        return !rest.empty() && rest.find_first_not_of(digits) == rest.npos;
    };
    std::string_view const whole = text;
    if (whole.starts_with("0x")) return digits_only(whole.substr(2), "0123456789abcdefABCDEF");
    if (whole.starts_with("0o")) return digits_only(whole.substr(2), "01234567");
    auto const unsigned_part = whole.substr(whole.starts_with('-') || whole.starts_with('+') ? 1 : 0);
    for (char const* word : {".inf", ".Inf", ".INF"})
        if (unsigned_part == word) return true;
    for (char const* word : {".nan", ".NaN", ".NAN"})
        if (whole == word) return true;
    if (unsigned_part.empty() || std::string_view("0123456789.").find(unsigned_part[0]) == std::string_view::npos)
        return false;
    double value = 0;
    auto const last = text.data() + text.size();
    return std::from_chars(unsigned_part.data(), last, value).ptr == last;  // also one that is too large
}

//! "must be > 0 and <= 1".
inline std::string described(Bounds const& b)
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

inline std::string scalar_or_kind(YAML::Node const& node)
{
    if (node.IsScalar()) return node.Scalar();
    return node.IsMap() ? "a mapping" : node.IsSequence() ? "a list" : "nothing";
}

//! The same for a message: not longer than a line.
inline std::string seen(YAML::Node const& node)
{
    auto text = scalar_or_kind(node);
    if (text.empty()) return "\"\"";
    constexpr std::size_t longest = 80;
    if (text.size() <= longest) return text;
    std::size_t end = longest;
    while (end > 0 && (text[end] & 0xc0) == 0x80) --end;  // not inside a character
    return text.substr(0, end) + "...";
}

//! A node that is not in the file: a missing one.
inline bool is_nowhere(YAML::Mark const& mark)
{
    return mark.is_null() || mark.line < 0;
}

}  // namespace sluice::words
