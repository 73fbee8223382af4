#include "participants/lbm/phase.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "coupler/base/error.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

//! In lattice units, the solid 2.65 times as dense as the fluid.
template <int D>
lbm::Config with_phase(bool periodic, lbm::Drag law = lbm::Drag::di_felice)
{
    lbm::Config c;
    c.dimension = D;
    c.cell = c.step = c.density = 1;
    c.size = {20, 14, D == 2 ? 0.0 : 12.0};
    c.viscosity = 0.1;
    c.collision = lbm::Operator::trt;
    for (std::size_t k = 0; k < D; ++k) c.set_periodic(k, periodic);
    c.phase = lbm::PhaseConfig{.law = law, .diameter = 0.3, .solid_density = 2.65, .spread = 2};
    return c;
}

//! Points that move freely.
template <int D>
struct Cloud
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, volume;

    explicit Cloud(lbm::Config const& c, std::size_t points = 200)
    {
        std::mt19937 random(3);
        std::uniform_real_distribution<double> uniform(0, 1);
        for (std::size_t i = 0; i < points; ++i) {
            id.push_back(static_cast<std::int64_t>(7 * i + 1));
            for (std::size_t k = 0; k < D; ++k) {
                position.push_back(c.size[k] * uniform(random));
                velocity.push_back(0.02 * (uniform(random) - 0.5));
            }
            volume.push_back(0.5 * uniform(random));
        }
    }
    lbm::PhaseView view() const { return {id, position, velocity, volume}; }
    //! By its force; a continuum's mass less the fluid's, 2.65 - 1.
    void move(std::span<double const> force, double inertia = 1.65)
    {
        for (std::size_t i = 0; i < position.size(); ++i) {
            velocity[i] += force[i] / (inertia * volume[i / D]);
            position[i] += velocity[i];
        }
    }
};

template <int D>
std::array<double, D> sum(std::span<double const> vectors)
{
    std::array<double, D> total{};
    for (std::size_t i = 0; i < vectors.size(); ++i) total[i % D] += vectors[i];
    return total;
}

std::string message(auto&& run)
{
    try {
        run();
    } catch (sluice::Error const& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("drag_law: Ergun, Carman-Kozeny and Di Felice by hand")
{
    // phi = 0.6: n^3 = 0.064, phi^2 = 0.36; nu = 0.1, d = 0.5
    lbm::DragLaw const ergun{lbm::Drag::ergun, 0.5, 0.1}, carman{lbm::Drag::carman_kozeny, 0.5, 0.1};
    CHECK(ergun.resistance(0.6, 0.02) ==
          close_to(150 * 0.1 * 0.36 / (0.064 * 0.25) + 1.75 * 0.6 * 0.02 / (0.064 * 0.5)));
    CHECK(carman.resistance(0.6, 0.02) == close_to(180 * 0.1 * 0.36 / (0.064 * 0.25)));
    // Re = 0.02 * 0.5/0.1 = 0.1: C_d = (0.63 + 4.8/sqrt(0.1))^2, chi = 3.7 - 0.65 exp(-(1.5 + 1)^2/2)
    lbm::DragLaw const felice{lbm::Drag::di_felice, 0.5, 0.1};
    double const drag = std::pow(0.63 + 4.8 / std::sqrt(0.1), 2), chi = 3.7 - 0.65 * std::exp(-3.125);
    CHECK(felice.resistance(0.2, 0.02) == close_to(0.75 * drag * 0.2 * 0.02 * std::pow(0.8, -1 - chi) / 0.5));
}

TEST_CASE("drag_law: a single grain in slow flow has the drag of Stokes, to what Di Felice's 4.8 makes of 24")
{
    lbm::DragLaw const felice{lbm::Drag::di_felice, 0.5, 0.1};
    double const phi = 1e-6, stokes = 18 * 0.1 * phi / 0.25;  // 3 pi mu d over the volume of a grain
    CHECK(felice.resistance(phi, 1e-9) == close_to(stokes * 4.8 * 4.8 / 24).epsilon(1e-3));
}

TEST_CASE("drag_law: the flux that is left of a drive satisfies the law, for beds and dust, slow and fast flow")
{
    for (auto const kind : {lbm::Drag::ergun, lbm::Drag::carman_kozeny, lbm::Drag::di_felice})
        for (double const diameter : {1e-4, 0.1, 10.0})
            for (double const solid : {1e-6, 0.1, 0.6, 1.2})
                for (double const drive : {1e-9, 1e-3, 1.0}) {
                    lbm::DragLaw const law{kind, diameter, 0.01};
                    double const half = 0.5 + 1 / (1.65 * solid), r = law.resistance_after(solid, drive, half);
                    CHECK(law.resistance(solid, drive / (1 + half * r)) == close_to(r).epsilon(1e-7));
                }
}

TEST_CASE_TEMPLATE("phase: what the fluid loses the points get, in a box with periods, to rounding", Plane,
                   std::integral_constant<int, 2>, std::integral_constant<int, 3>)
{
    constexpr int D = Plane::value;
    auto c = with_phase<D>(true);
    SUBCASE("points of a continuum") {}
    SUBCASE("grains")
    {
        c.phase->matter = false;
    }
    SUBCASE("in central moments")
    {
        c.collision = lbm::Operator::central;
    }
    lbm::Solver<D> solver(c);
    solver.set_state([](std::array<double, D> const& at) {
        return lbm::PointState<D>{.velocity = {0.02 * std::sin(at[1]), 0.01}, .pressure = 0, .gradient = {}};
    });
    Cloud<D> cloud(c);
    for (int k = 0; k < 20; ++k) {
        auto const before = solver.momentum();
        solver.set_phase(cloud.view(), 1);
        solver.step();
        auto const after = solver.momentum(), got = sum<D>(solver.phase_force());
        double size = 0;
        for (double const force : solver.phase_force()) size += std::abs(force);
        CHECK(size > 1e-3);
        for (std::size_t i = 0; i < D; ++i) CHECK(std::abs(after[i] - before[i] + got[i]) < 1e-11 * (1 + size));
        cloud.move(solver.phase_force(), c.phase->matter ? 1.65 : 2.65);
    }
}

TEST_CASE("phase: points of a continuum in one place move alike, grains by their own velocity")
{
    auto c = with_phase<2>(true);
    for (bool const matter : {true, false}) {
        c.phase->matter = matter;
        lbm::Solver<2> solver(c);
        std::vector<std::int64_t> const id = {0, 1};
        std::vector<double> const position = {5, 5, 5, 5}, velocity = {0.01, 0, -0.01, 0}, volume = {0.3, 0.3};
        solver.set_phase({id, position, velocity, volume}, 1);
        solver.step();
        auto const force = solver.phase_force();
        if (matter)
            CHECK(std::abs(force[0] - force[2]) < 1e-17);  // their mean is that of the fluid
        else
            CHECK(force[0] - force[2] < -1e-4);
        CHECK(std::abs(force[0] + force[2]) < 1e-15);
    }
}

TEST_CASE("phase: a point is spread whole, beside walls too, and what is far outside hinders nothing")
{
    auto const c = with_phase<2>(false);
    lbm::Solver<2> solver(c);
    std::vector<std::int64_t> const id = {0, 1, 2, 3};
    std::vector<double> const position = {0.1, 0.1, 19.99, 7.3, 10.2, -0.4, 10, -3}, velocity(8, 0.01),
                              volume = {0.2, 0.3, 0.4, 0.5};
    solver.set_phase({id, position, velocity, volume}, 1);
    auto const fraction = solver.fields().solid_fraction;
    CHECK(std::accumulate(fraction.begin(), fraction.end(), 0.0) == close_to(0.9));
    solver.step();
    auto const force = solver.phase_force();
    for (std::size_t i = 0; i < 3; ++i) CHECK(force[2 * i] < 0);
    CHECK(force[6] == 0);
    CHECK(force[7] == 0);
}

TEST_CASE("phase: a point beside a domain that is as narrow as its spread is mirrored into it")
{
    auto c = with_phase<2>(false);
    c.size = {2, 14, 0};
    lbm::Solver<2> solver(c);
    std::vector<std::int64_t> const id = {0, 1};
    std::vector<double> const position = {2.9, 4, -0.9, 4}, velocity(4, 0.0), volume = {0.2, 0.2};
    solver.set_phase({id, position, velocity, volume}, 1);
    auto const fraction = solver.fields().solid_fraction;
    CHECK(std::accumulate(fraction.begin(), fraction.end(), 0.0) == close_to(0.4));
    for (std::size_t cell = 0; cell < fraction.size(); cell += 2)
        CHECK(std::abs(fraction[cell] - fraction[cell + 1]) < 1e-15);
}

TEST_CASE("phase: fluid and bed that move together feel nothing of each other")
{
    auto c = with_phase<2>(true, lbm::Drag::ergun);
    SUBCASE("points of a continuum") {}
    SUBCASE("grains")
    {
        c.phase->matter = false;
    }
    lbm::Solver<2> solver(c);
    std::array<double, 2> const drift = {0.03, -0.02};
    solver.set_state([&](std::array<double, 2> const&) {
        return lbm::PointState<2>{.velocity = drift, .pressure = 0, .gradient = {}};
    });
    Cloud<2> cloud(c);
    for (std::size_t i = 0; i < cloud.velocity.size(); ++i) cloud.velocity[i] = drift[i % 2];
    for (int k = 0; k < 100; ++k) {
        solver.set_phase(cloud.view(), 1);
        solver.step();
        cloud.move(solver.phase_force(), c.phase->matter ? 1.65 : 2.65);
    }
    for (std::size_t i = 0; i < cloud.velocity.size(); ++i) CHECK(std::abs(cloud.velocity[i] - drift[i % 2]) < 1e-13);
    auto const f = solver.fields();
    for (std::size_t i = 0; i < f.velocity.size(); ++i) CHECK(std::abs(f.velocity[i] - drift[i % 2]) < 1e-13);
}

TEST_CASE("phase: a resumed run goes on bit for bit, whatever the threads, and shows the same fields")
{
    auto c = with_phase<2>(false);
    lbm::Solver<2> first(c);
    Cloud<2> cloud(c);
    auto const go = [](lbm::Solver<2>& solver, Cloud<2>& points, int windows) {
        for (int k = 0; k < windows; ++k) {
            solver.set_phase(points.view(), 2);
            solver.step();
            solver.step();
            points.move(solver.phase_force());
        }
    };
    go(first, cloud, 5);
    sluice::State kept;
    first.keep(kept);
    c.threads = 3;
    lbm::Solver<2> second(c);
    second.restore(kept);
    Cloud<2> other = cloud;
    CHECK(first.fields().velocity == second.fields().velocity);
    CHECK(first.fields().solid_fraction == second.fields().solid_fraction);
    go(first, cloud, 5);
    go(second, other, 5);
    CHECK(cloud.velocity == other.velocity);
    CHECK(first.fields().velocity == second.fields().velocity);
    CHECK(first.fields().pressure == second.fields().pressure);
}

TEST_CASE("phase: points may come, go and change order, forces follow their ids")
{
    auto const c = with_phase<2>(false);
    lbm::Solver<2> plain(c), turned(c);
    Cloud<2> cloud(c, 3);
    for (int k = 0; k < 10; ++k) {
        plain.set_phase(cloud.view(), 1);
        plain.step();
        auto const &x = cloud.position, &v = cloud.velocity;
        std::vector<std::int64_t> const id = {cloud.id[2], cloud.id[0], cloud.id[1]};
        std::vector<double> const position = {x[4], x[5], x[0], x[1], x[2], x[3]},
                                  velocity = {v[4], v[5], v[0], v[1], v[2], v[3]},
                                  volume = {cloud.volume[2], cloud.volume[0], cloud.volume[1]};
        k % 2 == 0 ? turned.set_phase(cloud.view(), 1) : turned.set_phase({id, position, velocity, volume}, 1);
        turned.step();
        auto const f = plain.phase_force(), g = turned.phase_force();
        for (std::size_t i = 0; i < 6; ++i) CHECK(g[i] == close_to(f[k % 2 == 0 ? i : (i + 4) % 6]).epsilon(1e-9));
        cloud.move(plain.phase_force());
    }
}

//! Of a box that reaches beyond a corner of cells by rounding, 3.6e-15 along each axis, as 0.3/0.01 does.
TEST_CASE("phase: a trace of a solid leaves points their force, in single precision too")
{
    constexpr int steps = 5;
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32}) {
        auto c = with_phase<3>(true);
        c.precision = precision;
        c.acceleration = {1e-5, 0, 0};
        Cloud<3> const cloud(c);
        lbm::Patch<3> const trace{.first = {10, 7, 6}, .size = {1, 1, 1}, .fraction = {4e-44}, .drag = lbm::flat_drag};
        lbm::Solver<3> without(c), with(c, {trace});
        for (auto* solver : {&without, &with}) {
            solver->set_phase(cloud.view(), steps);
            for (int k = 0; k < steps; ++k) solver->step();
        }
        auto const expected = without.phase_force(), force = with.phase_force();
        double const largest = std::ranges::max(expected);  // the fluid's velocity is as large, rounded by 2^-24
        for (std::size_t k = 0; k < force.size(); ++k) CHECK(std::abs(force[k] - expected[k]) < 1e-5 * largest);
    }
}

TEST_CASE("phase: points that are not finite or have no volume are named")
{
    auto const c = with_phase<2>(false);
    lbm::Solver<2> solver(c);
    Cloud<2> cloud(c, 3);
    cloud.volume[1] = 0;
    CHECK(contains(message([&] { solver.set_phase(cloud.view(), 1); }), "point 8"));
    cloud.volume[1] = 1;
    cloud.velocity[4] = std::nan("");
    CHECK(contains(message([&] { solver.set_phase(cloud.view(), 1); }), "point 15"));
}
