#include "participants/dem/neighbours.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/dem/periodic_neighbours.hpp"

namespace dem {
namespace {

//! Grains of similar size sorted by cell: those of cell c are member[begin[c]]..member[begin[c+1]], ascending.
template <int D>
class Grid
{
 public:
    //! Of the grains in `members`, whose largest radius is `largest`.
    Grid(Grains<D> const& g, std::vector<std::uint32_t> const& members, double largest, double reach)
        : cell_(2.0 * largest + reach)
    {
        Vec<D> high{};
        for (int k = 0; k < D; ++k) {
            component<D>(low_, k) = INFINITY;
            component<D>(high, k) = -INFINITY;
        }
        for (std::uint32_t const i : members)
            for (int k = 0; k < D; ++k) {
                double const x = component(g.place[i].centre, k);
                component<D>(low_, k) = std::min(component(low_, k), x);
                component<D>(high, k) = std::max(component(high, k), x);
            }
        if (members.empty()) low_ = high = {};  // sizes with a gap
        double const most =
            4.0 * static_cast<double>(members.size()) + 64.0;  // a few flung grains must not cost memory
        auto const cells = [&] {
            double product = 1.0;
            for (int k = 0; k < D; ++k) product *= component(high - low_, k) / cell_ + 1.0;
            return product;
        };
        while (cells() > most) cell_ *= 2.0;
        std::size_t all = 1;
        for (std::size_t k = 0; k < D; ++k) {
            count_[k] = static_cast<std::ptrdiff_t>(component(high - low_, static_cast<int>(k)) / cell_) + 1;
            all *= static_cast<std::size_t>(count_[k]);
        }
        begin_.assign(all + 1, 0);
        member_.resize(members.size());
        std::vector<std::uint32_t> home(members.size());
        for (std::size_t n = 0; n < members.size(); ++n) {
            auto const at = cell_of(g.place[members[n]].centre);
            std::ptrdiff_t index = 0;
            for (std::size_t k = D; k-- > 0;)
                index = index * count_[k] + std::clamp<std::ptrdiff_t>(at[k], 0, count_[k] - 1);
            home[n] = static_cast<std::uint32_t>(index);
            ++begin_[home[n] + 1];
        }
        for (std::size_t c = 0; c < all; ++c) begin_[c + 1] += begin_[c];
        std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t n = 0; n < members.size(); ++n) member_[next[home[n]]++] = members[n];
    }

    //! Calls visit(j) for all grains in the cells around a point that a grain within `distance` <= one cell may be in.
    template <class Visit>
    void around(Vec<D> point, double distance, Visit&& visit) const
    {
        std::array<std::ptrdiff_t, 3> low{0, 0, 0}, high{0, 0, 0};
        Vec<D> edge;
        for (int k = 0; k < D; ++k) component<D>(edge, k) = distance;
        auto const from = cell_of(point - edge), to = cell_of(point + edge);
        for (std::size_t k = 0; k < D; ++k) {
            low[k] = std::max<std::ptrdiff_t>(from[k], 0);
            high[k] = std::min<std::ptrdiff_t>(to[k], count_[k] - 1);
            if (low[k] > high[k]) return;
        }
        for (std::ptrdiff_t z = low[2]; z <= high[2]; ++z)
            for (std::ptrdiff_t y = low[1]; y <= high[1]; ++y) {
                std::ptrdiff_t const row = (z * count_[1] + y) * count_[0];  // the cells of a row are contiguous
                std::uint32_t const end = begin_[static_cast<std::size_t>(row + high[0] + 1)];
                for (std::uint32_t k = begin_[static_cast<std::size_t>(row + low[0])]; k < end; ++k) visit(member_[k]);
            }
    }

 private:
    std::array<std::ptrdiff_t, D> cell_of(Vec<D> point) const
    {
        constexpr double far = 1e15;  // beyond any grid, within the integers
        std::array<std::ptrdiff_t, D> at;
        for (std::size_t k = 0; k < D; ++k)
            at[k] = static_cast<std::ptrdiff_t>(
                std::clamp(std::floor(component(point - low_, static_cast<int>(k)) / cell_), -far, far));
        return at;
    }

    double cell_;
    Vec<D> low_;
    std::array<std::ptrdiff_t, 3> count_{1, 1, 1};
    std::vector<std::uint32_t> begin_, member_;
};

//! Grains by size: level 0 holds the smallest; the radii of a level differ by less than a factor of two.
template <int D>
std::vector<std::vector<std::uint32_t>> by_size(Grains<D> const& g, std::vector<std::uint8_t>& level)
{
    double smallest = INFINITY;
    for (auto const& place : g.place) smallest = std::min(smallest, place.radius);
    std::vector<std::vector<std::uint32_t>> levels;
    level.resize(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const l = static_cast<std::size_t>(std::log2(g.place[i].radius / smallest));
        if (l >= levels.size()) levels.resize(l + 1);
        level[i] = static_cast<std::uint8_t>(l);
        levels[l].push_back(static_cast<std::uint32_t>(i));
    }
    return levels;
}

}  // namespace

template <int D>
void check_finite(State<D> const& state)
{
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        sluice::require(std::isfinite(norm(state.grains.place[i].centre)), [&] {
            return sluice::Error("dem: grain " + std::to_string(state.grains.id[i]) +
                                     " has no finite position at t = " + std::to_string(state.time) + " s, step " +
                                     std::to_string(state.steps) + " (must be finite). Try a smaller step.",
                                 sluice::Exit::numerical);
        });
}
template void check_finite<2>(State<2> const&);
template void check_finite<3>(State<3> const&);

namespace {

//! An empty history of so many contacts.
template <int D>
History<D> history_of(Features const& features, std::size_t contacts)
{
    History<D> history;
    if (features.friction) history.friction.assign(contacts, {});
    if (features.rolling == Rolling::elastic_plastic) history.rolling.assign(contacts, {});
    return history;
}

template <int D>
void copy_entry(History<D> const& from, std::size_t a, History<D>& to, std::size_t b)
{
    each_array(from, to, [&](auto const& had, auto& has) { has[b] = had[a]; });
}

//! Cuts the grains into ranges of about as many pairs each, between groups that are booked together.
template <int D>
void cut(Pairs<D>& pairs, std::size_t grains, std::size_t count)
{
    pairs.ranges.clear();
    auto const limit = [&](std::size_t k) {
        if (k == count) return static_cast<std::uint32_t>(grains);
        auto const share = static_cast<std::uint32_t>(pairs.other.size() * k / count);
        auto const at = std::lower_bound(pairs.first.begin(), pairs.first.end() - 1, share) - pairs.first.begin();
        return static_cast<std::uint32_t>(
            std::min(grains, (static_cast<std::size_t>(at) + grains_booked / 2) / grains_booked * grains_booked));
    };
    std::vector<std::uint32_t> range_of(grains);
    for (std::size_t k = 0; k < count; ++k) {
        std::uint32_t const begin = limit(k), end = limit(k + 1);
        if (begin == end) continue;
        std::fill(range_of.begin() + begin, range_of.begin() + end, static_cast<std::uint32_t>(pairs.ranges.size()));
        pairs.ranges.push_back({begin, end, {}});
    }
    for (std::uint32_t slot = 0; slot < pairs.other.size(); ++slot)
        if (std::uint32_t const to = range_of[pairs.other[slot]]; to != range_of[pairs.owner[slot]])
            pairs.ranges[to].reaches.push_back(slot);
}

//! A grain that has come so far into another would pass through it, and nothing would show (sweep D10).
template <int D>
void check_apart(State<D> const& state, Pairs<D> const& pairs, std::size_t i, std::size_t slot)
{
    Vec<D> const between = apart(state.grains, pairs, state.cell, i, slot);
    std::size_t const j = pairs.other[slot];
    double const one = state.grains.place[i].radius, other = state.grains.place[j].radius;
    double const larger = std::max(one, other);
    sluice::require(!(dot(between, between) < larger * larger), [&] {
        auto const name = [&](std::size_t k) { return std::to_string(state.grains.id[k]); };
        return sluice::Error("dem: the centre of grain " + name(one < other ? i : j) + " lies within grain " +
                                 name(one < other ? j : i) + " at t = " + std::to_string(state.time) + " s, step " +
                                 std::to_string(state.steps) +
                                 " (grains would pass through each other). Try a larger normal_stiffness.",
                             sluice::Exit::numerical);
    });
}

//! Takes pairs of two ghosts off a list: they are their owners' business.
template <int D>
void leave_out_ghosts(Grains<D> const& g, Pairs<D>& pairs)
{
    std::uint32_t kept = 0, begin = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        std::uint32_t const end = pairs.first[i + 1];
        for (std::uint32_t slot = begin; slot < end; ++slot)
            if (!g.is_ghost(i) || !g.is_ghost(pairs.other[slot])) {
                pairs.other[kept] = pairs.other[slot];
                if (!pairs.image.empty()) pairs.image[kept] = pairs.image[slot];
                ++kept;
            }
        begin = end;
        pairs.first[i + 1] = kept;
    }
    pairs.other.resize(kept);
    if (!pairs.image.empty()) pairs.image.resize(kept);
}

template <int D>
void rebuild_pairs(Setup<D> const& setup, State<D>& state)
{
    Pairs<D> const& old = state.pairs;
    Pairs<D> pairs;
    if (setup.features.periodic)
        find_periodic_pairs(setup, state, pairs.first, pairs.other, pairs.image);
    else
        find_pairs(state.grains, setup.skin, pairs.first, pairs.other);
    if (!state.grains.ghost.empty()) leave_out_ghosts(state.grains, pairs);
    pairs.history = history_of<D>(setup.features, pairs.other.size());
    derive_from_list(setup, pairs, state.grains.size());
    set_sqrt_masses(setup, state.grains, pairs);
    for (std::size_t i = 0; i < state.grains.size(); ++i) {
        std::uint32_t from = old.first.empty() ? 0 : old.first[i];
        std::uint32_t const end = old.first.empty() ? 0 : old.first[i + 1];
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            check_apart(state, pairs, i, slot);
            while (from < end && old.other[from] < pairs.other[slot]) ++from;  // both rows are ascending
            if (from < end && old.other[from] == pairs.other[slot]) copy_entry(old.history, from, pairs.history, slot);
        }
    }
    state.pairs = std::move(pairs);
}

template <int D>
void rebuild_wall(Wall<D> const& wall, Setup<D> const& setup, State<D> const& state, WallContacts<D>& contacts)
{
    Grains<D> const& g = state.grains;
    WallContacts<D> fresh = contacts;
    fresh.built_shift = contacts.shift;
    fresh.grain.clear();
    fresh.facet.clear();
    std::vector<std::size_t> known;  // where the history of a contact is, if it has one
    std::size_t from = 0;
    auto const list = [&](std::size_t i, std::uint32_t facet) {
        auto const key = [&](std::size_t k) {
            return std::pair<std::size_t, std::uint32_t>(contacts.grain[k],
                                                         contacts.facet.empty() ? 0 : contacts.facet[k]);
        };
        std::pair const wanted(i, facet);
        while (from < contacts.grain.size() && key(from) < wanted) ++from;
        known.push_back(from < contacts.grain.size() && key(from) == wanted ? from : contacts.grain.size());
        fresh.grain.push_back(static_cast<std::uint32_t>(i));
    };
    auto const look = [&](auto const& shape) {
        for (std::size_t i = 0; i < g.size(); ++i) {
            if (g.is_ghost(i)) continue;
            Facing<D> const at = shape.facing(g.place[i].centre - contacts.shift);
            if (at.distance - g.place[i].radius >= setup.skin) continue;
            sluice::require(at.distance > 0.0, [&] {
                return sluice::Error(
                    "dem: the centre of grain " + std::to_string(g.id[i]) + " is behind wall \"" + wall.name +
                        "\" at t = " + std::to_string(state.time) + " s, step " + std::to_string(state.steps) +
                        " (must stay on the side its normal points to). Try a larger normal_stiffness.",
                    sluice::Exit::numerical);
            });
            list(i, 0);
        }
    };
    auto const look_at_mesh = [&](Mesh<D> const& mesh) {
        std::vector<std::uint32_t> near;
        for (std::size_t i = 0; i < g.size(); ++i) {
            if (g.is_ghost(i)) continue;
            auto const& [centre, radius] = g.place[i];
            mesh.facets->find_near(centre - contacts.shift, radius + setup.skin, near);
            for (std::uint32_t const facet : near) list(i, facet);
            fresh.facet.insert(fresh.facet.end(), near.begin(), near.end());
        }
    };
    if (auto const* mesh = std::get_if<Mesh<D>>(&wall.shape); mesh && contacts.active)
        look_at_mesh(*mesh);
    else if (contacts.active)
        std::visit(look, wall.shape);
    fresh.history = history_of<D>(setup.features, fresh.grain.size());
    fresh.foot.assign(fresh.facet.size(), {});
    for (std::size_t k = 0; k < known.size(); ++k) {
        if (known[k] == contacts.grain.size()) continue;
        copy_entry(contacts.history, known[k], fresh.history, k);
        if (!fresh.foot.empty()) fresh.foot[k] = contacts.foot[known[k]];
    }
    contacts = std::move(fresh);
}

}  // namespace

template <int D>
void derive_from_list(Setup<D> const& setup, Pairs<D>& pairs, std::size_t grains)
{
    pairs.owner.resize(pairs.other.size());
    for (std::size_t i = 0; i < grains; ++i)
        std::fill(pairs.owner.begin() + pairs.first[i], pairs.owner.begin() + pairs.first[i + 1],
                  static_cast<std::uint32_t>(i));
    pairs.touched.assign(pairs.other.size(), 1);
    if (setup.threads > 1) cut(pairs, grains, static_cast<std::size_t>(setup.threads));
}
template <int D>
void set_sqrt_masses(Setup<D> const& setup, Grains<D> const& g, Pairs<D>& pairs)
{
    pairs.sqrt_mass.resize(pairs.other.size());
    for (std::size_t slot = 0; slot < pairs.other.size(); ++slot) {
        double const a = g.mass[pairs.owner[slot]], b = g.mass[pairs.other[slot]];
        pairs.sqrt_mass[slot] = setup.absolute_damping ? 1.0 : std::sqrt(a * b / (a + b));
    }
}
template void set_sqrt_masses<2>(Setup<2> const&, Grains<2> const&, Pairs<2>&);
template void set_sqrt_masses<3>(Setup<3> const&, Grains<3> const&, Pairs<3>&);
template void derive_from_list<2>(Setup<2> const&, Pairs<2>&, std::size_t);
template void derive_from_list<3>(Setup<3> const&, Pairs<3>&, std::size_t);

template <int D>
void find_pairs(Grains<D> const& g, double reach, std::vector<std::uint32_t>& first, std::vector<std::uint32_t>& other)
{
    first.assign(g.size() + 1, 0);
    other.clear();
    if (g.size() == 0) return;
    std::vector<std::uint8_t> level;
    auto const levels = by_size(g, level);
    std::vector<Grid<D>> grids;
    std::vector<double> largest;
    for (auto const& members : levels) {
        double radius = 0.0;
        for (std::uint32_t const i : members) radius = std::max(radius, g.place[i].radius);
        largest.push_back(radius);
        if (members.empty()) radius = g.place[0].radius;
        grids.emplace_back(g, members, radius, reach);
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> larger;  // (lower, higher) index, of different levels
    for (std::size_t i = 0; i < g.size(); ++i) {
        Place<D> const place = g.place[i];
        auto const start = static_cast<std::ptrdiff_t>(other.size());
        auto const is_near = [&](std::uint32_t j) {
            Vec<D> const apart = place.centre - g.place[j].centre;
            double const near = place.radius + g.place[j].radius + reach;
            return dot(apart, apart) < near * near;
        };
        grids[level[i]].around(place.centre, place.radius + largest[level[i]] + reach, [&](std::uint32_t j) {
            if (j > i && is_near(j)) other.push_back(j);
        });
        for (std::size_t l = level[i] + 1u; l < levels.size(); ++l)
            if (!levels[l].empty())
                grids[l].around(place.centre, place.radius + largest[l] + reach, [&](std::uint32_t j) {
                    auto const self = static_cast<std::uint32_t>(i);
                    if (is_near(j)) larger.emplace_back(std::min(self, j), std::max(self, j));
                });
        std::sort(other.begin() + start, other.end());
        first[i + 1] = static_cast<std::uint32_t>(other.size());
    }
    if (larger.empty()) return;
    std::sort(larger.begin(), larger.end());
    std::vector<std::uint32_t> merged;
    merged.reserve(other.size() + larger.size());
    auto next = larger.begin();
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        auto const start = static_cast<std::ptrdiff_t>(merged.size());
        merged.insert(merged.end(), other.begin() + begin, other.begin() + first[i + 1]);
        for (; next != larger.end() && next->first == i; ++next) merged.push_back(next->second);
        std::sort(merged.begin() + start, merged.end());
        begin = first[i + 1];
        first[i + 1] = static_cast<std::uint32_t>(merged.size());
    }
    other = std::move(merged);
}

template <int D>
void rebuild_lists(Setup<D> const& setup, State<D>& state)
{
    check_finite(state);
    if (setup.features.periodic) put_back(setup.periodic, state);
    list_neighbours(setup, state);
}

template <int D>
void list_neighbours(Setup<D> const& setup, State<D>& state)
{
    rebuild_pairs(setup, state);
    state.walls.resize(setup.walls.size());
    for (std::size_t w = 0; w < setup.walls.size(); ++w) rebuild_wall(setup.walls[w], setup, state, state.walls[w]);
    state.built.resize(state.grains.size());
    for (std::size_t i = 0; i < state.grains.size(); ++i) state.built[i] = state.grains.place[i].centre;
    ++state.rebuilds;
}

template void find_pairs<2>(Grains<2> const&, double, std::vector<std::uint32_t>&, std::vector<std::uint32_t>&);
template void find_pairs<3>(Grains<3> const&, double, std::vector<std::uint32_t>&, std::vector<std::uint32_t>&);
template void rebuild_lists<2>(Setup<2> const&, State<2>&);
template void rebuild_lists<3>(Setup<3> const&, State<3>&);
template void list_neighbours<2>(Setup<2> const&, State<2>&);
template void list_neighbours<3>(Setup<3> const&, State<3>&);

}  // namespace dem
