#pragma once

#include <string_view>

//! Whether a message has a part.
inline bool contains(std::string_view text, std::string_view part)
{
    return text.find(part) != std::string_view::npos;
}
