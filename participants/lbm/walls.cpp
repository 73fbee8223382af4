#include "participants/lbm/walls.hpp"

#include "participants/lbm/config.hpp"

namespace lbm {
namespace {

//! Populations of direction q that enter the cells [begin, end) of row y through the bottom or top wall.
void bounce_row(Populations& p, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t begin, std::ptrdiff_t end, double speed)
{
    double* const in = p.row(q, y);
    double const* const out = p.row(static_cast<std::size_t>(opposite[q]), y - cy[q]) - cx[q];
    double const push = 6.0 * weight[q] * cx[q] * speed;
    for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = out[x] + push;
}

//! Populations of direction q that enter the cells [begin, end) of row y through the periodic bottom or top.
void wrap_row(Populations& p, std::size_t q, std::ptrdiff_t y, std::ptrdiff_t begin, std::ptrdiff_t end)
{
    double* const in = p.row(q, y);
    double const* const out = p.row(q, y + cy[q] * p.ny());
    for (std::ptrdiff_t x = begin; x < end; ++x) in[x] = out[x];
}

void enter_cell_from_side(Populations& p, std::size_t q, std::ptrdiff_t x, std::ptrdiff_t y, Walls const& walls)
{
    bool const beyond_y = y - cy[q] < 0 || y - cy[q] >= p.ny();
    if (beyond_y && !walls.periodic_y) {
        bounce_row(p, q, y, x, x + 1, walls.velocity[y == 0 && cy[q] > 0 ? bottom : top]);
    } else if (!walls.periodic_x) {
        double const push = 6.0 * weight[q] * cy[q] * walls.velocity[cx[q] > 0 ? left : right];
        p.row(q, y)[x] = p.row(static_cast<std::size_t>(opposite[q]), y - cy[q])[x - cx[q]] + push;
    } else {
        std::ptrdiff_t const from = beyond_y ? y + cy[q] * p.ny() : y;
        p.row(q, y)[x] = p.row(q, from)[x + cx[q] * p.nx()];
    }
}

}  // namespace

void enter_from_outside(Populations& p, std::ptrdiff_t y, Walls const& walls)
{
    std::ptrdiff_t const nx = p.nx();
    for (std::size_t q = 1; q < directions; ++q) {
        std::ptrdiff_t const begin = cx[q] > 0 ? 1 : 0;
        std::ptrdiff_t const end = cx[q] < 0 ? nx - 1 : nx;
        if (y - cy[q] < 0 || y - cy[q] >= p.ny()) {
            if (walls.periodic_y) {
                wrap_row(p, q, y, begin, end);
            } else {
                bounce_row(p, q, y, begin, end, walls.velocity[cy[q] > 0 ? bottom : top]);
            }
        }
        if (cx[q] > 0) enter_cell_from_side(p, q, 0, y, walls);
        if (cx[q] < 0) enter_cell_from_side(p, q, nx - 1, y, walls);
    }
}

}  // namespace lbm
