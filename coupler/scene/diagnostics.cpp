#include "coupler/scene/diagnostics.hpp"

#include <algorithm>
#include <numeric>

#include "coupler/base/error.hpp"

namespace sluice {

void Diagnostics::read(std::string file_name, std::string whole_text)
{
    file = std::move(file_name);
    text = std::move(whole_text);
    lines.clear();
    if (std::none_of(text.begin(), text.end(), [](char c) { return (c & 0x80) != 0; })) return;
    std::string_view rest = text;
    if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);  // the parser takes the byte order mark away
    while (!rest.empty()) {
        auto const end = std::min(rest.find('\n'), rest.size());
        lines.push_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
}

int Diagnostics::column(int line, int offset) const
{
    if (line < 1 || static_cast<std::size_t>(line) > lines.size()) return offset + 1;
    auto const before = lines[static_cast<std::size_t>(line - 1)].substr(0, static_cast<std::size_t>(offset));
    auto const following = std::count_if(before.begin(), before.end(), [](char c) { return (c & 0xc0) == 0x80; });
    return offset + 1 - static_cast<int>(following);
}

bool Diagnostics::is_overridden(Problem const& problem) const
{
    return std::any_of(overridden.begin(), overridden.end(), [&](std::string const& path) {
        return problem.text.starts_with(path) &&
               (problem.text.size() == path.size() ||
                std::string_view(" .:[").find(problem.text[path.size()]) != std::string_view::npos);
    });
}

std::vector<std::string> Diagnostics::sorted(std::vector<Problem> const& some) const
{
    auto by_place = some;
    std::stable_sort(by_place.begin(), by_place.end(), [](Problem const& a, Problem const& b) {
        return std::pair(a.line, a.column) < std::pair(b.line, b.column);
    });
    std::vector<std::string> texts;
    for (Problem const& p : by_place) {
        auto const place = is_overridden(p) ? " --set" : std::to_string(p.line) + ":" + std::to_string(p.column);
        auto text = file + ":" + place + ": " + p.text;
        if (std::find(texts.begin(), texts.end(), text) == texts.end()) texts.push_back(std::move(text));
    }
    return texts;
}

void Diagnostics::throw_if_any() const
{
    if (problems.empty()) return;
    std::string all;
    for (auto const& line : sorted()) all += (all.empty() ? "" : "\n") + line;
    throw Error(all, Exit::config);
}

namespace {

constexpr std::size_t longest_typo = 64;  // characters; longer words are no typos of our keys, and cost

std::string lower(std::string_view word)
{
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

//! Damerau-Levenshtein: insertions, deletions, changes and swaps of neighbours, each 1.
std::size_t distance(std::string_view a, std::string_view b)
{
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
}

}  // namespace

std::optional<std::string> nearest(std::string_view word, std::vector<std::string> const& candidates)
{
    if (word.empty() || word.size() > longest_typo) return std::nullopt;
    auto const small = lower(word);
    std::optional<std::string> best;
    std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2);  // farther is no typo
    if (word.size() <= 3) best_distance = 1;
    for (auto const& candidate : candidates) {
        if (candidate.size() > longest_typo) continue;
        auto const other = lower(candidate);
        bool const prefix = word.size() >= 3 && other.starts_with(small);
        auto const d = prefix ? std::min<std::size_t>(1, distance(small, other)) : distance(small, other);
        if (d < best_distance || (d == best_distance && !best)) {
            best = candidate;
            best_distance = d;
        }
    }
    return best;
}

std::string did_you_mean(std::string_view word, std::vector<std::string> const& candidates)
{
    auto const near = nearest(word, candidates);
    return near ? " Did you mean " + *near + "?" : "";
}

std::string list_of(std::vector<std::string> const& words)
{
    constexpr std::size_t shown = 20;
    std::string text;
    for (std::size_t i = 0; i < words.size() && i < shown; ++i) text += (i ? ", " : "") + words[i];
    return words.size() > shown ? text + " and " + std::to_string(words.size() - shown) + " more" : text;
}

}  // namespace sluice
