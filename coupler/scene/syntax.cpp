#include "coupler/scene/syntax.hpp"

#include <algorithm>
#include <vector>

namespace sluice {
namespace {

class Scan
{
 public:
    explicit Scan(std::string_view text) : text_(text) {}

    void up_to(int line, int offset)
    {
        while (at_ < text_.size() && (line_ < line || (line_ == line && column_ < offset))) token();
    }
    std::optional<Opening> long_quote;  //!< the last one that goes over the end of its line
    std::vector<Opening> brackets;      //!< open ones

 private:
    void token()
    {
        char const c = text_[at_];
        bool const begins = std::string_view("\n:-?,[{").find(before_) != std::string_view::npos;
        if (c == '#' && (column_ == 0 || text_[at_ - 1] == ' '))
            while (at_ < text_.size() && text_[at_] != '\n') step();
        else if ((c == '\'' || c == '"') && begins)
            quoted(c);
        else {
            if ((c == '[' || c == '{') && begins) brackets.push_back({line_, column_, c});
            if ((c == ']' || c == '}') && !brackets.empty()) brackets.pop_back();
            if (c != ' ' && c != '\r' && c != '\t') before_ = c;
            step();
        }
    }
    void quoted(char sign)
    {
        Opening const opening{line_, column_, sign};
        step();
        while (at_ < text_.size()) {
            char const c = text_[at_];
            bool const twice = c == sign && sign == '\'' && at_ + 1 < text_.size() && text_[at_ + 1] == sign;
            step();
            if (twice || (c == '\\' && sign == '"' && at_ < text_.size()))
                step();
            else if (c == sign)
                break;
        }
        before_ = sign;
        if (line_ > opening.line) long_quote = opening;
    }
    void step()
    {
        bool const end = text_[at_++] == '\n';
        line_ += end;
        column_ = end ? 0 : column_ + 1;
    }

    std::string_view text_;
    std::size_t at_ = 0;
    int line_ = 0, column_ = 0;
    char before_ = '\n';  //!< the last sign that is not white
};

}  // namespace

std::optional<int> tab_before(std::string_view text, int line)
{
    for (int i = 0; i < line; ++i) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
    auto const indent = text.substr(0, text.find_first_not_of(" \t"));
    auto const tab = indent.find('\t');
    return tab == indent.npos ? std::nullopt : std::optional(static_cast<int>(tab));
}

std::optional<Opening> open_before(std::string_view text, int line, int offset)
{
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // the parser takes the byte order mark away
    Scan scan(text);
    scan.up_to(line, offset);
    if (scan.long_quote) return scan.long_quote;
    for (auto bracket = scan.brackets.rbegin(); bracket != scan.brackets.rend(); ++bracket)
        if (bracket->line < line) return *bracket;
    return std::nullopt;
}

}  // namespace sluice
