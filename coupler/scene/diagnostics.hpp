#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coupler/scene/key.hpp"

namespace sluice {

//! One mistake in a scene: where (1-based, columns count characters) and what.
struct Problem
{
    int line = 1;
    int column = 1;
    std::string text;  //!< `path = seen (needed). What to try.`
};

//! Collects what a scene's readers found; shared by all readers of one document.
struct Diagnostics
{
    std::string file;
    std::vector<std::string_view> lines;  //!< of `text`; empty if every character of it is one byte
    std::string text;
    std::vector<Problem> problems;
    std::vector<Problem> warnings;        //!< no mistakes, but worth a look
    std::vector<std::string> overridden;  //!< paths given by --set: their mistakes have no place in the file
    std::vector<std::pair<std::string, std::string>> effective;  //!< path, value: everything read, defaults filled in
    std::vector<Key>* keys = nullptr;  //!< where readers write down what they ask for; nullptr: nowhere

    Diagnostics() = default;
    Diagnostics(Diagnostics const&) = delete;  // `lines` looks into `text`
    Diagnostics& operator=(Diagnostics const&) = delete;

    //! Takes in the text whose mistakes these are.
    void read(std::string file_name, std::string whole_text);
    //! The column in characters of the byte `offset` (0-based) of the line `line` (1-based).
    int column(int line, int offset) const;

    //! The problems by line, each once, as `file:line:column: text` or `file: --set: text`.
    std::vector<std::string> sorted() const { return sorted(problems); }
    std::vector<std::string> sorted(std::vector<Problem> const& some) const;
    //! Throws one Error (exit 2) listing every problem; nothing if there is none.
    void throw_if_any() const;
    //! Is this problem about something given by --set?
    bool is_overridden(Problem const& problem) const;
};

//! The candidate nearest to `word` by edit distance, if it is near enough to be a typo of it.
std::optional<std::string> nearest(std::string_view word, std::vector<std::string> const& candidates);

//! ` Did you mean X?` with the nearest candidate, or nothing.
std::string did_you_mean(std::string_view word, std::vector<std::string> const& candidates);

//! `a, b, c`; of more than 20 the first 20 and how many more there are.
std::string list_of(std::vector<std::string> const& words);

}  // namespace sluice
