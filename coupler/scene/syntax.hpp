#pragma once

#include <optional>
#include <string_view>

namespace sluice {

//! A quote or bracket of a YAML text, where it stands: line and byte offset in it, both from 0.
struct Opening
{
    int line = 0, offset = 0;
    char sign = 0;
};

//! Where a parser stumbles is often not where the mistake is. Looks through `text` up to the place (line, byte offset,
//! both from 0) where it stumbled for what was opened on an earlier line: a bracket that is not closed there, or a
//! quote that is closed on another line than its own. A quote that is never closed counts.
std::optional<Opening> open_before(std::string_view text, int line, int offset);

//! The byte offset (from 0) of a tab that indents the line (from 0), if there is one.
std::optional<int> tab_before(std::string_view text, int line);

}  // namespace sluice
