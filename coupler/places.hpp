#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <unordered_map>
#include <vector>

//! Where points of one list stand in another one, by their lasting ids.
namespace sluice {

inline bool same_ids(std::span<std::int64_t const> a, std::span<std::int64_t const> b)
{
    if (a.size() != b.size()) return false;
    return a.data() == b.data() || a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

inline bool is_ascending(std::span<std::int64_t const> ids)
{
    for (std::size_t i = 1; i < ids.size(); ++i)
        if (ids[i] <= ids[i - 1]) return false;
    return true;
}

inline constexpr std::size_t nowhere = ~std::size_t{0};

//! For each point of `now` its place in `before`; nowhere: it is new.
inline std::vector<std::size_t> places_of(std::span<std::int64_t const> now, std::span<std::int64_t const> before)
{
    std::vector<std::size_t> places(now.size(), nowhere);
    if (is_ascending(now) && is_ascending(before)) {
        for (std::size_t i = 0, k = 0; i < now.size(); ++i) {
            while (k < before.size() && before[k] < now[i]) ++k;
            if (k < before.size() && before[k] == now[i]) places[i] = k;
        }
        return places;
    }
    std::unordered_map<std::int64_t, std::size_t> at;
    at.reserve(before.size());
    for (std::size_t k = 0; k < before.size(); ++k) at.emplace(before[k], k);
    for (std::size_t i = 0; i < now.size(); ++i)
        if (auto const found = at.find(now[i]); found != at.end()) places[i] = found->second;
    return places;
}

}  // namespace sluice
