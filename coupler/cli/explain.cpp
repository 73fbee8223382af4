#include "coupler/cli/explain.hpp"

#include <fmt/format.h>

#include <cstdio>

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

//! By its code or word; else every one that has the word somewhere in its text.
std::vector<Explanation> find(std::string const& word)
{
    std::vector<Explanation> found;
    for (auto const& e : explanations())
        if (word.empty() || is_meant(e, word)) found.push_back(e);
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
