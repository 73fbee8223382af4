#include "participants/dem/neighbours.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string>

#include "coupler/base/error.hpp"

namespace dem {
namespace {

//! Grains sorted by cell: those of cell c are member[begin[c]]..member[begin[c+1]], ids ascending.
struct Grid
{
    double x0, y0, inverse_cell;
    std::size_t columns, rows;
    std::vector<std::uint32_t> begin, member;

    std::size_t column(double x) const
    {
        return std::min(columns - 1, static_cast<std::size_t>((x - x0) * inverse_cell));
    }
    std::size_t row(double y) const { return std::min(rows - 1, static_cast<std::size_t>((y - y0) * inverse_cell)); }
};

Grid make_grid(Grains const& g, double reach)
{
    auto const [left, right] = std::minmax_element(g.x.begin(), g.x.end());
    auto const [bottom, top] = std::minmax_element(g.y.begin(), g.y.end());
    double cell = 2.0 * *std::max_element(g.radius.begin(), g.radius.end()) + reach;
    double const width = *right - *left, height = *top - *bottom;
    double const most = 4.0 * static_cast<double>(g.size()) + 64.0;  // cells: a few flung grains must not cost memory
    while ((width / cell + 1.0) * (height / cell + 1.0) > most) cell *= 2.0;

    Grid grid{*left,
              *bottom,
              1.0 / cell,
              static_cast<std::size_t>(width / cell) + 1,
              static_cast<std::size_t>(height / cell) + 1,
              {},
              {}};
    grid.begin.assign(grid.columns * grid.rows + 1, 0);
    grid.member.resize(g.size());
    std::vector<std::uint32_t> home(g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
        home[i] = static_cast<std::uint32_t>(grid.row(g.y[i]) * grid.columns + grid.column(g.x[i]));
        ++grid.begin[home[i] + 1];
    }
    for (std::size_t c = 0; c + 1 < grid.begin.size(); ++c) grid.begin[c + 1] += grid.begin[c];
    std::vector<std::uint32_t> next(grid.begin.begin(), grid.begin.end() - 1);
    for (std::size_t i = 0; i < g.size(); ++i) grid.member[next[home[i]]++] = static_cast<std::uint32_t>(i);
    return grid;
}

void check_finite(State const& state)
{
    for (std::size_t i = 0; i < state.grains.size(); ++i)
        sluice::require(std::isfinite(state.grains.x[i]) && std::isfinite(state.grains.y[i]), [&] {
            return sluice::Error("dem: grain " + std::to_string(i) +
                                     " has no finite position at t = " + std::to_string(state.time) + " s, step " +
                                     std::to_string(state.steps) + " (must be finite). Try a smaller step.",
                                 sluice::Exit::numerical);
        });
}

//! Copies the springs of the pairs that both lists hold; both rows of a grain are ascending.
void carry_springs(Pairs const& old, Pairs& pairs)
{
    for (std::size_t i = 0; i + 1 < old.first.size(); ++i) {
        std::uint32_t from = old.first[i];
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            while (from < old.first[i + 1] && old.other[from] < pairs.other[slot]) ++from;
            if (from < old.first[i + 1] && old.other[from] == pairs.other[slot]) pairs.spring[slot] = old.spring[from];
        }
    }
}

void rebuild_pairs(Setup const& setup, State& state)
{
    Pairs pairs;
    find_pairs(state.grains, setup.skin, pairs.first, pairs.other);
    pairs.spring.assign(pairs.other.size(), 0.0);
    pairs.sqrt_mass.resize(pairs.other.size());
    if (setup.features.ledger) {
        pairs.lossy_n.assign(pairs.other.size(), 0.0);
        pairs.lossy_t.assign(pairs.other.size(), 0.0);
        pairs.slides.assign(pairs.other.size(), 0);
    }
    auto const& mass = state.grains.mass;
    for (std::size_t i = 0; i < mass.size(); ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            double const other = mass[pairs.other[slot]];
            pairs.sqrt_mass[slot] = std::sqrt(mass[i] * other / (mass[i] + other));
        }
    if (setup.features.friction) carry_springs(state.pairs, pairs);
    state.pairs = std::move(pairs);
}

void rebuild_wall(Wall const& wall, Setup const& setup, State const& state, WallContacts& contacts)
{
    Grains const& g = state.grains;
    WallContacts fresh;
    std::size_t from = 0;
    for (std::size_t i = 0; contacts.active && i < g.size(); ++i) {
        double const distance = dot(Vec2{g.x[i], g.y[i]} - wall.point, wall.normal);
        if (distance - g.radius[i] >= setup.skin) continue;
        sluice::require(distance > 0.0, [&] {
            return sluice::Error("dem: the centre of grain " + std::to_string(i) + " is behind wall \"" + wall.name +
                                     "\" at t = " + std::to_string(state.time) + " s, step " +
                                     std::to_string(state.steps) +
                                     " (must stay on the side its normal points to). Try a larger normal_stiffness.",
                                 sluice::Exit::numerical);
        });
        while (from < contacts.grain.size() && contacts.grain[from] < i) ++from;
        bool const known = from < contacts.grain.size() && contacts.grain[from] == i;
        fresh.grain.push_back(static_cast<std::uint32_t>(i));
        fresh.spring.push_back(known ? contacts.spring[from] : 0.0);
    }
    fresh.active = contacts.active;
    if (setup.features.ledger) {
        fresh.lossy_n.assign(fresh.grain.size(), 0.0);
        fresh.lossy_t.assign(fresh.grain.size(), 0.0);
        fresh.slides.assign(fresh.grain.size(), 0);
    }
    contacts = std::move(fresh);
}

}  // namespace

void find_pairs(Grains const& g, double reach, std::vector<std::uint32_t>& first, std::vector<std::uint32_t>& other)
{
    first.assign(g.size() + 1, 0);
    other.clear();
    if (g.size() == 0) return;
    Grid const grid = make_grid(g, reach);
    for (std::size_t i = 0; i < g.size(); ++i) {
        std::size_t const row = grid.row(g.y[i]), column = grid.column(g.x[i]);
        std::size_t const left = column > 0 ? column - 1 : 0, right = std::min(column + 1, grid.columns - 1);
        auto const start = static_cast<std::ptrdiff_t>(other.size());
        for (std::size_t r = row > 0 ? row - 1 : 0; r <= std::min(row + 1, grid.rows - 1); ++r) {
            std::size_t const end = grid.begin[r * grid.columns + right + 1];  // the cells of a row are contiguous
            for (std::size_t k = grid.begin[r * grid.columns + left]; k < end; ++k) {
                std::uint32_t const j = grid.member[k];
                double const dx = g.x[i] - g.x[j], dy = g.y[i] - g.y[j], near = g.radius[i] + g.radius[j] + reach;
                if (j > i && dx * dx + dy * dy < near * near) other.push_back(j);
            }
        }
        std::sort(other.begin() + start, other.end());
        first[i + 1] = static_cast<std::uint32_t>(other.size());
    }
}

void rebuild_lists(Setup const& setup, State& state)
{
    check_finite(state);
    rebuild_pairs(setup, state);
    state.wall_contacts.resize(setup.walls.size());
    for (std::size_t w = 0; w < setup.walls.size(); ++w)
        rebuild_wall(setup.walls[w], setup, state, state.wall_contacts[w]);
    state.built_x = state.grains.x;
    state.built_y = state.grains.y;
    ++state.rebuilds;
}

}  // namespace dem
