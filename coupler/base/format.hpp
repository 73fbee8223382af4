#pragma once

#include <cstdio>
#include <string>

namespace sluice {

//! A message by a pattern of printf; beyond 400 characters it is cut off.
template <class... Value>
std::string format(char const* pattern, Value... value)
{
    char text[401];
    std::snprintf(text, sizeof text, pattern, value...);
    return text;
}

}  // namespace sluice
