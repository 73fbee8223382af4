#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/verification/mpm/bars.hpp"

//! M09: the method of manufactured solutions in a unit square whose displacement is along the axes (Wallstedt and
//! Guilkey, J. Comput. Phys. 227 (2008) 9628; file M09_gimp_mms.csv):
//!
//!     u = A sin(pi X) sin(c pi t),   v = A sin(pi Y) sin(c pi t + pi),   c = sqrt(E / rho)
//!
//! with the body force that makes it a solution of each law, at a point's first place X, Y. Large deformation, points
//! cross cells. Places, and with them F and stress, run half a step ahead of velocities, so a run starts.
using namespace verification;

namespace {

constexpr double A = 0.05, modulus = 1e7, density = 1000, pi = std::numbers::pi;
double const c = std::sqrt(modulus / density);
mpm::Elasticity const elastic{modulus, 0.3};

double phase(int axis, double t)
{
    return c * pi * t + axis * pi;
}
double displacement(double X, int axis, double t)
{
    return A * std::sin(pi * X) * std::sin(phase(axis, t));
}
double stretch(double X, int axis, double t)
{
    return 1 + A * pi * std::cos(pi * X) * std::sin(phase(axis, t));
}

//! Force per mass [m/s2].
mpm::Vec<2> body_force(mpm::Law const& law, mpm::Vec<2> const& X, double t)
{
    mpm::Vec<2> out;
    double const lame = elastic.lame(), shear = elastic.shear();
    double const J = stretch(X[0], 0, t) * stretch(X[1], 1, t);
    for (int k : {0, 1}) {
        double const u = displacement(X[k], k, t), own = stretch(X[k], k, t), other = stretch(X[1 - k], 1 - k, t);
        if (std::holds_alternative<mpm::NeoHookean>(law))
            out[k] = pi * pi * u / density *
                     (lame * (1 - std::log(J)) / (own * own) + shear * (1 + 1 / (own * own)) - modulus);
        else  // stress = C : ln(stretch)
            out[k] = -std::pow(c * pi, 2) * u + pi * pi * u / density * elastic.wave() * other / own;
    }
    return out;
}

mpm::Law true_strain()
{
    return mpm::LinearElastic{elastic};
}

//! Root of the mean square of what lies between places and the solution, by A; over points and one period, gimp.
double rms_deviation(mpm::Law const& law, int cells, mpm::Scheme scheme, bool affine, mpm::Width width)
{
    mpm::Config config;
    config.cell = 1.0 / cells;
    config.size = {1, 1, 0};
    config.flip = 1;
    config.density = density;
    config.law = law;
    config.scheme = scheme;
    config.affine = affine;
    config.width = width;
    config.bodies.push_back({.low = {0, 0, 0}, .high = {1, 1, 0}});
    for (int axis : {0, 1})
        for (int side : {-1, 1}) config.walls.push_back({.axis = axis, .side = side, .place = side < 0 ? 0.0 : 1.0});
    auto const setup = mpm::make_setup<2>(config);
    auto state = mpm::make_state<2>(config);
    double const period = 2 / c, fastest = std::sqrt(elastic.wave() / density) + A * c * pi;
    double const dt = period / std::ceil(period / (0.2 * config.cell / fastest));
    std::vector<mpm::Vec<2>> first, loads(state.points.size());
    for (auto& p : state.points) {
        first.push_back(p.place);
        for (int k : {0, 1}) {
            double const X = first.back()[k];
            p.velocity[k] = A * c * pi * std::sin(pi * X) * std::cos(phase(k, 0));
            p.slope(k, k) = A * c * pi * pi * std::cos(pi * X) * std::cos(phase(k, 0)) / stretch(X, k, 0.5 * dt);
            p.place[k] += displacement(X, k, 0.5 * dt);
            p.matter.gradient(k, k) = stretch(X, k, 0.5 * dt);
        }
        auto& m = p.matter;
        m.ratio = m.gradient.determinant();
        mpm::Mat3 const logarithm = m.gradient.diagonal().array().log().matrix().asDiagonal();
        m.stress = elastic.stress(logarithm);
        if (std::holds_alternative<mpm::NeoHookean>(law))
            std::get<mpm::NeoHookean>(law).respond(m, mpm::Increment(mpm::Mat3::Identity()));
    }
    mpm::Solver<2> solver(setup, state);
    double sum = 0, count = 0;
    while (solver.time() < period - 0.5 * dt) {
        double const t = solver.time() + 0.5 * dt;
        for (std::size_t p = 0; p < loads.size(); ++p) loads[p] = state.points[p].mass * body_force(law, first[p], t);
        solver.set_loads(loads);
        solver.step(dt);
        for (std::size_t p = 0; p < loads.size(); ++p) {
            mpm::Vec<2> off = solver.state().points[p].place - first[p];
            for (int k : {0, 1}) off[k] -= displacement(first[p][k], k, t + dt);
            sum += off.squaredNorm() / (A * A), ++count;
        }
    }
    return std::sqrt(sum / count);
}

}  // namespace

TEST_CASE("M09: the body forces are those of the file")
{
    struct Row
    {
        double X, Y, t, neo_x, neo_y, true_x, true_y;
    };
    for (Row const& r : {Row{0.1, 0.3, 0.004, 150.3758168, -1943.263163, 109.0418331, -2602.466227},
                         Row{0.25, 0.25, 0.004, 585.710095, -1973.936308, 295.1025844, -2204.078602},
                         Row{0.5, 0.8, 0.004, 1315.660876, -269.1795105, 2388.175596, -554.48769},
                         Row{0.9, 0.6, 0.004, 1125.070001, -1429.037541, 930.4067909, -463.8991651}}) {
        CHECK((body_force(mpm::NeoHookean{elastic}, {r.X, r.Y}, r.t) - mpm::Vec<2>(r.neo_x, r.neo_y)).norm() < 1e-5);
        CHECK((body_force(true_strain(), {r.X, r.Y}, r.t) - mpm::Vec<2>(r.true_x, r.true_y)).norm() < 1e-5);
    }
}

//! Marks of the file: RMS 0.02 A at 32 cells; of order 1.6 from 16 to 32. With points as wide as at the start it
//! is 1.2: pressed together they overlap, at the sides they reach the nodes behind.
TEST_CASE("M09: manufactured solution")
{
    struct Case
    {
        char const* name;
        mpm::Law law;
        mpm::Scheme scheme;
        bool affine;
    };
    mpm::Law const neo = mpm::NeoHookean{elastic};
    using enum mpm::Scheme;
    for (Case const& k : {Case{"neo-Hookean, musl", neo, musl, true}, Case{"rates, musl", true_strain(), musl, true},
                          Case{"rates, musl, not affine", true_strain(), musl, false}}) {
        Stopwatch const watch;
        auto const rms = [&](int cells, mpm::Width width) {
            return rms_deviation(k.law, cells, k.scheme, k.affine, width);
        };
        double const coarse = rms(16, mpm::Width::stretch), fine = rms(32, mpm::Width::stretch);
        double const fixed = rms(32, mpm::Width::fixed), order = std::log2(coarse / fine);
        std::string const name = k.name;
        CHECK(report({"M09", name + ", width: stretch: rms at 32 [A]", fine, 0, fine, 0.02, watch.seconds()}));
        CHECK(report({"M09", name + ", width: stretch: order (1.6 or more)", order, 2, std::max(0.0, 2 - order), 0.4,
                      watch.seconds()}));
        CHECK(report({"M09", name + ": rms at 32 [A]", fixed, 0, fixed, 0.02, watch.seconds()}));
    }
}

//! Mark of the file: 1.3.
TEST_CASE("M09: manufactured solution, 64 cells" * doctest::skip())
{
    Stopwatch const watch;
    auto const rms = [&](int cells) {
        return rms_deviation(true_strain(), cells, mpm::Scheme::musl, true, mpm::Width::stretch);
    };
    double const fine = rms(64), order = std::log2(rms(32) / fine);
    CHECK(report({"M09", "rates, musl, width: stretch: rms at 64 [A]", fine, 0, fine, 0.02, watch.seconds()}));
    CHECK(report({"M09", "rates, musl, width: stretch: order 32 to 64 (1.3 or more)", order, 2,
                  std::max(0.0, 2 - order), 0.7, watch.seconds()}));
}
