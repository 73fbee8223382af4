#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

//! Levels of the x86-64 instruction set that each solver is built for, and which of them to start.
//! Source of the levels: System V ABI, AMD64 supplement, sec. 3.1.1; v3 has AVX2 and FMA, v4 has AVX-512.
namespace level {

struct Level
{
    std::string_view name;  //!< as of -march, and the folder in lib/sluice
    bool here;              //!< this processor and its operating system have it
};

struct Choice
{
    std::optional<std::string_view> name;  //!< none: why_not says why
    std::string why_not;
};

//! The last level that is here, or the one that is wanted by name (empty: none is). `levels` from low to high.
inline Choice choose(std::span<Level const> levels, std::string_view wanted)
{
    std::string possible;
    std::string_view best;
    for (Level const& level : levels) {
        if (!level.here) continue;
        best = level.name;
        possible += (possible.empty() ? "" : ", ") + std::string(level.name);
    }
    if (wanted.empty()) return {best, {}};
    auto const start = "SLUICE_ISA=" + std::string(wanted) + ": ";
    auto const advice = " (possible here: " + possible + "). Unset it to take the best.";
    for (Level const& level : levels) {
        if (level.name != wanted) continue;
        if (level.here) return {level.name, {}};
        return {{}, start + "this processor does not have it" + advice};
    }
    return {{}, start + "no such instruction set" + advice};
}

}  // namespace level
