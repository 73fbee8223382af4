#include <string>
#include <unordered_map>

#include "coupler/base/error.hpp"
#include "coupler/mapping/mapping.hpp"

namespace sluice {

namespace {

using Index = std::unordered_map<std::int64_t, std::uint32_t>;

Index index_of(std::span<std::int64_t const> ids)
{
    Index index;
    index.reserve(ids.size());
    for (std::size_t k = 0; k < ids.size(); ++k) {
        bool const fresh = index.emplace(ids[k], static_cast<std::uint32_t>(k)).second;
        require(fresh, [&] { return Error("mapping by id: two sources have id " + std::to_string(ids[k]) + "."); });
    }
    return index;
}

//! Error that names the first few ids that no source has.
Error missing_error(Index const& index, std::span<std::int64_t const> targets)
{
    std::size_t missing = 0;
    std::string text;
    for (std::int64_t const id : targets)
        if (!index.contains(id) && ++missing <= 5) text += (missing > 1 ? ", " : "") + std::to_string(id);
    return Error("mapping by id: no source has id " + text + (missing > 5 ? ", ..." : "") + " (" +
                 std::to_string(missing) + " of " + std::to_string(targets.size()) +
                 " targets). Map by place instead, or report what is missing.");
}

}  // namespace

Mapping map_by_id(std::span<std::int64_t const> sources, std::span<std::int64_t const> targets, Missing missing)
{
    require(!sources.empty() || targets.empty(), [&] {
        return Error("mapping by id: no sources for " + std::to_string(targets.size()) + " targets (at least 1).");
    });
    Index const index = index_of(sources);
    MappingRows rows;
    for (std::int64_t const id : targets) {
        if (auto const found = index.find(id); found != index.end()) {
            rows.source.push_back(found->second);
            rows.weight.push_back(1.0);
        } else if (missing == Missing::refuse) {
            throw missing_error(index, targets);
        }
        rows.end_row();
    }
    return Mapping(std::move(rows), sources.size());
}

}  // namespace sluice
