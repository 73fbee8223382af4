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

//! The whole of `text` as a decimal number; YAML's octal "012" and words such as "1e-5x" are not numbers here.
inline std::optional<double> to_number(std::string const& text)
{
    char const* first = text.data();
    char const* const last = first + text.size();
    if (first != last && *first == '+') ++first;
    double value = 0;
    auto const [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || first == last) return std::nullopt;
    return value;
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
