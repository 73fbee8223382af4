#include "participants/lbm/walls.hpp"

namespace lbm {
namespace {

//! Populations of direction q on their way into the cells of a row, from beyond the sides along some axes.
template <int D>
struct Entry
{
    Populations<D>& populations;
    Walls const& walls;
    std::size_t q;
    std::array<int, 3> const& c;
    std::ptrdiff_t y, z;
    std::array<bool, 3> beyond;  //!< along which axes they come from outside

    //! The axis whose wall throws them back; -1: none, they come from the other side.
    int wall() const
    {
        for (int axis = D - 1; axis >= 0; --axis) {
            auto const k = static_cast<std::size_t>(axis);
            if (beyond[k] && !walls.periodic[k]) return axis;
        }
        return -1;
    }

    void come(std::ptrdiff_t begin, std::ptrdiff_t end) const
    {
        double* const in = populations.at(q, y, z);
        if (int const axis = wall(); axis >= 0) {
            auto const k = static_cast<std::size_t>(axis);
            double const push = 6.0 * Lattice<D>::weight[q] * dot(c, walls.velocity[k][c[k] > 0 ? 0 : 1]);
            double const* const out = populations.at(Lattice<D>::opposite[q], y - c[1], z - c[2]) - c[0];
            for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = out[x] + push;
        } else {
            double const* const out = populations.at(q, y + (beyond[1] ? c[1] * populations.ny() : 0),
                                                     z + (beyond[2] ? c[2] * populations.nz() : 0)) +
                                      (beyond[0] ? c[0] * populations.nx() : 0);
            for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = out[x];
        }
    }
};

}  // namespace

template <int D>
void enter_from_outside(Populations<D>& p, std::ptrdiff_t row, Walls const& walls)
{
    std::ptrdiff_t const nx = p.nx(), y = p.y_of(row), z = p.z_of(row);
    for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
        std::array<int, 3> const& c = Lattice<D>::c[q];
        Entry<D> entry{p, walls, q, c, y, z, {}};
        entry.beyond[1] = y - c[1] < 0 || y - c[1] >= p.ny();
        entry.beyond[2] = z - c[2] < 0 || z - c[2] >= p.nz();
        std::ptrdiff_t const begin = c[0] > 0 ? 1 : 0, end = c[0] < 0 ? nx - 1 : nx;
        if (entry.beyond[1] || entry.beyond[2]) entry.come(begin, end);
        entry.beyond[0] = true;
        if (c[0] > 0) entry.come(0, 1);
        if (c[0] < 0) entry.come(nx - 1, nx);
    }
}

template void enter_from_outside<2>(Populations<2>&, std::ptrdiff_t, Walls const&);
template void enter_from_outside<3>(Populations<3>&, std::ptrdiff_t, Walls const&);

}  // namespace lbm
