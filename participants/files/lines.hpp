#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace files {

//! A text file line by line; knows where it is.
class Lines
{
 public:
    //! Throws sluice::Error (config) if the file cannot be read.
    explicit Lines(std::filesystem::path file);

    //! The next line, without its end and without a byte order mark; false: there is none.
    bool next();
    std::string_view text() const { return text_; }
    //! The text without what follows a #, and without blanks around it.
    std::string_view content() const;
    std::int64_t number() const { return number_; }  //!< from 1; 0: before the first

    struct Mark
    {
        std::streampos at = 0;
        std::int64_t number = 0;
    };
    Mark mark() { return {in_.tellg(), number_}; }  //!< before the next line
    void go_back(Mark const& mark);

    //! Throws sluice::Error (config): `file:line: text`.
    [[noreturn]] void fail(std::string const& text) const { fail_at(number_, text); }
    [[noreturn]] void fail_at(std::int64_t line, std::string const& text) const;

 private:
    std::filesystem::path file_;
    std::ifstream in_;
    std::string text_;
    std::int64_t number_ = 0;
};

//! Takes the next word off a text; words are parted by the separator, ' ' standing for any number of blanks and tabs.
std::string_view take_word(std::string_view& text, char separator);
std::string_view trimmed(std::string_view text);
//! A number, if the word is one; not a number and infinity are.
std::optional<double> number_in(std::string_view word);

}  // namespace files
