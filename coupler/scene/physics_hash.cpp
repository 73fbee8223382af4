#include <xxhash.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "coupler/scene/scene.hpp"

namespace sluice {

std::uint64_t physics_hash(Scene const& scene)
{
    constexpr std::array aside{"time.end", "checkpoint.", "timeouts.", "on-death"};
    std::istringstream lines(scene.canonical);
    std::string kept;
    for (std::string line; std::getline(lines, line);)
        if (std::none_of(aside.begin(), aside.end(), [&](char const* key) { return line.starts_with(key); }))
            kept += line + "\n";
    return XXH3_64bits(kept.data(), kept.size());
}

}  // namespace sluice
