#include "participants/mpm/measures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace mpm {
namespace {

template <int D>
using Cell = std::array<int, D>;

template <int D>
Cell<D> cell_of(Setup<D> const& setup, Vec<D> const& place)
{
    Cell<D> cell;
    for (std::size_t k = 0; k < D; ++k) {
        auto const a = static_cast<int>(k);
        cell[k] = static_cast<int>(std::floor((place[a] - setup.origin[a]) / setup.cell));
    }
    return cell;
}

//! Cells with points, each with its mass and, once found, the number of its set.
struct Filled
{
    double mass = 0;
    int set = -1;
};

//! Marks all cells that are linked to `start`; returns their mass.
template <int D>
double mark(std::map<Cell<D>, Filled>& cells, Cell<D> const& start, int set)
{
    constexpr int around = D == 2 ? 9 : 27;
    double mass = 0;
    std::vector<Cell<D>> open{start};
    cells[start].set = set;
    while (!open.empty()) {
        Cell<D> const cell = open.back();
        open.pop_back();
        mass += cells[cell].mass;
        for (int n = 0; n < around; ++n) {
            int const step[] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            Cell<D> next = cell;
            for (std::size_t k = 0; k < D; ++k) next[k] += step[k];
            auto const found = cells.find(next);
            if (found == cells.end() || found->second.set >= 0) continue;
            found->second.set = set;
            open.push_back(next);
        }
    }
    return mass;
}

}  // namespace

template <int D>
RunOut run_out_of(Setup<D> const& setup, State<D> const& state)
{
    std::map<Cell<D>, Filled> cells;
    for (Point<D> const& p : state.points) cells[cell_of(setup, p.place)].mass += p.mass;
    int sets = 0, main = 0;
    double most = 0;
    for (auto& [cell, filled] : cells) {
        if (filled.set >= 0) continue;
        double const mass = mark<D>(cells, cell, sets);
        if (mass > most) most = mass, main = sets;
        ++sets;
    }
    RunOut out;
    double const half = setup.half_width * setup.cell;
    for (Point<D> const& p : state.points) {
        double const reach = p.place[0] + half, top = p.place[D - 1] + half;
        out.foremost = std::max(out.foremost, reach);
        if (cells[cell_of(setup, p.place)].set != main) continue;
        out.front = std::max(out.front, reach);
        if (p.place[0] < 2 * setup.cell) out.height = std::max(out.height, top);
    }
    return out;
}

template <int D>
Vec<D> centre_of_mass(State<D> const& state)
{
    Vec<D> sum = Vec<D>::Zero();
    double mass = 0;
    for (Point<D> const& p : state.points) {
        sum += p.mass * p.place;
        mass += p.mass;
    }
    return sum / mass;
}

template RunOut run_out_of<2>(Setup<2> const&, State<2> const&);
template RunOut run_out_of<3>(Setup<3> const&, State<3> const&);
template Vec<2> centre_of_mass<2>(State<2> const&);
template Vec<3> centre_of_mass<3>(State<3> const&);

}  // namespace mpm
