#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "participants/lbm/kernels.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Collision in central moments, against their definition. Lattice units.
namespace {

template <int D>
lbm::Config config(double viscosity, bool forced)
{
    auto c = unit_config<D>({16, 16, D == 3 ? 16.0 : 0.0}, viscosity);
    c.collision = lbm::Operator::central;
    if (forced) c.acceleration = {0.01, -0.02, D == 3 ? 0.015 : 0.0};
    return c;
}

//! Cells of a row whose populations have nothing in common.
template <int D>
struct Row
{
    static constexpr std::size_t directions = lbm::Lattice<D>::directions;
    static constexpr std::ptrdiff_t cells = 13;
    std::array<std::vector<double>, directions> f;

    Row()
    {
        for (std::size_t q = 0; q < directions; ++q)
            for (int x = 0; x < cells; ++x)
                f[q].push_back(lbm::Lattice<D>::weight[q] * 0.2 * std::sin(1.3 * x + 2.9 * static_cast<double>(q * q)));
    }
    lbm::AnySlots<D> slots()
    {
        lbm::AnySlots<D> all;
        for (std::size_t q = 0; q < directions; ++q) all[q] = f[q].data();
        return all;
    }
    //! Sum of (c_a - u_a)^p_a f over the populations of a cell.
    double moment(std::size_t x, std::array<double, 3> const& u, std::array<int, 3> const& power) const
    {
        double sum = 0;
        for (std::size_t q = 0; q < directions; ++q) {
            double term = f[q][x] + lbm::Lattice<D>::weight[q];
            for (std::size_t k = 0; k < D; ++k) term *= std::pow(lbm::Lattice<D>::c[q][k] - u[k], power[k]);
            sum += term;
        }
        return sum;
    }
};

std::array<int, 3> powers(std::size_t a, int p, std::size_t b = 0, int q = 0)
{
    std::array<int, 3> all{};
    all[a] += p;
    all[b] += q;
    return all;
}

template <int D>
void check_moments(bool forced)
{
    auto const c = config<D>(0.013, forced);
    lbm::Relaxation const r = lbm::relaxation(c);
    Row<D> const before;
    Row<D> after;
    lbm::kernels_of<D>(c).fluid(after.slots(), {0, Row<D>::cells}, r, {});
    constexpr double rounding = 1e-14;
    for (std::size_t x = 0; x < Row<D>::cells; ++x) {
        constexpr std::array<double, 3> rest{};
        double const rho = before.moment(x, rest, {});
        CHECK(std::abs(after.moment(x, rest, {}) - rho) < rounding);
        std::array<double, 3> u{};
        for (std::size_t a = 0; a < D; ++a) {
            double const j = before.moment(x, rest, powers(a, 1));
            u[a] = (j + 0.5 * r.force[a]) / rho;
            CHECK(std::abs(after.moment(x, rest, powers(a, 1)) - j - r.force[a]) < rounding);
        }
        auto const trace = [&](Row<D> const& row) {
            double sum = 0;
            for (std::size_t a = 0; a < D; ++a) sum += row.moment(x, u, powers(a, 2));
            return sum / D;
        };
        CHECK(std::abs(trace(after) - rho / 3) < rounding);
        for (std::size_t a = 0; a < D; ++a) {
            double const left = before.moment(x, u, powers(a, 2)) - trace(before);
            CHECK(std::abs(after.moment(x, u, powers(a, 2)) - rho / 3 - (1 - r.shear) * left) < rounding);
            for (std::size_t b = 0; b < D; ++b) {
                if (a == b) continue;
                auto const ab = powers(a, 1, b, 1);
                CHECK(std::abs(after.moment(x, u, ab) - (1 - r.shear) * before.moment(x, u, ab)) < rounding);
                // of a moment that relaxes at once half of the force's: c_s^2 F_b/2
                CHECK(std::abs(after.moment(x, u, powers(a, 2, b, 1)) - r.force[b] / 6) < rounding);
                CHECK(std::abs(after.moment(x, u, powers(a, 2, b, 2)) - rho / 9) < rounding);
            }
        }
    }
}

//! The large-eddy model makes of the stress what it does with the other moments of MRT.
template <int D>
void check_large_eddies()
{
    auto c = config<D>(0.001, true);
    c.smagorinsky = 0.2;
    Row<D> central, other;
    lbm::kernels_of<D>(c).fluid(central.slots(), {0, Row<D>::cells}, lbm::relaxation(c), {});
    c.collision = lbm::Operator::mrt;
    lbm::Relaxation const r = lbm::relaxation(c);
    Row<D> const before;
    lbm::kernels_of<D>(c).fluid(other.slots(), {0, Row<D>::cells}, r, {});
    for (std::size_t x = 0; x < Row<D>::cells; ++x) {
        constexpr std::array<double, 3> rest{};
        std::array<double, 3> u{};
        for (std::size_t a = 0; a < D; ++a)
            u[a] = (before.moment(x, rest, powers(a, 1)) + 0.5 * r.force[a]) / before.moment(x, rest, {});
        auto const xy = powers(0, 1, 1, 1);
        double const left = other.moment(x, u, xy), once = before.moment(x, u, xy);
        CHECK(std::abs(central.moment(x, u, xy) - left) < 1e-14);
        CHECK(std::abs(left - (1 - r.shear) * once) > 1e-3 * std::abs(once));  // eddies there are
    }
}

}  // namespace

TEST_CASE("central: large eddies, in the plane and in space")
{
    check_large_eddies<2>();
    check_large_eddies<3>();
}

TEST_CASE("central: what a collision leaves of each central moment, in the plane")
{
    for (bool const forced : {false, true}) check_moments<2>(forced);
}

TEST_CASE("central: what a collision leaves of each central moment, in space")
{
    for (bool const forced : {false, true}) check_moments<3>(forced);
}
