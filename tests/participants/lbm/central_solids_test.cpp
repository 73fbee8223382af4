#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "participants/lbm/kernels.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/participants/lbm/plain_central.hpp"
#include "tests/participants/lbm/unit_config.hpp"

//! Collision in central moments beside and in solids: what a cell becomes depends on that cell alone. Lattice units.
namespace {

constexpr std::ptrdiff_t cells = 37;  // of no whole number of registers

//! Populations of a row and the solids in it, all different, a third of the cells without solids.
template <int D, class Stored>
struct Row
{
    static constexpr std::size_t directions = lbm::Lattice<D>::directions;
    std::array<std::vector<Stored>, directions> f;
    std::vector<Stored> fraction, weight, open, ease, force_rate;
    std::array<std::vector<Stored>, 3> momentum, force;
    lbm::SolidRow<Stored> solid{};

    Row()
    {
        for (int x = 0; x < cells; ++x) {
            for (std::size_t q = 0; q < directions; ++q)
                f[q].push_back(static_cast<Stored>(lbm::Lattice<D>::weight[q] * 0.2 *
                                                   std::sin(1.3 * x + 2.9 * static_cast<double>(q * q))));
            double const eps = x % 3 == 0 ? 0.0 : 0.5 + 0.5 * std::sin(0.7 * x);
            fraction.push_back(static_cast<Stored>(eps));
            weight.push_back(static_cast<Stored>(0.9 * std::abs(std::cos(x))));
            open.push_back(static_cast<Stored>(eps > 0 ? 1 - 0.95 * eps : 1.0));
            ease.push_back(static_cast<Stored>(D == 3 ? 1 + std::sin(2.0 * x) : 0.0));
            for (std::size_t k = 0; k < D; ++k)
                momentum[k].push_back(static_cast<Stored>(eps * 0.05 * std::sin(x + 2.0 * static_cast<double>(k))));
        }
        force_rate.resize(cells);
        solid = {fraction.data(), weight.data(), open.data(), ease.data(), {}, force_rate.data(), {}};
        for (std::size_t k = 0; k < D; ++k) {
            force[k].resize(cells);
            solid.momentum[k] = momentum[k].data();
            solid.force[k] = force[k].data();
        }
    }
    lbm::AnySlots<D> slots()
    {
        lbm::AnySlots<D> all;
        for (std::size_t q = 0; q < directions; ++q) all[q] = f[q].data();
        return all;
    }
};

template <int D>
lbm::Config config(double smagorinsky, bool framed, lbm::Precision precision)
{
    auto c = unit_config<D>({16, 16, D == 3 ? 16.0 : 0.0}, 0.02);
    c.collision = lbm::Operator::central;
    c.smagorinsky = smagorinsky;
    c.precision = precision;
    c.acceleration = {0.01, -0.02, D == 3 ? 0.015 : 0.0};
    if (framed) c.rotation = sluice::Rotation{.point = {3, 4, 5}, .rate = 0.1};
    return c;
}

//! A cell of the row as the definition has it.
template <int D, class Stored>
typename PlainCentral<D>::Values expected(Row<D, Stored> const& row, std::size_t x, lbm::Relaxation const& r)
{
    static PlainCentral<D> const plain;
    typename PlainCentral<D>::Values f;
    typename PlainCentral<D>::Cell cell{.rho = 1, .u = {}, .force = {}, .open = row.open[x]};
    std::array<double, 3> j{}, force{};
    for (std::size_t k = 0; k < D; ++k) {
        force[k] = r.force[k] + r.slope[k] * static_cast<double>(x);
        j[k] = force[k] / 2;
    }
    for (std::size_t q = 0; q < f.size(); ++q) {
        f[q] = row.f[q][x];
        cell.rho += f[q];
        for (std::size_t k = 0; k < D; ++k) j[k] += lbm::Lattice<D>::c[q][k] * f[q];
    }
    lbm::turn_with_half(r.turn, j[0], j[1], j[2]);
    auto const coriolis = lbm::cross(r.turn, j);
    double const eps = row.fraction[x];
    double slip = 0;
    for (std::size_t k = 0; k < D; ++k) slip += std::pow(eps * j[k] / cell.rho - row.momentum[k][x], 2);
    double const q = row.ease[x] * std::sqrt(slip), b = row.weight[x] * eps, odds = b / (1 - b) * (1 + q / 3) / (1 + q);
    double const share = eps > 0 ? odds / (1 + odds) / eps : 0;  // B/eps
    for (std::size_t k = 0; k < D; ++k) {
        double const push = -2 * share * (eps * j[k] - cell.rho * row.momentum[k][x]);
        cell.force[k] = force[k] - 2 * coriolis[k] + push;
        cell.u[k] = (j[k] + push / 2) / cell.rho;
    }
    double tau = r.tau;
    return plain.collided(f, cell, [&](double stress) {
        if (eps == 0) tau = (tau + std::sqrt(tau * tau + r.smagorinsky_term * std::sqrt(2.0) * stress / cell.rho)) / 2;
        return 1 / (0.5 + (tau - 0.5) / cell.open);
    });
}

template <int D, class Stored>
void check_definition()
{
    // populations below 0.1: in floats some roundings of 2^-24 of the largest moment, 1
    double const rounding = sizeof(Stored) == sizeof(double) ? 1e-14 : 1e-6;
    for (double const smagorinsky : {0.0, 0.2})
        for (bool const framed : {false, true}) {
            auto const c =
                config<D>(smagorinsky, framed,
                          sizeof(Stored) == sizeof(double) ? lbm::Precision::float64 : lbm::Precision::float32);
            lbm::Relaxation r = lbm::relaxation(c);
            if (framed) r.slope = {1e-3, -2e-3, 1e-3}, r.turn = {D == 3 ? 0.02 : 0.0, D == 3 ? -0.01 : 0.0, 0.03};
            Row<D, Stored> const before;
            Row<D, Stored> after, fluid;
            lbm::kernels_of<D>(c).covered(after.slots(), {0, cells}, r, after.solid);
            lbm::kernels_of<D>(c).fluid(fluid.slots(), {0, cells}, r, {});
            for (std::size_t x = 0; x < cells; ++x) {
                CAPTURE(x);
                auto const want = expected(before, x, r);
                for (std::size_t q = 0; q < want.size(); ++q) {
                    CHECK(std::abs(after.f[q][x] - want[q]) < rounding);
                    if (before.fraction[x] == 0) CHECK(std::abs(after.f[q][x] - fluid.f[q][x]) < rounding);
                }
            }
        }
}

//! A periodic box with bodies that move and a solid at rest, as it is after some steps. `shift`: of all that is in it,
//! by so many cells along each axis; `turned`: the axes' next ones take their place.
template <int D>
class Scene
{
 public:
    Scene(double smagorinsky, lbm::Precision precision, std::ptrdiff_t shift, bool turned)
        : shift_(shift), turn_(turned ? 1 : 0)
    {
        auto c = unit_config<D>({}, 0.02);
        c.collision = lbm::Operator::central;
        c.smagorinsky = smagorinsky;
        c.precision = precision;
        for (std::size_t k = 0; k < D; ++k) {
            c.set_periodic(k);
            c.size[place_of(k)] = static_cast<double>(extent[k]);
            c.acceleration[place_of(k)] = 1e-5 * static_cast<double>(k + 1);
        }
        c.solids = {{.name = "rock", .radius = 2.3}};
        auto const rock = placed({14.2, 4.7, 6.3});
        std::copy(rock.begin(), rock.end(), c.solids[0].centre.begin());
        lbm::Solver<D> solver(c);
        solver.set_state([&](std::array<double, D> const& at) { return state(at); });
        for (int step = 0; step < steps; ++step) move(solver, step);
        fields_ = solver.fields();
    }
    //! Velocity and then pressure of a cell of the box as it was not shifted nor turned.
    std::array<double, D + 1> at(std::array<std::ptrdiff_t, 3> const& cell) const
    {
        std::array<std::ptrdiff_t, 3> to{};
        for (std::size_t k = 0; k < D; ++k) to[place_of(k)] = (cell[k] + shift_) % extent[k];
        auto const i = static_cast<std::size_t>((to[2] * fields_.ny + to[1]) * fields_.nx + to[0]);
        std::array<double, D + 1> found;
        for (std::size_t k = 0; k < D; ++k) found[k] = fields_.velocity[D * i + place_of(k)];
        found[D] = fields_.pressure[i];
        return found;
    }
    static constexpr std::array<std::ptrdiff_t, 3> extent = {31, 17, D == 3 ? 14 : 1};
    static constexpr int steps = 30;

 private:
    std::size_t place_of(std::size_t axis) const { return (axis + turn_) % D; }
    std::array<double, D> placed(std::array<double, 3> const& at) const
    {
        std::array<double, D> all;
        for (std::size_t k = 0; k < D; ++k)
            all[place_of(k)] =
                std::fmod(at[k] + static_cast<double>(shift_ + extent[k]), static_cast<double>(extent[k]));
        return all;
    }
    std::array<double, D> pointing(std::array<double, 3> const& v) const
    {
        std::array<double, D> all;
        for (std::size_t k = 0; k < D; ++k) all[place_of(k)] = v[k];
        return all;
    }
    lbm::PointState<D> state(std::array<double, D> const& at) const
    {
        std::array<double, 3> phase{}, velocity{};  // waves that fit into the box
        for (std::size_t k = 0; k < D; ++k)
            phase[k] =
                2 * std::numbers::pi * (at[place_of(k)] - static_cast<double>(shift_)) / static_cast<double>(extent[k]);
        for (std::size_t k = 0; k < D; ++k) velocity[k] = 0.04 * std::sin(phase[(k + 1) % D] + static_cast<double>(k));
        return {.velocity = pointing(velocity), .pressure = 1e-3 * std::cos(phase[0] + phase[1]), .gradient = {}};
    }
    void move(lbm::Solver<D>& solver, int step) const
    {
        std::vector<double> position, velocity, spin, radius;
        for (int i = 0; i < 2; ++i) {
            std::array<double, 3> const v = {0.02 - 0.03 * i, 0.01, -0.02 * i};
            std::array<double, 3> place = {5.3 + 18 * i, 11.2 - 3 * i, 5.1 + i};
            for (std::size_t k = 0; k < D; ++k) place[k] += step * v[k];
            auto const at = placed(place), moves = pointing(v);
            position.insert(position.end(), at.begin(), at.end());
            velocity.insert(velocity.end(), moves.begin(), moves.end());
            // swapped axes turn the other way round
            if (D == 2) spin.push_back((turn_ ? -1 : 1) * 0.003);
            if (D == 3)
                for (double const w : pointing({0.002, -0.001, 0.003})) spin.push_back(w);
            radius.push_back(3.3 - 0.4 * i);
        }
        solver.set_bodies({position, velocity, spin, radius});
        solver.step();
    }

    std::ptrdiff_t shift_;
    std::size_t turn_;
    lbm::Fields fields_;
};

template <int D>
void check_same(std::ptrdiff_t shift, bool turned)
{
    for (double const smagorinsky : {0.0, 0.1})
        for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32}) {
            Scene<D> const one(smagorinsky, precision, 0, false), other(smagorinsky, precision, shift, turned);
            double worst = 0, largest = 0;
            auto const [nx, ny, nz] = Scene<D>::extent;
            for (std::ptrdiff_t n = 0; n < nx * ny * nz; ++n) {
                std::array<std::ptrdiff_t, 3> const cell = {n % nx, n / nx % ny, n / nx / ny};
                auto const a = one.at(cell), b = other.at(cell);
                for (std::size_t k = 0; k <= D; ++k) {
                    worst = std::max(worst, std::abs(a[k] - b[k]));
                    largest = std::max(largest, std::abs(a[k]));
                }
            }
            CAPTURE(shift);
            CHECK(largest > 0.03);
            // populations in floats are rounded by 2^-24 of themselves, twice a step; in doubles bodies' places by
            // 2^-48
            CHECK(worst < Scene<D>::steps * (precision == lbm::Precision::float64 ? 0x1p-52 : largest * 0x1p-23));
        }
}

}  // namespace

TEST_CASE("central: a cell with solids, in each precision, with eddies and in a frame that turns, by the definition")
{
    check_definition<2, double>();
    check_definition<2, float>();
    check_definition<3, double>();
    check_definition<3, float>();
}

TEST_CASE("central: a flow past solids that is shifted by cells is the same, wherever registers begin")
{
    for (std::ptrdiff_t const shift : {1, 5}) {
        check_same<2>(shift, false);
        check_same<3>(shift, false);
    }
}

TEST_CASE("central: a flow past solids is the same whichever way axes lie")
{
    check_same<2>(0, true);
    check_same<3>(0, true);
}
