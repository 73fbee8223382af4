#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "participants/lbm/coverage.hpp"
#include "participants/lbm/relaxation.hpp"
#include "tests/participants/lbm/plain_central.hpp"

//! The oracle in space: the equations as they stand in the solver's README, one cell at a time, two grids, relaxation
//! in moments that Gram and Schmidt make of powers of the velocity, orthogonal with the weights. Slow and plain on
//! purpose; shares with the solver the constants, the rates and the spheres' fractions.
class PlainSpace
{
 public:
    explicit PlainSpace(lbm::Config const& config)
        : config_(config),
          rates_(lbm::relaxation(config)),
          n_(config.cells()),
          now_(L::directions * static_cast<std::size_t>(n_[0] * n_[1] * n_[2])),
          next_(now_.size())
    {
        make_moments();
    }

    std::vector<double>& populations() { return now_; }                         //!< f_q - w_q, shape [q][z][y][x]
    std::vector<std::array<double, 6>> const& loads() const { return loads_; }  //!< force, torque of each sphere

    void step(std::vector<lbm::Body<3>> const& spheres, lbm::Coverage<3> const& coverage)
    {
        loads_.assign(spheres.size(), {});
        std::vector<std::map<std::size_t, double>> covered(now_.size() / L::directions);  // of each cell, by sphere
        for (lbm::Strip<3> const& s : all_strips(spheres.size(), coverage))
            for (std::ptrdiff_t k = 0; k < s.count; ++k)
                covered[static_cast<std::size_t>(s.row * n_[0] + s.begin + k)][static_cast<std::size_t>(s.body)] +=
                    s.fraction(k);
        for (std::ptrdiff_t z = 0; z < n_[2]; ++z)
            for (std::ptrdiff_t y = 0; y < n_[1]; ++y)
                for (std::ptrdiff_t x = 0; x < n_[0]; ++x) collide({x, y, z}, spheres, covered[at(0, {x, y, z})]);
        now_.swap(next_);
    }

 private:
    using L = lbm::Lattice<3>;
    using Cell = std::array<std::ptrdiff_t, 3>;
    using Values = std::array<double, L::directions>;
    struct Moment
    {
        int kind;  //!< of its rate; 0: conserved
        Values values;
        double square;  //!< product with itself
    };

    static std::vector<lbm::Strip<3>> all_strips(std::size_t spheres, lbm::Coverage<3> const& coverage)
    {
        std::vector<lbm::Strip<3>> all;
        for (std::size_t i = 0; i < spheres; ++i)
            for (auto [k, end] = coverage.of_body(i); k < end; ++k) all.push_back(coverage.strips()[k]);
        return all;
    }

    std::size_t at(std::size_t q, Cell const& c) const
    {
        return static_cast<std::size_t>(((static_cast<std::ptrdiff_t>(q) * n_[2] + c[2]) * n_[1] + c[1]) * n_[0] +
                                        c[0]);
    }

    //! Powers of the velocity by their order; each is made orthogonal to those before.
    void make_moments()
    {
        struct Power
        {
            int x, y, z;
        };
        std::vector<std::pair<Power, int>> const powers = {
            {{0, 0, 0}, 0},     {{1, 0, 0}, 0},      {{0, 1, 0}, 0},       {{0, 0, 1}, 0},     {{1, 1, 0}, shear},
            {{1, 0, 1}, shear}, {{0, 1, 1}, shear},  {{-2, 0, 0}, energy}, {{2, 0, 0}, shear}, {{0, 2, 0}, shear},
            {{2, 1, 0}, flux},  {{2, 0, 1}, flux},   {{1, 2, 0}, flux},    {{0, 2, 1}, flux},  {{1, 0, 2}, flux},
            {{0, 1, 2}, flux},  {{2, 2, 0}, square}, {{2, 0, 2}, square},  {{0, 2, 2}, square}};
        for (auto const& [power, kind] : powers) {
            Values v{};
            for (std::size_t q = 0; q < v.size(); ++q) {
                auto const& c = L::c[q];
                v[q] = power.x < 0 ? dot(c, c)
                                   : std::pow(c[0], power.x) * std::pow(c[1], power.y) * std::pow(c[2], power.z);
            }
            for (Moment const& m : moments_) {
                double const share = product(v, m.values) / m.square;
                for (std::size_t q = 0; q < v.size(); ++q) v[q] -= share * m.values[q];
            }
            moments_.push_back({kind, v, product(v, v)});
        }
    }
    static double dot(std::array<int, 3> const& a, std::array<int, 3> const& b)
    {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    static double product(Values const& a, Values const& b)
    {
        double sum = 0;
        for (std::size_t q = 0; q < a.size(); ++q) sum += L::weight[q] * a[q] * b[q];
        return sum;
    }

    void collide(Cell const& cell, std::vector<lbm::Body<3>> const& spheres,
                 std::map<std::size_t, double> const& covered)
    {
        Values f;
        for (std::size_t q = 0; q < f.size(); ++q) f[q] = now_[at(q, cell)];
        std::array<double, 3> const force = rates_.force;
        std::array<double, 3> j = {force[0] / 2, force[1] / 2, force[2] / 2}, u;
        double rho = 1;
        for (std::size_t q = 0; q < f.size(); ++q) {
            rho += f[q];
            for (std::size_t k = 0; k < 3; ++k) j[k] += L::c[q][k] * f[q];
        }
        auto const [fraction, full_weight, open, radius] = solid(cell, spheres, covered);
        double const weight = full_weight * eased(cell, spheres, covered, j, rho, full_weight * fraction, radius),
                     b = fraction * weight;
        std::array<double, 3> push = {-2 * b * j[0], -2 * b * j[1], -2 * b * j[2]};  // of the solids on the fluid
        for (auto const& [i, eps] : covered) {
            auto const r = arm(cell, spheres[i]);
            auto const us = velocity(cell, spheres[i]);
            std::array<double, 3> load;
            for (std::size_t k = 0; k < 3; ++k) {
                push[k] += 2 * weight * eps * rho * us[k];
                load[k] = 2 * eps * weight * (j[k] - rho * us[k]);
                loads_[i][k] += load[k];
            }
            loads_[i][3] += r[1] * load[2] - r[2] * load[1];
            loads_[i][4] += r[2] * load[0] - r[0] * load[2];
            loads_[i][5] += r[0] * load[1] - r[1] * load[0];
        }
        for (std::size_t k = 0; k < 3; ++k) u[k] = (j[k] + push[k] / 2) / rho;
        if (config_.collision == lbm::Operator::central) {
            std::array<double, 3> const all = {force[0] + push[0], force[1] + push[1], force[2] + push[2]};
            f = in_central_moments_.collided(
                f, {rho, u, all, open}, [&](double deviator) { return shear_rate(fraction, deviator, rho, open); });
            for (std::size_t q = 0; q < f.size(); ++q) send(q, cell, f[q]);
            return;
        }
        Values source, apart;
        double const uF = u[0] * force[0] + u[1] * force[1] + u[2] * force[2];
        for (std::size_t q = 0; q < f.size(); ++q) {
            double const cF = lbm::dot(L::c[q], force), cu = lbm::dot(L::c[q], u);
            source[q] = L::weight[q] * (3 * (cF - uF) + 9 * cu * cF + 3 * lbm::dot(L::c[q], push));
            apart[q] = f[q] + source[q] / 2 - lbm::equilibrium<3>(q, rho - 1, u);
        }
        Values const relaxed = relax(apart, rho, fraction, open);
        for (std::size_t q = 0; q < f.size(); ++q) send(q, cell, f[q] + source[q] + relaxed[q]);
    }

    static double stiffened(double rate, double open) { return 1 / (0.5 + (1 / rate - 0.5) / open); }

    //! `stress`: without its trace. Less solid than eddies are stopped by does not make it more viscous.
    double shear_rate(double fraction, double stress, double rho, double open) const
    {
        double const tau = rates_.tau;
        if (rates_.smagorinsky_term == 0 || fraction > 1e-6) return stiffened(rates_.shear, open);
        return 2 / (tau + std::sqrt(tau * tau + rates_.smagorinsky_term * std::sqrt(2.0) * stress / rho));
    }

    //! Change by relaxation, moment by moment.
    Values relax(Values const& apart, double rho, double fraction, double open) const
    {
        std::array<double, 4> rate{};
        rate[shear - 1] = rates_.shear, rate[energy - 1] = rates_.energy, rate[square - 1] = rates_.square,
                     rate[flux - 1] = rates_.flux;
        double stress = 0;
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b) {
                double p = 0;
                for (std::size_t q = 0; q < apart.size(); ++q)
                    p += (L::c[q][a] * L::c[q][b] - (a == b ? dot(L::c[q], L::c[q]) / 3 : 0)) * apart[q];
                stress += p * p;
            }
        for (double& r : rate) r = stiffened(r, &r == &rate[flux - 1] ? 1 / open : open);
        rate[shear - 1] = shear_rate(fraction, std::sqrt(stress), rho, open);
        Values change{};
        for (auto const& [kind, moment, square_of_moment] : moments_) {
            if (kind == 0) continue;
            double m = 0;
            for (std::size_t q = 0; q < apart.size(); ++q) m += moment[q] * apart[q];
            double const by_rate = rate[static_cast<std::size_t>(kind) - 1] * m / square_of_moment;
            for (std::size_t q = 0; q < apart.size(); ++q) change[q] -= L::weight[q] * moment[q] * by_rate;
        }
        return change;
    }

    //! Sum of the fractions, B/sum, how open the cell is, mean radius (core: 0).
    std::array<double, 4> solid(Cell const& cell, std::vector<lbm::Body<3>> const& spheres,
                                std::map<std::size_t, double> const& covered) const
    {
        double const t = rates_.tau - 0.5;
        double fraction = 0, drag = 0, lag = 0, curvature = 0;
        bool core = false;
        for (auto const& [i, eps] : covered) {
            fraction += eps;
            curvature += eps / spheres[i].radius;
            auto const& v = spheres[i].velocity;
            lag += 0.1 * std::pow(std::hypot(v[0], v[1], v[2]) / (t / 3), 2) * eps;
            drag += (4.5 / spheres[i].radius + 0.03) * t * eps;
            auto const r = arm(cell, spheres[i]);
            core = core || std::hypot(r[0], r[1], r[2]) <= spheres[i].radius - 2.18;
        }
        if (fraction == 0) return {0, 0, 1, 0};
        double b = std::min(0.98, fraction >= 1 ? 1 : drag / (1 - fraction + drag));
        if (core) b = 0.5;
        return {fraction, b / fraction,
                core ? 1 : (std::max(1 - fraction, 0.05) + lag / fraction) / (1 + lag / fraction),
                core ? 0 : fraction / curvature};
    }

    //! B of a cell by inertia, over what it is without: B/(1 - B) is (1 + q/3)/(1 + q) times as large.
    double eased(Cell const& cell, std::vector<lbm::Body<3>> const& spheres,
                 std::map<std::size_t, double> const& covered, std::array<double, 3> const& j, double rho, double b,
                 double radius) const
    {
        if (b == 0) return 1;
        double fraction = 0;
        std::array<double, 3> solid{};  // velocity
        for (auto const& [i, eps] : covered) {
            fraction += eps;
            auto const us = velocity(cell, spheres[i]);
            for (std::size_t k = 0; k < 3; ++k) solid[k] += eps * us[k];
        }
        for (double& v : solid) v /= fraction;
        double const q = 0.45 * radius / ((rates_.tau - 0.5) / 3) *
                         std::hypot(j[0] / rho - solid[0], j[1] / rho - solid[1], j[2] / rho - solid[2]);
        double const odds = b / (1 - b) * (1 + q / 3) / (1 + q);
        return odds / (1 + odds) / b;
    }

    std::array<double, 3> velocity(Cell const& cell, lbm::Body<3> const& sphere) const
    {
        auto const r = arm(cell, sphere);
        auto const& [w, v] = std::pair{sphere.spin, sphere.velocity};
        return {v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]};
    }

    //! From a sphere's centre to a cell's, across periodic sides.
    std::array<double, 3> arm(Cell const& cell, lbm::Body<3> const& sphere) const
    {
        std::array<double, 3> r;
        for (std::size_t k = 0; k < 3; ++k) {
            r[k] = static_cast<double>(cell[k]) + 0.5 - sphere.centre[k];
            double const length = static_cast<double>(n_[k]);
            if (config_.periodic(k)) r[k] -= length * std::round(r[k] / length);
        }
        return r;
    }

    void send(std::size_t q, Cell const& from, double f)
    {
        Cell to;
        std::array<double, 3> const* wall = nullptr;
        static constexpr std::array<double, 3> at_rest{};  // what comes through an edge is
        for (std::size_t k = 3; k-- > 0;) {
            to[k] = from[k] + L::c[q][k];
            bool const beyond = to[k] < 0 || to[k] >= n_[k];
            if (!beyond || config_.periodic(k)) continue;
            auto const& velocity = config_.walls[2 * k + (to[k] < 0 ? 0 : 1)].velocity;
            wall = wall == nullptr ? &velocity : &at_rest;
        }
        if (wall != nullptr) {
            std::size_t const back = L::opposite[q];
            next_[at(back, from)] = f + 6 * L::weight[back] * lbm::dot(L::c[back], *wall);
            return;
        }
        for (std::size_t k = 0; k < 3; ++k) to[k] = (to[k] + n_[k]) % n_[k];
        next_[at(q, to)] = f;
    }

    static constexpr int shear = 1, energy = 2, square = 3, flux = 4;
    lbm::Config config_;
    lbm::Relaxation rates_;
    Cell n_;
    std::vector<Moment> moments_;
    PlainCentral<3> in_central_moments_;
    std::vector<double> now_, next_;
    std::vector<std::array<double, 6>> loads_;
};
