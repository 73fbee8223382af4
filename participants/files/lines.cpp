#include "participants/files/lines.hpp"

#include <charconv>
#include <utility>

#include "coupler/base/error.hpp"

namespace files {

Lines::Lines(std::filesystem::path file) : file_(std::move(file)), in_(file_, std::ios::binary)
{
    std::error_code ignored;
    sluice::require(in_ && !std::filesystem::is_directory(file_, ignored), [&] {
        return sluice::Error(file_.string() + " cannot be read (needed: a file; its path counts from the scene's).");
    });
}

bool Lines::next()
{
    if (!std::getline(in_, text_)) return false;
    if (number_ == 0 && text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
    if (text_.ends_with('\r')) text_.pop_back();
    ++number_;
    return true;
}

std::string_view Lines::content() const
{
    std::string_view const text = text_;
    return trimmed(text.substr(0, text.find('#')));
}

void Lines::go_back(Mark const& mark)
{
    in_.clear();
    in_.seekg(mark.at);
    number_ = mark.number;
}

void Lines::fail_at(std::int64_t line, std::string const& text) const
{
    throw sluice::Error(file_.string() + ":" + std::to_string(line) + ": " + text);
}

std::string_view trimmed(std::string_view text)
{
    auto const from = text.find_first_not_of(" \t");
    if (from == std::string_view::npos) return {};
    return text.substr(from, text.find_last_not_of(" \t") - from + 1);
}

std::string_view take_word(std::string_view& text, char separator)
{
    auto const end = separator == ' ' ? text.find_first_of(" \t") : text.find(separator);
    auto const word = trimmed(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    if (separator == ' ') text = text.substr(std::min(text.find_first_not_of(" \t"), text.size()));
    return word;
}

std::optional<double> number_in(std::string_view word)
{
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0.0;
    auto const [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

}  // namespace files
