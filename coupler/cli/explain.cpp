#include "coupler/cli/explain.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <ranges>

#include "coupler/base/error.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/commands.hpp"

namespace sluice {
namespace {

std::string name_of(Explanation const& e)
{
    return e.code < 0 ? std::string(e.word) : fmt::format("{} ({})", e.code, e.word);
}

bool is_meant(Explanation const& e, std::string const& word)
{
    return word == e.word || (e.code >= 0 && word == std::to_string(e.code));
}

//! Whether a message reads like `says`: its parts between "..." in their order. Alternatives stand between "; ".
bool reads_like(std::string_view says, std::string_view message)
{
    for (auto const alternative : std::views::split(says, std::string_view("; "))) {
        std::size_t at = 0;
        bool any = false;
        for (auto const part : std::views::split(alternative, std::string_view("..."))) {
            std::string_view text(part.begin(), part.end());
            while (text.starts_with(' ')) text.remove_prefix(1);
            while (text.ends_with(' ')) text.remove_suffix(1);
            if (text.empty()) continue;
            at = message.find(text, at);
            if (at == message.npos) break;
            at += text.size();
            any = true;
        }
        if (any && at != message.npos) return true;
    }
    return false;
}

//! By its code or word; else those that a message reads like; else every one that has the word somewhere in its text.
std::vector<Explanation> find(std::string const& word)
{
    std::vector<Explanation> found;
    for (auto const& e : explanations())
        if (word.empty() || is_meant(e, word)) found.push_back(e);
    if (!found.empty()) return found;
    if (word.find(' ') != word.npos)
        for (auto const& e : explanations())
            if (e.code < 0 && reads_like(e.says, word)) found.push_back(e);
    if (!found.empty()) return found;
    for (auto const& e : explanations())
        if (word.size() > 2 && (e.says.find(word) != e.says.npos || e.more.find(word) != e.more.npos))
            found.push_back(e);
    return found;
}

nlohmann::ordered_json as_json(std::vector<Explanation> const& found)
{
    auto list = nlohmann::ordered_json::array();
    for (auto const& e : found) {
        nlohmann::ordered_json entry = {{"word", e.word}, {"says", e.says}, {"more", e.more}};
        if (e.code >= 0) entry["exit"] = e.code;
        list.push_back(entry);
    }
    return list;
}

}  // namespace

int explain_command(Options const& o)
{
    auto const found = find(o.word);
    std::vector<std::string> words;
    for (auto const& e : explanations()) words.emplace_back(e.word);
    require(!found.empty(), [&] {
        return Error("sluice explain " + o.word + ": not known (known: exit codes, and " + list_of(words) + ")." +
                     did_you_mean(o.word, words));
    });
    if (o.json)
        print_json(as_json(found));
    else if (o.word.empty())
        for (auto const& e : found) std::printf("%s\n", fmt::format("{:<18}{}", name_of(e), e.says).c_str());
    else
        for (auto const& e : found) std::printf("%s\n", fmt::format("{}: {}\n{}", name_of(e), e.says, e.more).c_str());
    return 0;
}

}  // namespace sluice
