#include <algorithm>
#include <utility>

#include "participants/dem/solver.hpp"

namespace dem {
namespace {

//! Calls `visit(record, history, slot)` for each listed contact; the record has its partners.
template <int D, class AnyState, class Visit>
void for_records(AnyState& state, Visit&& visit)
{
    auto& pairs = state.pairs;
    std::size_t const count = state.grains.size();
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot)
            visit(ContactRecord<D>{i, pairs.other[slot], {}, {}}, pairs.history, slot);
    for (std::size_t w = 0; w < state.walls.size(); ++w) {
        auto& contacts = state.walls[w];
        for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
            std::size_t const facet = contacts.facet.empty() ? 0 : contacts.facet[k];
            auto const second = static_cast<std::uint32_t>(count + w + facet * state.walls.size());
            visit(ContactRecord<D>{contacts.grain[k], second, {}, {}}, contacts.history, k);
        }
    }
}

}  // namespace

template <int D>
std::vector<ContactRecord<D>> records_of(State<D> const& state)
{
    std::vector<ContactRecord<D>> records;
    for_records<D>(state, [&](ContactRecord<D> record, History<D> const& history, std::size_t at) {
        if (!history.friction.empty()) record.friction = history.friction[at];
        if (!history.rolling.empty()) record.rolling = history.rolling[at];
        if (record.friction != Tangent<D>{} || record.rolling != Tangent<D>{}) records.push_back(record);
    });
    return records;
}

template <int D>
void set_records(State<D>& state, std::span<ContactRecord<D> const> records)
{
    auto const key = [](ContactRecord<D> const& r) { return std::pair(r.first, r.second); };
    std::vector<ContactRecord<D>> sorted(records.begin(), records.end());
    std::sort(sorted.begin(), sorted.end(), [&](auto const& a, auto const& b) { return key(a) < key(b); });
    for_records<D>(state, [&](ContactRecord<D> const& record, History<D>& history, std::size_t at) {
        auto const found = std::lower_bound(sorted.begin(), sorted.end(), record,
                                            [&](auto const& a, auto const& b) { return key(a) < key(b); });
        if (found == sorted.end() || key(*found) != key(record)) return;
        if (!history.friction.empty()) history.friction[at] = found->friction;
        if (!history.rolling.empty()) history.rolling[at] = found->rolling;
    });
    std::fill(state.pairs.touched.begin(), state.pairs.touched.end(), std::uint8_t{1});
}

template std::vector<ContactRecord<2>> records_of<2>(State<2> const&);
template std::vector<ContactRecord<3>> records_of<3>(State<3> const&);
template void set_records<2>(State<2>&, std::span<ContactRecord<2> const>);
template void set_records<3>(State<3>&, std::span<ContactRecord<3> const>);

}  // namespace dem
