#include "participants/lbm/fields.hpp"

#include <algorithm>
#include <cmath>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {
namespace {

//! Cell values, lattice units, shape [y][x], before they are averaged.
struct Cells
{
    std::ptrdiff_t nx, ny;
    std::vector<double> excess, ux, uy, fraction;
};

//! Derivative at index i of n by differences of the neighbours; one-sided at an end unless periodic.
template <class At>
double derivative(std::ptrdiff_t i, std::ptrdiff_t n, bool periodic, At&& at)
{
    if (n < 2) return 0;
    if (periodic) return 0.5 * (at((i + 1) % n) - at((i + n - 1) % n));
    if (i == 0) return at(1) - at(0);
    if (i == n - 1) return at(n - 1) - at(n - 2);
    return 0.5 * (at(i + 1) - at(i - 1));
}

double vorticity(Cells const& c, std::ptrdiff_t x, std::ptrdiff_t y, Walls const& walls)
{
    auto const at = [&](std::vector<double> const& v, std::ptrdiff_t i, std::ptrdiff_t j) {
        return v[static_cast<std::size_t>(j * c.nx + i)];
    };
    return derivative(x, c.nx, walls.periodic_x, [&](std::ptrdiff_t i) { return at(c.uy, i, y); }) -
           derivative(y, c.ny, walls.periodic_y, [&](std::ptrdiff_t j) { return at(c.ux, x, j); });
}

}  // namespace

//! Lattice units. In a covered cell the velocity is (1 - B) u + B u_s: the mean of the cell's momentum before and after
//! the collision, hence what flows through it.
void Solver::read_row(std::ptrdiff_t y, RowState& row) const
{
    auto const n = static_cast<std::size_t>(populations_.nx());
    for (auto* v : {&row.excess, &row.ux, &row.uy, &row.fraction}) v->assign(n, 0.0);
    std::vector<double> solid_x(n), solid_y(n);
    for (std::uint32_t const index : coverage_.row(y)) {
        Strip const& s = coverage_.strips()[index];
        bool const moves = s.body < static_cast<std::ptrdiff_t>(discs_.size());
        Disc const disc = moves ? discs_[static_cast<std::size_t>(s.body)] : Disc{};
        for (std::ptrdiff_t k = 0; k < s.count; ++k) {
            auto const x = static_cast<std::size_t>(s.begin + k);
            row.fraction[x] += s.fraction[k];
            solid_x[x] += s.fraction[k] * (disc.ux - disc.spin * s.arm_y);
            solid_y[x] += s.fraction[k] * (disc.uy + disc.spin * (s.arm_x + static_cast<double>(k)));
        }
    }
    double const* f[directions];
    for (std::size_t q = 0; q < directions; ++q) f[q] = populations_.row(q, y);
    for (std::size_t x = 0; x < n; ++x) {
        double excess = 0, jx = 0, jy = 0;
        for (std::size_t q = 0; q < directions; ++q) {
            excess += f[q][x];
            jx += cx[q] * f[q][x];
            jy += cy[q] * f[q][x];
        }
        double const share = weight_per_fraction(row.fraction[x], relaxation_.tau);
        double const solid = share * row.fraction[x];
        row.excess[x] = excess;
        row.ux[x] = (1 - solid) * (jx + 0.5 * relaxation_.force_x) / (1 + excess) + share * solid_x[x];
        row.uy[x] = (1 - solid) * (jy + 0.5 * relaxation_.force_y) / (1 + excess) + share * solid_y[x];
        row.fraction[x] = std::min(row.fraction[x], 1.0);
    }
}

Fields Solver::fields(int coarsen)
{
    complete();
    coverage_.update(discs_, team_);
    Cells c{populations_.nx(), populations_.ny(), {}, {}, {}, {}};
    RowState row;
    for (std::ptrdiff_t y = 0; y < c.ny; ++y) {
        read_row(y, row);
        c.excess.insert(c.excess.end(), row.excess.begin(), row.excess.end());
        c.ux.insert(c.ux.end(), row.ux.begin(), row.ux.end());
        c.uy.insert(c.uy.end(), row.uy.begin(), row.uy.end());
        c.fraction.insert(c.fraction.end(), row.fraction.begin(), row.fraction.end());
    }
    std::ptrdiff_t const k = std::max(coarsen, 1);
    Fields out{.nx = (c.nx + k - 1) / k,
               .ny = (c.ny + k - 1) / k,
               .spacing = static_cast<double>(k) * config_.cell,
               .velocity = {},
               .pressure = {},
               .vorticity = {},
               .solid_fraction = {}};
    LatticeUnits const unit = config_.units();
    for (std::ptrdiff_t by = 0; by < out.ny; ++by) {
        for (std::ptrdiff_t bx = 0; bx < out.nx; ++bx) {
            double sum[5] = {}, cells = 0;
            for (std::ptrdiff_t y = by * k; y < std::min(by * k + k, c.ny); ++y) {
                for (std::ptrdiff_t x = bx * k; x < std::min(bx * k + k, c.nx); ++x) {
                    auto const at = static_cast<std::size_t>(y * c.nx + x);
                    double const value[5] = {c.ux[at], c.uy[at], c.excess[at], vorticity(c, x, y, walls_),
                                             c.fraction[at]};
                    for (int i = 0; i < 5; ++i) sum[i] += value[i];
                    cells += 1;
                }
            }
            out.velocity.push_back(sum[0] / cells * unit.velocity_unit());
            out.velocity.push_back(sum[1] / cells * unit.velocity_unit());
            out.pressure.push_back(unit.pressure(sum[2] / cells));
            out.vorticity.push_back(sum[3] / cells / config_.step);
            out.solid_fraction.push_back(sum[4] / cells);
        }
    }
    return out;
}

double Solver::max_speed()
{
    complete();
    RowState row;
    double square = 0;
    for (std::ptrdiff_t y = 0; y < populations_.ny(); ++y) {
        read_row(y, row);
        for (std::size_t x = 0; x < row.ux.size(); ++x)
            square = std::max(square, row.ux[x] * row.ux[x] + row.uy[x] * row.uy[x]);
    }
    return std::sqrt(square) * config_.units().velocity_unit();
}

}  // namespace lbm
