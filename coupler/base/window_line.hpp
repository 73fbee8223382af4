#pragma once

#include <cstdio>
#include <cstring>
#include <optional>
#include <string>

namespace sluice {

//! The window that a participant proposes, as it says it to `sluice check`: "window: 2e-05 s, exact". `exact`: its own
//! step, which every window must be a multiple of.
struct WindowLine
{
    double seconds = 0;
    bool exact = false;
};

inline std::string to_text(WindowLine const& line)
{
    char text[64];
    std::snprintf(text, sizeof text, "window: %.17g s%s", line.seconds, line.exact ? ", exact" : "");
    return text;
}

//! Nothing if the line is another one.
inline std::optional<WindowLine> to_window_line(std::string const& text)
{
    WindowLine line;
    int length = 0;
    if (std::sscanf(text.c_str(), "window: %lf s%n", &line.seconds, &length) != 1 || length == 0) return std::nullopt;
    line.exact = std::strcmp(text.c_str() + length, ", exact") == 0;
    return line;
}

}  // namespace sluice
