#include "participants/dem/shipment.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <utility>

namespace dem {
namespace {

//! Where the next rows go.
template <class Row>
std::byte* put_rows(std::byte* to, std::vector<Row> const& rows)
{
    static_assert(std::is_trivially_copyable_v<Row>);
    std::uint64_t const count = rows.size();
    std::memcpy(to, &count, sizeof count);
    to += sizeof count;
    if (count > 0) std::memcpy(to, rows.data(), count * sizeof(Row));
    return to + count * sizeof(Row);
}

template <class Row>
std::byte const* take_rows(std::byte const* from, std::vector<Row>& rows)
{
    std::uint64_t count = 0;
    std::memcpy(&count, from, sizeof count);
    from += sizeof count;
    std::size_t const begin = rows.size();
    rows.resize(begin + count);
    if (count > 0) std::memcpy(rows.data() + begin, from, count * sizeof(Row));
    return from + count * sizeof(Row);
}

//! Indices of rows, ascending by number.
template <int D>
std::vector<std::uint32_t> in_order(std::vector<GrainRow<D>> const& rows)
{
    std::vector<std::uint32_t> order(rows.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return rows[a].number < rows[b].number; });
    return order;
}

template <int D>
void set_grains(std::vector<GrainRow<D>> const& rows, State<D>& state, Census& census)
{
    Grains<D>& g = state.grains;
    g = {};
    state.built.clear();
    census.number.clear();
    census.owner.clear();
    census.index_of.resize(census.all);
    for (std::uint32_t const k : in_order(rows)) {
        GrainRow<D> const& row = rows[k];
        census.index_of[row.number] = static_cast<std::uint32_t>(census.number.size());
        census.number.push_back(row.number);
        census.owner.push_back(row.owner);
        g.id.push_back(row.id);
        g.place.push_back(row.place);
        g.motion.push_back(row.motion);
        g.half.push_back(row.half);
        g.mass.push_back(row.mass);
        g.inertia.push_back(row.inertia);
        g.contact.push_back(row.contact);
        g.external.push_back(row.external);
        state.built.push_back(row.built);
    }
}

//! Indices of the contacts whose grains are here, ascending by first and second grain.
template <int D>
std::vector<std::uint32_t> in_order(std::vector<ContactRow<D>> const& rows, Census const& census)
{
    std::size_t const here = census.number.size();
    std::vector<std::uint32_t> begin(here + 1, 0), kept;
    for (std::uint32_t k = 0; k < rows.size(); ++k) {
        std::uint32_t const i = census.find(rows[k].first);
        bool const wall = rows[k].second >= census.all;
        if (i == here || (!wall && census.find(rows[k].second) == here)) continue;
        ++begin[i + 1];
        kept.push_back(k);
    }
    for (std::size_t i = 0; i < here; ++i) begin[i + 1] += begin[i];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1), order(kept.size());
    for (std::uint32_t const k : kept) order[next[census.index_of[rows[k].first]]++] = k;
    for (std::size_t i = 0; i < here; ++i)
        std::sort(order.begin() + begin[i], order.begin() + begin[i + 1],
                  [&](auto a, auto b) { return rows[a].second < rows[b].second; });
    return order;
}

//! Indices of the facets whose grains are here, ascending by grain and facet.
template <int D>
std::vector<std::uint32_t> in_order(std::vector<FootRow<D>> const& rows, Census const& census)
{
    std::vector<std::uint32_t> order;
    for (std::uint32_t k = 0; k < rows.size(); ++k)
        if (census.find(rows[k].grain) != census.number.size()) order.push_back(k);
    auto const place = [&](std::uint32_t k) { return std::pair(rows[k].grain, rows[k].facet); };
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return place(a) < place(b); });
    return order;
}

template <class Row, int D>
void remember(Row const& row, Features const& features, History<D>& history)
{
    if (features.friction) history.friction.push_back(row.friction);
    if (features.rolling == Rolling::elastic_plastic) history.rolling.push_back(row.rolling);
}

}  // namespace

template <int D>
ranks::Bytes Shipment<D>::to_bytes() const
{
    ranks::Bytes bytes(4 * sizeof(std::uint64_t) + grains.size() * sizeof(GrainRow<D>) +
                       contacts.size() * sizeof(ContactRow<D>) + feet.size() * sizeof(FootRow<D>) +
                       crossings.size() * sizeof(Crossing<D>));
    put_rows(put_rows(put_rows(put_rows(bytes.data(), grains), contacts), feet), crossings);
    return bytes;
}

template <int D>
void Shipment<D>::add(ranks::Bytes const& bytes)
{
    if (bytes.empty()) return;
    take_rows(take_rows(take_rows(take_rows(bytes.data(), grains), contacts), feet), crossings);
}

template <int D>
GrainRow<D> row_of(State<D> const& state, Census const& census, std::size_t i, std::int32_t owner)
{
    Grains<D> const& g = state.grains;
    return {.number = census.number[i],
            .owner = owner,
            .id = g.id[i],
            .mass = g.mass[i],
            .inertia = g.inertia[i],
            .built = state.built[i],
            .place = g.place[i],
            .motion = g.motion[i],
            .half = g.half[i],
            .contact = g.contact[i],
            .external = g.external[i]};
}

template <int D>
void assemble(Shipment<D> const& rows, Features const& features, State<D>& state, Census& census)
{
    set_grains(rows.grains, state, census);
    Pairs<D>& pairs = state.pairs;
    pairs = {};
    pairs.first.assign(census.number.size() + 1, 0);
    for (auto& wall : state.walls) forget_contacts(wall);
    for (std::uint32_t const k : in_order(rows.feet, census)) {
        FootRow<D> const& row = rows.feet[k];
        auto& wall = state.walls[row.wall];
        wall.grain.push_back(census.index_of[row.grain]);
        wall.facet.push_back(row.facet);
        wall.foot.push_back(row.foot);
        remember(row, features, wall.history);
    }
    for (std::uint32_t const k : in_order(rows.contacts, census)) {
        ContactRow<D> const& row = rows.contacts[k];
        std::uint32_t const i = census.index_of[row.first];
        if (row.second >= census.all) {
            auto& wall = state.walls[row.second - census.all];
            wall.grain.push_back(i);
            remember(row, features, wall.history);
            continue;
        }
        ++pairs.first[i + 1];
        pairs.other.push_back(census.index_of[row.second]);
        if (features.periodic) pairs.image.push_back(row.image);
        remember(row, features, pairs.history);
    }
    for (std::size_t i = 0; i < census.number.size(); ++i) pairs.first[i + 1] += pairs.first[i];
    state.crossings.clear();
    for (Crossing<D> const& row : rows.crossings)
        if (std::uint32_t const i = census.find(row.grain); i != census.number.size())
            state.crossings.push_back({i, row.moved, row.sped});
}

#define DEM_SHIPMENT(D)                                                                        \
    template struct Shipment<D>;                                                               \
    template GrainRow<D> row_of<D>(State<D> const&, Census const&, std::size_t, std::int32_t); \
    template void assemble<D>(Shipment<D> const&, Features const&, State<D>&, Census&);
DEM_SHIPMENT(2)
DEM_SHIPMENT(3)
#undef DEM_SHIPMENT

}  // namespace dem
