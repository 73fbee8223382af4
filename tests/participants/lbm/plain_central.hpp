#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "participants/lbm/lattice.hpp"

//! The collision in central moments as its definition has it, for the plain lattices: every moment of a cell about its
//! velocity relaxed on its own, and back by way of moments about rest and the inverse of their matrix.
template <int D>
class PlainCentral
{
 public:
    using L = lbm::Lattice<D>;
    static constexpr std::size_t size = L::directions;
    using Values = std::array<double, size>;
    //! A cell before the collision; u with half of the force. `open`: of its solids (1: none).
    struct Cell
    {
        double rho;
        std::array<double, D> u, force;
        double open;
    };

    PlainCentral() { invert(); }

    //! Populations (f_q - w_q) after the collision; shear_rate(|P|), P the stress without its trace.
    template <class ShearRate>
    Values collided(Values const& f, Cell const& cell, ShearRate&& shear_rate) const
    {
        Values k{}, equilibrium{}, source{};
        Powers const from_u = powers_of(cell.u);
        for (std::size_t m = 0; m < size; ++m) {
            for (std::size_t q = 0; q < size; ++q) k[m] += power(m, q, from_u) * (f[q] + L::weight[q]);
            equilibrium[m] = of_gaussian(m, cell.rho);
            for (std::size_t a = 0; a < D; ++a) source[m] += along(m, a) ? cell.force[a] * rest_of_gaussian(m, a) : 0;
        }
        auto const [trace, deviator] = stress(k, cell.rho);
        double norm = 0;
        for (std::size_t a = 0; a < D; ++a)
            for (std::size_t b = 0; b < D; ++b) norm += deviator[a][b] * deviator[a][b];
        double const shear = shear_rate(std::sqrt(norm)), even = 1 / (0.5 + 0.5 / cell.open),
                     odd = 1 / (0.5 + 0.5 * cell.open);
        for (std::size_t m = 0; m < size; ++m) {
            int const n = order(m);
            if (n == 2) {
                auto const [a, b] = axes(m);
                k[m] = equilibrium[m] + (1 - shear) * deviator[a][b] + (a == b ? (1 - even) * trace / D : 0);
            } else {
                double const rate = n < 2 ? 0 : n == 3 ? odd : even;
                k[m] += source[m] - rate * (k[m] + source[m] / 2 - equilibrium[m]);
            }
        }
        return populations(k, cell.u);
    }

 private:
    using Matrix = std::array<std::array<double, D>, D>;
    static constexpr double sound = 1.0 / 3;  //!< c_s^2

    //! Powers of the velocity: of order 1, of 2 (both kinds), a a b, a a b b.
    static constexpr auto powers = [] {
        std::array<std::array<int, D>, size> all{};
        std::size_t m = 1;
        for (std::size_t a = 0; a < D; ++a) {
            all[m++][a] = 1;
            all[m++][a] = 2;
            for (std::size_t b = 0; b < D; ++b) {
                if (b == a) continue;
                all[m][a] = 2, all[m++][b] = 1;
                if (b < a) continue;
                all[m][a] = 1, all[m++][b] = 1;
                all[m][a] = 2, all[m++][b] = 2;
            }
        }
        return all;
    }();

    static int order(std::size_t m)
    {
        int sum = 0;
        for (int const p : powers[m]) sum += p;
        return sum;
    }
    static bool along(std::size_t m, std::size_t axis) { return powers[m][axis] == 1; }
    static double raised(double x, int power) { return power == 0 ? 1 : power == 1 ? x : x * x; }
    using Powers = std::array<std::array<std::array<double, 3>, 3>, D>;  //!< of c_a - u_a, shape [a][c_a + 1][power]
    static Powers powers_of(std::array<double, D> const& u)
    {
        Powers all;
        for (std::size_t a = 0; a < D; ++a)
            for (int c = -1; c <= 1; ++c)
                for (int p = 0; p < 3; ++p)
                    all[a][static_cast<std::size_t>(c + 1)][static_cast<std::size_t>(p)] = raised(c - u[a], p);
        return all;
    }
    static double power(std::size_t m, std::size_t q, Powers const& all)
    {
        double product = 1;
        for (std::size_t a = 0; a < D; ++a)
            product *= all[a][static_cast<std::size_t>(L::c[q][a] + 1)][static_cast<std::size_t>(powers[m][a])];
        return product;
    }
    //! The mean of these powers in a Gaussian of variance c_s^2 about 0.
    static double of_gaussian(std::size_t m, double rho)
    {
        for (int const p : powers[m]) rho *= p == 1 ? 0 : p == 2 ? sound : 1;
        return rho;
    }
    //! A force moves the Gaussian: d/du_a of the moment.
    static double rest_of_gaussian(std::size_t m, std::size_t axis)
    {
        double rest = 1;
        for (std::size_t a = 0; a < D; ++a)
            if (a != axis) rest *= powers[m][a] == 1 ? 0 : powers[m][a] == 2 ? sound : 1;
        return rest;
    }
    static std::pair<std::size_t, std::size_t> axes(std::size_t m)
    {
        std::size_t first = 0, last = D - 1;
        while (powers[m][first] == 0) ++first;
        while (powers[m][last] == 0) --last;
        return {first, last};
    }
    //! Trace beyond equilibrium, and the rest of the second moments.
    static std::pair<double, Matrix> stress(Values const& k, double rho)
    {
        Matrix p{};
        double trace = -D * sound * rho;
        for (std::size_t m = 0; m < size; ++m) {
            if (order(m) != 2) continue;
            auto const [a, b] = axes(m);
            p[a][b] = p[b][a] = k[m] - (a == b ? sound * rho : 0);
            if (a == b) trace += k[m];
        }
        for (std::size_t a = 0; a < D; ++a) p[a][a] -= trace / D;
        return {trace, p};
    }
    Values populations(Values const& k, std::array<double, D> const& u) const
    {
        Values raw{}, f{};
        constexpr double binomial[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 2, 1}};
        for (std::size_t m = 0; m < size; ++m)
            for (std::size_t n = 0; n < size; ++n) {  // (C + u)^m by powers of C
                double term = k[n];
                for (std::size_t a = 0; a < D && term != 0; ++a) {
                    int const p = powers[m][a], of = powers[n][a];
                    term *= of > p ? 0 : binomial[p][of] * raised(u[a], p - of);
                }
                raw[m] += term;
            }
        for (std::size_t q = 0; q < size; ++q) {
            f[q] = -L::weight[q];
            for (std::size_t m = 0; m < size; ++m) f[q] += inverse_[q][m] * raw[m];
        }
        return f;
    }
    //! Gauss and Jordan, of c^powers; these are whole numbers.
    void invert()
    {
        std::array<Values, size> matrix;
        for (std::size_t m = 0; m < size; ++m)
            for (std::size_t q = 0; q < size; ++q) {
                matrix[m][q] = power(m, q, powers_of({}));
                inverse_[m][q] = m == q;
            }
        for (std::size_t column = 0; column < size; ++column) {
            std::size_t pivot = column;
            for (std::size_t m = column; m < size; ++m)
                if (std::abs(matrix[m][column]) > std::abs(matrix[pivot][column])) pivot = m;
            std::swap(matrix[pivot], matrix[column]);
            std::swap(inverse_[pivot], inverse_[column]);
            double const scale = 1 / matrix[column][column];
            for (std::size_t q = 0; q < size; ++q) matrix[column][q] *= scale, inverse_[column][q] *= scale;
            for (std::size_t m = 0; m < size; ++m) {
                double const times = matrix[m][column];
                if (m == column || times == 0) continue;
                for (std::size_t q = 0; q < size; ++q) {
                    matrix[m][q] -= times * matrix[column][q];
                    inverse_[m][q] -= times * inverse_[column][q];
                }
            }
        }
    }

    std::array<Values, size> inverse_{};
};
