#include "participants/mpm/measures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "participants/mpm/axial.hpp"
#include "participants/mpm/cell.hpp"

namespace mpm {
namespace {

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

//! Volume over x, in strips of a quarter of a cell from the back wall on.
class Depth
{
 public:
    Depth(double cell, double across) : strip_(cell / in_a_cell), across_(across) {}

    void add(double from, double to, double volume)
    {
        double const share = volume / (to - from);
        for (double x = std::max(0.0, from); x < to;) {
            auto const strip = static_cast<std::size_t>(std::floor(x / strip_ + 1e-9));
            double const end = std::min(to, static_cast<double>(strip + 1) * strip_);
            if (strip >= volume_.size()) volume_.resize(strip + 1, 0.0);
            volume_[strip] += share * (end - x);
            x = end;
        }
    }
    //! Where the mean over two cells falls below `depth`, coming from the back wall; 0: it is nowhere as deep.
    double front(double depth) const
    {
        double sum = 0, before = 0;
        bool reached = false;
        for (std::size_t k = 0; k <= volume_.size() + window; ++k) {
            if (k < volume_.size()) sum += volume_[k];
            if (k >= window && k - window < volume_.size()) sum -= volume_[k - window];
            double const now = sum / (window * strip_ * across_), middle = static_cast<double>(k + 1) - window / 2.0;
            if (reached && now < depth) return strip_ * (middle - (depth - now) / (before - now));
            reached = reached || now >= depth;
            before = now;
        }
        return 0;
    }

 private:
    static constexpr std::size_t in_a_cell = 4, window = 2 * in_a_cell;
    double strip_, across_;
    std::vector<double> volume_;
};

}  // namespace

template <int D>
RunOut run_out_of(Setup<D> const& setup, State<D> const& state, double depth)
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
    Depth depth_at(setup.cell, D == 2 ? 1 : setup.cell * setup.cells[1]);
    for (Point<D> const& p : state.points) {
        double const reach = p.place[0] + half, top = p.place[D - 1] + half;
        out.foremost = std::max(out.foremost, reach);
        if (cells[cell_of(setup, p.place)].set != main) continue;
        depth_at.add(p.place[0] - half, reach, p.volume / girth(setup.symmetry, p.place));
        if (p.place[0] < 2 * setup.cell) out.height = std::max(out.height, top);
    }
    out.front = depth_at.front(depth);
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

template RunOut run_out_of<2>(Setup<2> const&, State<2> const&, double);
template RunOut run_out_of<3>(Setup<3> const&, State<3> const&, double);
template Vec<2> centre_of_mass<2>(State<2> const&);
template Vec<3> centre_of_mass<3>(State<3> const&);

}  // namespace mpm
