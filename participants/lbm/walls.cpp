#include "participants/lbm/walls.hpp"

#include <algorithm>

namespace lbm {
namespace {

//! A cell's place in Boundary::turned.
template <int D, class Stored>
std::size_t place_beside(Rows<D, Stored> const& p, std::size_t axis, std::ptrdiff_t x, std::ptrdiff_t y,
                         std::ptrdiff_t z)
{
    std::ptrdiff_t const cell = axis == 0 ? z * p.ny() + y : (axis == 1 ? z : y) * p.nx() + x;
    return Lattice<D>::directions * static_cast<std::size_t>(cell);
}

//! Where populations are that come in: direction, and place from that of the cell.
struct Source
{
    std::size_t direction;
    std::array<std::ptrdiff_t, 3> place;
};

//! Populations of direction q on their way into cells, from beyond the sides along some axes.
template <int D>
struct Entry
{
    Walls const& walls;
    std::array<std::ptrdiff_t, 3> const& cells;  //!< of the lattice
    std::size_t q;
    std::array<bool, 3> beyond;  //!< along which axes they come from outside
    std::array<int, 3> const& c = Lattice<D>::c[q];

    Boundary const& side_across(std::size_t axis) const { return walls.side[axis][c[axis] > 0 ? 0 : 1]; }

    //! The axis whose side throws them back, a wall at rest before others; -1: none, they were mirrored or come from
    //! the other side.
    int axis() const
    {
        int found = -1;
        for (int axis = D - 1; axis >= 0; --axis) {
            auto const k = static_cast<std::size_t>(axis);
            if (!beyond[k]) continue;
            Boundary const& side = side_across(k);
            if (side.kind == Border::wall && side.velocity == std::array<double, 3>{}) return axis;
            if (found < 0 && side.kind != Border::periodic && side.kind != Border::slip) found = axis;
        }
        return found;
    }

    //! Of those that were thrown back at an axis(); -1: that left to where these come from, after mirrors and periodic
    //! sides.
    Source source(int across) const
    {
        if (across >= 0) return {Lattice<D>::opposite[q], {-c[0], -c[1], -c[2]}};
        std::array<int, 3> mirrored = c;
        std::array<std::ptrdiff_t, 3> place{};
        for (std::size_t k = 0; k < D; ++k) {
            if (!beyond[k]) continue;
            bool const slip = side_across(k).kind == Border::slip;
            if (slip) mirrored[k] = -c[k];
            place[k] = slip ? -c[k] : c[k] * cells[k];
        }
        auto const& all = Lattice<D>::c;
        return {static_cast<std::size_t>(std::find(all.begin(), all.end(), mirrored) - all.begin()), place};
    }
    //! What a moving wall or the fastest inflow adds.
    double push(Boundary const& side) const { return 6.0 * Lattice<D>::weight[q] * dot(c, side.velocity); }

    //! Over the largest one, where the link crosses the side.
    double profile(Boundary const& side, std::array<std::ptrdiff_t, 3> const& cell) const
    {
        double product = 1;
        for (std::size_t k = 0; k < D; ++k)
            if (!side.profile[k].empty()) product *= side.profile[k][static_cast<std::size_t>(2 * cell[k] + 1 - c[k])];
        return product;
    }

    template <class Stored>
    void come(Rows<D, Stored> const& populations, std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t y,
              std::ptrdiff_t z) const
    {
        Stored* const in = populations.at(q, y, z);
        int const across = axis();
        auto const [from, place] = source(across);
        Stored const* const out = populations.at(from, y + place[1], z + place[2]) + place[0];
        if (across < 0) {
            for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = out[x];
            return;
        }
        auto const k = static_cast<std::size_t>(across);
        Boundary const& side = side_across(k);
        double const added = push(side);
        if (side.kind == Border::wall) {
            for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = static_cast<Stored>(out[x] + added);
        } else if (side.kind == Border::inflow) {
            for (std::ptrdiff_t x = begin; x < end; ++x)
                in[x] = static_cast<Stored>(out[x] + side.share * profile(side, {x, y, z}) * added);
        } else {
            for (std::ptrdiff_t x = begin; x < end; ++x)
                in[x] = static_cast<Stored>(side.turned[place_beside(populations, k, x, y, z) + q] - out[x]);
        }
    }
};

//! For each direction 2 e+(rho of the opening) + (2 - s) (f+ - e+(rho)) of a cell, + the even part, e the shifted
//! equilibrium.
template <int D, class Stored>
void note_cell(Rows<D, Stored> const& p, std::ptrdiff_t row, std::ptrdiff_t x, Walls const& walls,
               double density_excess, double* turned)
{
    constexpr std::size_t directions = Lattice<D>::directions;
    std::array<double, directions> f;
    double excess = 0;
    std::array<double, 3> j = walls.half_force;
    for (std::size_t q = 0; q < directions; ++q) {
        f[q] = p.row(q, row)[x];
        excess += f[q];
        for (std::size_t k = 0; k < 3; ++k) j[k] += Lattice<D>::c[q][k] * f[q];
    }
    std::array<double, D> u, back;
    for (std::size_t k = 0; k < D; ++k) {
        u[k] = j[k] / (1 + excess);
        back[k] = -u[k];
    }
    auto const even = [&](std::size_t q, double of) {
        return 0.5 * (equilibrium<D>(q, of, u) + equilibrium<D>(q, of, back));
    };
    for (std::size_t q = 0; q < directions; ++q)
        turned[q] = 2 * even(q, density_excess) +
                    (2 - walls.even_rate) * (0.5 * (f[q] + f[Lattice<D>::opposite[q]]) - even(q, excess));
}

//! The ends of a row that lies along no side; those of the next one are on their way from memory then.
template <int D, class Stored>
void enter_at_ends(Rows<D, Stored> const& p, std::ptrdiff_t y, std::ptrdiff_t z, std::vector<RowEnd> const& ends)
{
    for (RowEnd const& end : ends) {
        Stored* const into = p.at(end.into, y, z) + end.x;
        Stored const* const from = p.at(end.from, y + end.dy, z + end.dz) + end.from_x;
        *into = static_cast<Stored>(*from + end.push);
        __builtin_prefetch(into + p.stride(), 1);
        __builtin_prefetch(from + p.stride());
    }
}

}  // namespace

template <int D>
std::vector<RowEnd> row_ends(Walls const& walls, Extent const& cells)
{
    std::vector<RowEnd> ends;
    for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
        Entry<D> const entry{walls, cells, q, {true, false, false}};
        if (entry.c[0] == 0) continue;
        Boundary const& side = entry.side_across(0);
        if (side.kind == Border::inflow || side.kind == Border::pressure) return {};
        int const across = entry.axis();
        auto const [from, place] = entry.source(across);
        std::ptrdiff_t const x = entry.c[0] > 0 ? 0 : cells[0] - 1;
        ends.push_back({q, from, x, x + place[0], place[1], place[2], across < 0 ? 0.0 : entry.push(side)});
    }
    return ends;
}

template <int D, class Stored>
void enter_from_outside(Rows<D, Stored> const& p, std::ptrdiff_t row, Walls const& walls)
{
    Extent const cells{p.nx(), p.ny(), p.nz()};
    std::ptrdiff_t const nx = cells[0], y = p.y_of(row), z = p.z_of(row);
    bool const along_side = y == 0 || y == p.ny() - 1 || (D == 3 && (z == 0 || z == p.nz() - 1));
    if (!along_side && !walls.row_ends.empty()) return enter_at_ends(p, y, z, walls.row_ends);
    for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
        std::array<int, 3> const& c = Lattice<D>::c[q];
        Entry<D> entry{walls, cells, q, {}};
        entry.beyond[1] = y - c[1] < 0 || y - c[1] >= p.ny();
        entry.beyond[2] = z - c[2] < 0 || z - c[2] >= p.nz();
        std::ptrdiff_t const begin = c[0] > 0 ? 1 : 0, end = c[0] < 0 ? nx - 1 : nx;
        if (entry.beyond[1] || entry.beyond[2]) entry.come(p, begin, end, y, z);
        entry.beyond[0] = true;
        if (c[0] > 0) entry.come(p, 0, 1, y, z);
        if (c[0] < 0) entry.come(p, nx - 1, nx, y, z);
    }
}

template <int D, class Stored>
void note_turned(Rows<D, Stored> const& p, std::ptrdiff_t row, Walls& walls)
{
    std::array<std::ptrdiff_t, 3> const cells{p.nx(), p.ny(), p.nz()};
    std::ptrdiff_t const y = p.y_of(row), z = p.z_of(row);
    for (std::size_t k = 0; k < D; ++k)
        for (std::size_t end = 0; end < 2; ++end) {
            Boundary& side = walls.side[k][end];
            std::ptrdiff_t const last = end == 0 ? 0 : cells[k] - 1;
            if (side.kind != Border::pressure || (k > 0 && (k == 1 ? y : z) != last)) continue;
            std::ptrdiff_t const from = k == 0 ? last : 0, to = k == 0 ? last + 1 : p.nx();
            for (std::ptrdiff_t x = from; x < to; ++x)
                note_cell(p, row, x, walls, side.density_excess, side.turned.data() + place_beside(p, k, x, y, z));
        }
}

template std::vector<RowEnd> row_ends<2>(Walls const&, Extent const&);
template std::vector<RowEnd> row_ends<3>(Walls const&, Extent const&);
template void enter_from_outside(Rows<2, double> const&, std::ptrdiff_t, Walls const&);
template void enter_from_outside(Rows<2, float> const&, std::ptrdiff_t, Walls const&);
template void enter_from_outside(Rows<3, double> const&, std::ptrdiff_t, Walls const&);
template void enter_from_outside(Rows<3, float> const&, std::ptrdiff_t, Walls const&);
template void note_turned(Rows<2, double> const&, std::ptrdiff_t, Walls&);
template void note_turned(Rows<2, float> const&, std::ptrdiff_t, Walls&);
template void note_turned(Rows<3, double> const&, std::ptrdiff_t, Walls&);
template void note_turned(Rows<3, float> const&, std::ptrdiff_t, Walls&);

}  // namespace lbm
