#pragma once

#include <doctest/doctest.h>

#include <string>

//! A text with the first `from`, which must be there, as `to`.
inline std::string changed(std::string text, std::string const& from, std::string const& to)
{
    auto const at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}
