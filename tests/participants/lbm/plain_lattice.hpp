#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "participants/lbm/coverage.hpp"
#include "participants/lbm/relaxation.hpp"
#include "participants/lbm/walls.hpp"
#include "tests/participants/lbm/exact_area.hpp"
#include "tests/participants/lbm/plain_central.hpp"

//! The oracle: the solver's equations as they stand in its README, one cell at a time, two grids, moments by matrix.
//! Slow and plain on purpose; shares with the solver the constants, the rates and nothing else.
class PlainLattice
{
 public:
    PlainLattice(lbm::Config const& config)
        : rates_(lbm::relaxation(config)),
          les_(config.smagorinsky > 0),
          central_(config.collision == lbm::Operator::central),
          nx_(config.cells()[0]),
          ny_(config.cells()[1]),
          now_(lbm::Lattice<2>::directions * static_cast<std::size_t>(nx_ * ny_)),
          next_(now_.size())
    {
        for (std::size_t s = 0; s < 4; ++s)
            wall_[s] = config.walls[s].velocity[s < 2 ? 1 : 0] / config.units().velocity_unit();
        periodic_x_ = config.periodic(0);
        periodic_y_ = config.periodic(1);
    }

    std::vector<double>& populations() { return now_; }                         //!< f_q - w_q, shape [q][y][x]
    std::vector<std::array<double, 3>> const& loads() const { return loads_; }  //!< force, torque of each disc

    void step(std::vector<lbm::Body<2>> const& discs)
    {
        loads_.assign(discs.size(), {0, 0, 0});
        for (std::ptrdiff_t y = 0; y < ny_; ++y) {
            for (std::ptrdiff_t x = 0; x < nx_; ++x) {
                std::array<double, 9> f;
                for (std::size_t q = 0; q < 9; ++q) f[q] = now_[at(q, x, y)];
                collide(f, x, y, discs);
                for (std::size_t q = 0; q < 9; ++q) send(q, x, y, f[q]);
            }
        }
        now_.swap(next_);
    }

 private:
    using Moments = std::array<double, 9>;  //!< rho, e, eps, jx, qx, jy, qy, pxx, pxy

    std::size_t at(std::size_t q, std::ptrdiff_t x, std::ptrdiff_t y) const
    {
        return (q * static_cast<std::size_t>(ny_) + static_cast<std::size_t>(y)) * static_cast<std::size_t>(nx_) +
               static_cast<std::size_t>(x);
    }

    void send(std::size_t q, std::ptrdiff_t x, std::ptrdiff_t y, double f)
    {
        std::ptrdiff_t tx = x + lbm::Lattice<2>::c[q][0], ty = y + lbm::Lattice<2>::c[q][1];
        double wall_x = 0, wall_y = 0;
        bool const over_x = (tx < 0 || tx >= nx_) && !periodic_x_, over_y = (ty < 0 || ty >= ny_) && !periodic_y_;
        double const of_x = wall_[tx < 0 ? lbm::left : lbm::right], of_y = wall_[ty < 0 ? lbm::bottom<2> : lbm::top<2>];
        if (over_y && !over_x) wall_x = of_y;
        if (over_x && !over_y) wall_y = of_x;
        if (over_x || over_y) {
            auto const back = lbm::Lattice<2>::opposite[q];
            next_[at(back, x, y)] =
                f + 6 * lbm::Lattice<2>::weight[back] *
                        (lbm::Lattice<2>::c[back][0] * wall_x + lbm::Lattice<2>::c[back][1] * wall_y);
        } else {
            next_[at(q, (tx + nx_) % nx_, (ty + ny_) % ny_)] = f;
        }
    }

    static Moments moments(std::array<double, 9> const& f)
    {
        Moments m{};
        for (std::size_t q = 0; q < 9; ++q) {
            Moments const b = basis(q);
            for (std::size_t k = 0; k < 9; ++k) m[k] += b[k] * f[q];
        }
        return m;
    }

    static Moments basis(std::size_t q)
    {
        double const x = lbm::Lattice<2>::c[q][0], y = lbm::Lattice<2>::c[q][1], c2 = x * x + y * y;
        return {
            1,    -4 + 3 * c2, 4 - 10.5 * c2 + 4.5 * c2 * c2, x, (-5 + 3 * c2) * x, y, (-5 + 3 * c2) * y, x * x - y * y,
            x * y};
    }

    void collide(std::array<double, 9>& f, std::ptrdiff_t x, std::ptrdiff_t y, std::vector<lbm::Body<2>> const& discs)
    {
        double const t = rates_.tau - 0.5;
        std::vector<double> fraction(discs.size());
        double covered = 0, drag = 0, lag = 0;
        bool core = false;
        for (std::size_t i = 0; i < discs.size(); ++i) {
            auto const [ax, ay] = arm(discs[i], x, y);
            fraction[i] = exact_area(ax - 0.5, ax + 0.5, ay - 0.5, ay + 0.5, discs[i].radius);
            if (std::hypot(ax, ay) > discs[i].radius + 1) fraction[i] = 0;
            covered += fraction[i];
            double const speed = std::hypot(discs[i].velocity[0], discs[i].velocity[1]);
            lag += 0.1 * std::pow(speed / (t / 3), 2) * fraction[i];
            drag += (3.6 / discs[i].radius + 0.03) * t * fraction[i];
            core = core || std::hypot(ax, ay) <= discs[i].radius - 2.13;
        }
        double weight = std::min(0.98, covered >= 1 ? 1 : drag / (1 - covered + drag));
        if (core) weight = 0.5;
        Moments const m = moments(f);
        double const fx = rates_.force[0], fy = rates_.force[1], rho = 1 + m[0];
        double const jx = m[3] + fx / 2, jy = m[5] + fy / 2;
        double push_x = 0, push_y = 0;
        for (std::size_t i = 0; i < discs.size(); ++i) {
            if (fraction[i] == 0) continue;
            double const share = 2 * weight * fraction[i] / covered;
            auto const [ax, ay] = arm(discs[i], x, y);
            double const vx = discs[i].velocity[0] - discs[i].spin[0] * ay,
                         vy = discs[i].velocity[1] + discs[i].spin[0] * ax;
            double const px = share * (jx - rho * vx), py = share * (jy - rho * vy);
            push_x -= px;
            push_y -= py;
            loads_[i][0] += px;
            loads_[i][1] += py;
            loads_[i][2] += ax * py - ay * px;
        }
        double const ux = (jx + push_x / 2) / rho, uy = (jy + push_y / 2) / rho;
        double const gx = fx + push_x, gy = fy + push_y;
        lag = covered > 0 ? lag / covered : 0;
        double const open = core ? 1 : (std::max(1 - covered, 0.05) + lag) / (1 + lag);
        auto const even = [&](double rate) { return 1 / (0.5 + (1 / rate - 0.5) / open); };
        auto const shear_rate = [&](double stress) {  // |(p_xx, 2 p_xy)|
            if (!les_ || covered > 1e-6) return even(rates_.shear);
            return even(2 / (rates_.tau + std::sqrt(rates_.tau * rates_.tau + rates_.smagorinsky_term * stress / rho)));
        };
        if (central_) {
            f = in_central_moments_.collided(f, {rho, {ux, uy}, {gx, gy}, open},
                                             [&](double deviator) { return shear_rate(std::sqrt(2.0) * deviator); });
            return;
        }
        Moments const source = {0,   6 * (ux * fx + uy * fy), -6 * (ux * fx + uy * fy), gx, -gx, gy,
                                -gy, 2 * (ux * fx - uy * fy), ux * fy + uy * fx};
        double const u2 = ux * ux + uy * uy;
        Moments const eq = {m[0],      -2 * m[0] + 3 * rho * u2,  m[0] - 3 * rho * u2, rho * ux, -rho * ux, rho * uy,
                            -rho * uy, rho * (ux * ux - uy * uy), rho * ux * uy};
        Moments d;
        for (std::size_t k = 0; k < 9; ++k) d[k] = m[k] + source[k] / 2 - eq[k];
        double const shear = shear_rate(std::hypot(d[7], 2 * d[8]));
        double const flux = 1 / (0.5 + (1 / rates_.flux - 0.5) * open);
        Moments const s = {0, even(rates_.energy), even(rates_.square), 0, flux, 0, flux, shear, shear};
        Moments change;
        for (std::size_t k = 0; k < 9; ++k) change[k] = source[k] - s[k] * d[k];
        Moments const norm = {9, 36, 36, 6, 12, 6, 12, 4, 4};
        for (std::size_t q = 0; q < 9; ++q) {
            Moments const b = basis(q);
            for (std::size_t k = 0; k < 9; ++k) f[q] += b[k] * change[k] / norm[k];
        }
    }

    //! From a disc's centre to the cell's, the nearest image.
    std::array<double, 2> arm(lbm::Body<2> const& d, std::ptrdiff_t x, std::ptrdiff_t y) const
    {
        double ax = static_cast<double>(x) + 0.5 - d.centre[0], ay = static_cast<double>(y) + 0.5 - d.centre[1];
        auto const lx = static_cast<double>(nx_), ly = static_cast<double>(ny_);
        if (periodic_x_) ax -= lx * std::round(ax / lx);
        if (periodic_y_) ay -= ly * std::round(ay / ly);
        return {ax, ay};
    }

    lbm::Relaxation rates_;
    PlainCentral<2> in_central_moments_;
    bool les_, central_, periodic_x_ = false, periodic_y_ = false;
    std::ptrdiff_t nx_, ny_;
    std::array<double, 4> wall_{};
    std::vector<double> now_, next_;
    std::vector<std::array<double, 3>> loads_;
};
