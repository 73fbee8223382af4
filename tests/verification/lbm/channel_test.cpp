#include <doctest/doctest.h>

#include <complex>
#include <numbers>
#include <string>

#include "tests/verification/lbm/lattice_case.hpp"

using namespace lattice_case;

namespace {

template <class... Value>
std::string text(char const* pattern, Value... value)
{
    char out[80];
    std::snprintf(out, sizeof out, pattern, value...);
    return out;
}

struct PoiseuilleError
{
    double discrete;  //!< max |u - exact solution of the scheme| / u_max
    double parabola;  //!< L2 against the parabola / u_max
};

//! Plane Poiseuille flow between half-way walls. Starts from the exact solution of the scheme, the fast way to the
//! steady state: what the solver does differently grows as 1 - exp(-pi^2 nu t/H^2), to at least 0.99 of its size here.
PoiseuilleError poiseuille(std::ptrdiff_t n, double tau, lbm::Operator collision, std::optional<double> flux_rate,
                           double u_max = 0.01, lbm::Precision precision = lbm::Precision::float64)
{
    lbm::Config c = config(3, n, tau);
    c.precision = precision;
    make_periodic(c, true, false);
    c.collision = collision;
    c.flux_rate = flux_rate;
    if (flux_rate) c.energy_rate = c.square_rate = 1 / tau;  // the table's operator: one rate for all even moments
    double const h = static_cast<double>(n), nu = c.viscosity, g = 8 * nu * u_max / (h * h);
    c.acceleration = {g, 0};
    double const tau_q = collision == lbm::Operator::bgk ? tau
                         : flux_rate                     ? 1 / *flux_rate
                                                         : 0.5 + 3.0 / 16 / (tau - 0.5);
    double const offset = g / (2 * nu) * (4 * (tau - 0.5) * (tau_q - 0.5) / 3 - 0.25);
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        double const y = at[1];
        return lbm::PointState<2>{.velocity = {g / (2 * nu) * y * (h - y) + offset, 0},
                                  .pressure = 0,
                                  .gradient = {{{0, g / (2 * nu) * (h - 2 * y)}, {0, 0}}}};
    });
    auto const steps = static_cast<int>(std::min(2 * h * h / nu, 400000.0));
    for (int k = 0; k < steps; ++k) solver.step();
    lbm::Fields const f = solver.fields();
    PoiseuilleError error{0, 0};
    for (std::ptrdiff_t j = 0; j < n; ++j) {
        double const y = static_cast<double>(j) + 0.5, parabola = g / (2 * nu) * y * (h - y);
        double const u = f.velocity[static_cast<std::size_t>(2 * 3 * j)];
        error.discrete = std::max(error.discrete, std::abs(u - parabola - offset) / u_max);
        error.parabola += (u - parabola) * (u - parabola) / h;
    }
    error.parabola = std::sqrt(error.parabola) / u_max;
    return error;
}

}  // namespace

TEST_CASE("L01: plane Poiseuille, exact discrete profile u_j = g/(2 nu) (y (H - y) + 4 Lambda/3 - 1/4)")
{
    using enum lbm::Operator;
    struct Row
    {
        char const* name;
        double tau;
        lbm::Operator collision;
        std::optional<double> flux_rate;
        double u_max = 0.01;
    };
    // MRT with its own rates of the even moments has density changes of order Ma^2 across the channel: shown at u =
    // 1e-4 mark: 1e-8 in double precision
    for (Row const& row :
         {Row{"bgk", 0.504, bgk, {}}, Row{"bgk", 0.6, bgk, {}}, Row{"bgk", 0.8, bgk, {}},
          Row{"bgk", 0.9330127019, bgk, {}}, Row{"bgk", 1, bgk, {}}, Row{"bgk", 2, bgk, {}},
          Row{"mrt s_q=1.5", 0.504, mrt, 1.5}, Row{"mrt 3/16", 0.8, mrt, {}, 1e-4},
          Row{"mrt 3/16", 0.506, mrt, {}, 1e-4}, Row{"trt 3/16", 0.8, trt, {}}, Row{"trt 3/16", 0.506, trt, {}}}) {
        for (std::ptrdiff_t const n : {8, 16, 32}) {
            verification::Stopwatch const watch;
            PoiseuilleError const error = poiseuille(n, row.tau, row.collision, row.flux_rate, row.u_max);
            CHECK(verification::report({"L01", text("%s tau=%g N=%td, max|du|/umax", row.name, row.tau, n),
                                        error.discrete, 0, error.discrete, 1e-8, watch.seconds()}));
        }
    }
}

TEST_CASE("L01: the same in single precision, at three speeds")
{
    using enum lbm::Operator;
    for (auto const& [name, collision] : {std::pair{"bgk", bgk}, {"trt", trt}})
        for (double const u_max : {0.1, 0.01, 0.0001}) {
            verification::Stopwatch const watch;
            double const n = 32, tau = 0.8;
            double const error = poiseuille(32, tau, collision, {}, u_max, lbm::Precision::float32).discrete;
            // mark: stored populations are off by 2^-24 of f - w, hence momentum by 2^-24 u_max a step; in a steady
            // flow that may be the same each step, a force. The driving one is 8 nu u_max/H^2
            double const mark = std::ldexp(n * n / (8 * (tau - 0.5) / 3), -24);
            CHECK(verification::report({"L01", text("single, %s u_max=%g, max|du|/umax", name, u_max), error, 0, error,
                                        mark, watch.seconds()}));
        }
}

TEST_CASE("L01: without the offset the profile converges to the parabola with order 2")
{
    verification::Stopwatch const watch;
    double const coarse = poiseuille(16, 0.8, lbm::Operator::bgk, {}).parabola,
                 fine = poiseuille(64, 0.8, lbm::Operator::bgk, {}).parabola;
    double const slope = std::log(fine / coarse) / std::log(4.0);
    CHECK(verification::report({"L01", "slope of L2 against the parabola, bgk N=16, 64", slope, -2, std::abs(slope + 2),
                                0.02, watch.seconds()}));
}

TEST_CASE("L02b: channel flow that is driven to and fro, Wo = h sqrt(w/nu) = 3 and 8, h = 16 cells")
{
    using Complex = std::complex<double>;
    std::ptrdiff_t const n = 32;
    double const h = 16;
    // marks of the file
    for (auto const& [wo, mark] : {std::pair{3.0, 0.02}, std::pair{8.0, 0.03}}) {
        verification::Stopwatch const watch;
        lbm::Config c = config(3, n, 0.6);
        make_periodic(c, true, false);
        double const w = wo * wo * c.viscosity / (h * h), g = 0.02 * w;
        c.oscillation = lbm::Oscillation{.amplitude = {g, 0, 0}, .frequency = w / (2 * std::numbers::pi)};
        lbm::Solver<2> solver(c);
        auto const period = static_cast<int>(std::lround(2 * std::numbers::pi / w));
        while (solver.steps() < 10 * period) solver.step();
        Complex const root = std::sqrt(Complex(0, 1)) * wo;
        double worst = 0;
        for (int k = 0; k < period; ++k) {
            solver.step();
            if (k % (period / 20) != 0) continue;
            lbm::Fields const f = solver.fields();
            Complex const turn = std::exp(Complex(0, w * solver.time()));
            for (std::ptrdiff_t j = 0; j < n; ++j) {
                double const y = (static_cast<double>(j) + 0.5 - h) / h;
                // closed form (the file): u = Re[(g/w) (1 - cosh(sqrt(i) Wo y)/cosh(sqrt(i) Wo))/i e^(i w t)]
                double const exact = ((1.0 - std::cosh(root * y) / std::cosh(root)) / Complex(0, 1) * turn).real();
                worst = std::max(worst, std::abs(f.velocity[static_cast<std::size_t>(2 * 3 * j)] / (g / w) - exact));
            }
        }
        CHECK(verification::report(
            {"L02b", text("max|du|/(g/w) at Wo=%g, tau=%g", wo, 0.6), worst, 0, worst, mark, watch.seconds()}));
    }
}

TEST_CASE("L02: start-up Couette flow")
{
    // TRT: the steady profile is exact. MRT's own rates change density by Ma^2 in shear: 1.6e-6 of U at U = 0.05, H =
    // 32
    constexpr double u_wall = 0.05;
    for (std::ptrdiff_t const n : {32, 64}) {
        verification::Stopwatch const watch;
        lbm::Config c = config(3, n, 0.8);
        make_periodic(c, true, false);
        c.walls[lbm::top<2>].velocity[0] = u_wall;
        c.collision = lbm::Operator::trt;
        lbm::Solver<2> solver(c);
        double const h = static_cast<double>(n);
        for (double const t : {0.02, 0.05, 0.1, 0.2, 0.5}) {
            auto const until = std::lround(t * h * h / c.viscosity);
            while (solver.steps() < until) solver.step();
            lbm::Fields const f = solver.fields();
            double sum = 0;
            for (std::ptrdiff_t j = 0; j < n; ++j) {
                double const y = (static_cast<double>(j) + 0.5) / h,
                             time = static_cast<double>(until) * c.viscosity / (h * h);
                double exact = y;  // closed form, Fourier series
                for (int k = 1; k < 60; ++k)
                    exact += 2 / std::numbers::pi * (k % 2 ? -1 : 1) / k *
                             std::exp(-k * k * std::numbers::pi * std::numbers::pi * time) *
                             std::sin(k * std::numbers::pi * y);
                double const error = f.velocity[static_cast<std::size_t>(2 * 3 * j)] / u_wall - exact;
                sum += error * error / h;
            }
            double const error = std::sqrt(sum);
            CHECK(verification::report(
                {"L02", text("L2(u)/U at nu t/H^2=%.2f, H=%td", t, n), error, 0, error, 1e-3, watch.seconds()}));
        }
        while (solver.steps() < std::lround(4 * h * h / c.viscosity)) solver.step();
        lbm::Fields const f = solver.fields();
        double worst = 0;
        for (std::ptrdiff_t j = 0; j < n; ++j)
            worst = std::max(worst, std::abs(f.velocity[static_cast<std::size_t>(2 * 3 * j)] / u_wall -
                                             (static_cast<double>(j) + 0.5) / h));
        CHECK(verification::report(
            {"L02", text("steady profile, max|du|/U, H=%td", n), worst, 0, worst, 1e-12, watch.seconds()}));
    }
}

namespace {

double velocity_error(lbm::Solver<2>& solver, double k, double u0)
{
    double const decay = std::exp(-2 * solver.config().viscosity * k * k * solver.time());
    lbm::Fields const f = solver.fields();
    double error = 0, norm = 0;
    for (std::ptrdiff_t j = 0; j < f.ny; ++j) {
        for (std::ptrdiff_t i = 0; i < f.nx; ++i) {
            double const x = k * (static_cast<double>(i) + 0.5), y = k * (static_cast<double>(j) + 0.5);
            double const u = -u0 * std::cos(x) * std::sin(y) * decay, v = u0 * std::sin(x) * std::cos(y) * decay;
            auto const at = static_cast<std::size_t>(2 * (j * f.nx + i));
            error += std::pow(f.velocity[at] - u, 2) + std::pow(f.velocity[at + 1] - v, 2);
            norm += u * u + v * v;
        }
    }
    return std::sqrt(error / norm);
}

constexpr std::pair<char const*, lbm::Operator> operators[] = {{"bgk", lbm::Operator::bgk},
                                                               {"trt", lbm::Operator::trt},
                                                               {"mrt", lbm::Operator::mrt},
                                                               {"central", lbm::Operator::central}};

//! Relative L2 error of the velocity of Taylor-Green vortices at 2 nu k^2 t = 1.
double taylor_green(std::ptrdiff_t n, lbm::Operator collision, lbm::Precision precision = lbm::Precision::float64)
{
    double const tau = 0.8, k = 2 * std::numbers::pi / static_cast<double>(n), u0 = 0.05 * 16 / static_cast<double>(n);
    lbm::Config c = config(n, n, tau);
    make_periodic(c, true, true);
    c.collision = collision;
    c.precision = precision;
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        auto const [x, y] = at;
        double const cx = std::cos(k * x), sx = std::sin(k * x), cy = std::cos(k * y), sy = std::sin(k * y);
        return lbm::PointState<2>{
            .velocity = {-u0 * cx * sy, u0 * sx * cy},
            .pressure = -0.25 * u0 * u0 * (std::cos(2 * k * x) + std::cos(2 * k * y)),
            .gradient = {{{u0 * k * sx * sy, -u0 * k * cx * cy}, {u0 * k * cx * cy, -u0 * k * sx * sy}}}};
    });
    while (static_cast<double>(solver.steps()) < 1 / (2 * c.viscosity * k * k)) solver.step();
    return velocity_error(solver, k, u0);
}

}  // namespace

TEST_CASE("L03: Taylor-Green vortices, diffusive scaling, tau = 0.8")
{
    for (auto const& [name, collision] : operators) {
        verification::Stopwatch const watch;
        double error[3];
        std::ptrdiff_t const size[] = {32, 64, 128};
        for (int k = 0; k < 3; ++k) error[k] = taylor_green(size[k], collision);
        CHECK(verification::report(
            {"L03", text("%s, L2(u) at N=32", name), error[0], 0, error[0], 3e-3, watch.seconds()}));
        // each factor of 2 for bgk, the operator of the reference run; for the others
        // over a factor of 4: the start leaves sound of order Ma^2 ~ dx^2 whose phase differs from lattice to lattice,
        // so that the two factors of 2 alone read 1.89 and 2.28 (TRT)
        double const order = 0.5 * std::log2(error[0] / error[2]);
        CHECK(verification::report({"L03", text("%s, order from N=32 to 128 (must reach 1.9)", name), order, 2,
                                    std::max(0.0, 2 - order), 0.1, watch.seconds()}));
        for (int k = 0; k < 2 && collision == lbm::Operator::bgk; ++k) {
            double const doubling = std::log2(error[k] / error[k + 1]);
            CHECK(verification::report({"L03", text("bgk, order from N=%d (must reach 1.9)", 32 << k), doubling, 2,
                                        std::max(0.0, 2 - doubling), 0.1, watch.seconds()}));
        }
    }
}

TEST_CASE("L03: the same in single precision, 32 and 128 cells")
{
    for (auto const& [name, collision] : operators) {
        verification::Stopwatch const watch;
        double const coarse = taylor_green(32, collision, lbm::Precision::float32),
                     fine = taylor_green(128, collision, lbm::Precision::float32);
        CHECK(verification::report(
            {"L03", text("%s, single, L2(u) at N=32", name), coarse, 0, coarse, 3e-3, watch.seconds()}));
        double const order = 0.5 * std::log2(coarse / fine);
        CHECK(verification::report({"L03", text("%s, single, order from N=32 to 128 (must reach 1.9)", name), order, 2,
                                    std::max(0.0, 2 - order), 0.1, watch.seconds()}));
    }
}
