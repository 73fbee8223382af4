// A continuum whose pores a fluid fills, P04 to P06. P04: consolidation of a saturated column (Terzaghi): points of the
// continuum and the lattice's fluid, each by its own solver, coupled as the participants do it. One-dimensional, the
// fluid compressible (Verruijt, An Introduction to Soil Dynamics (2010), chap. 4): storage S = 1/(rho_0 c_s^2),
// stiffness E of the skeleton, c_v = (k/mu)/(S + 1/E), z the depth, H the height, q a load on top, or the column's
// weight in the fluid above its base:
//     u = 1/(1 + S E) sum_m a_m sin(M z/H) exp(-M^2 c_v t/H^2),  M = (2 m + 1) pi/2,  a_m = 2 q/M, or 2 q (-1)^m/M^2
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "participants/lbm/solver.hpp"
#include "participants/mpm/setup.hpp"
#include "tests/support/verification.hpp"

namespace {

enum class Load
{
    on_top,
    weight
};

// lattice units: cell = step = density = 1
constexpr double solid = 0.6, excess = 1.65;  // volume fraction; density over the fluid's, less 1
constexpr double stiffness = 0.011;           // of the skeleton, a thirtieth of the fluid's: rho_0 c_s^2 = 1/3
constexpr double storage = 3;                 // 1/(rho_0 c_s^2)
constexpr double resistance = 0.3;            // mu/k
constexpr double load = 2e-5;                 // strains of 0.2 %: the drag stays that of the start
constexpr double ramp = 1500;                 // steps within which it grows: five periods of the fast wave at 32 cells
double const consolidation = 1 / resistance / (storage + 1 / stiffness);

//! By load, of a column H high, t after it was loaded.
double excess_pressure(Load kind, double depth, double H, double t)
{
    double sum = 0;
    for (int m = 0; m < 200; ++m) {
        double const M = (m + 0.5) * std::numbers::pi,
                     a = kind == Load::on_top ? 2 / M : (m % 2 == 0 ? 2 : -2) / (M * M);
        sum += a * std::sin(M * depth / H) * std::exp(-M * M * consolidation * t / (H * H));
    }
    return sum / (1 + storage * stiffness);
}

//! How far a point at the height y has sunk.
double settlement(Load kind, double y, double H, double t)
{
    double sum = 0;
    int const parts = 400;
    for (int k = 0; k < parts; ++k) {
        double const depth = H - (k + 0.5) * y / parts, total = kind == Load::on_top ? 1 : depth / H;
        sum += load / stiffness * (total - excess_pressure(kind, depth, H, t)) * y / parts;
    }
    return sum;
}

//! What fluid and points tell each other in a window.
struct Pores
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, volume;
    std::vector<mpm::Vec<2>> loads;

    void flow(lbm::Solver<2>& fluid, mpm::Solver<2> const& soil, int steps)
    {
        id.clear(), position.clear(), velocity.clear(), volume.clear(), loads.clear();
        for (auto const& p : soil.state().points) {
            id.push_back(p.id);
            position.insert(position.end(), {p.place[0], p.place[1]});
            velocity.insert(velocity.end(), {p.velocity[0], p.velocity[1]});
            volume.push_back(solid * p.volume);
        }
        fluid.set_phase({id, position, velocity, volume}, steps);
        for (int k = 0; k < steps; ++k) fluid.step();
        auto const force = fluid.phase_force();
        for (std::size_t i = 0; i < id.size(); ++i) loads.emplace_back(force[2 * i], force[2 * i + 1]);
    }
};

struct Column
{
    Load kind;
    int height, window;  //!< steps of the fluid in a window, which is one step of the points
    lbm::Solver<2> fluid;
    mpm::Solver<2> soil;
    double top;  //!< place of the highest points at the start
    Pores pores;

    static lbm::Config fluid_config(int height, double drag)
    {
        lbm::Config c;
        c.cell = c.step = c.density = 1;
        c.size = {2, static_cast<double>(height + 4)};
        c.viscosity = 0.01;
        c.collision = lbm::Operator::trt;
        c.set_periodic(0);
        c.walls[lbm::upper_y] = {.kind = lbm::Border::pressure};
        double const cube = std::pow(1 - solid, 3);
        c.phase = lbm::PhaseConfig{.law = lbm::Drag::carman_kozeny,
                                   .diameter = std::sqrt(180 * c.viscosity * solid * solid / (cube * drag)),
                                   .solid_density = 1 + excess};
        return c;
    }
    static mpm::Config soil_config(int height)
    {
        mpm::Config c;
        c.size = {2, static_cast<double>(height + 4), 0};
        c.cell = 2;
        c.density = solid * excess;
        c.law = mpm::LinearElastic{{stiffness, 0}};
        c.bodies.push_back({.low = {0, 0, 0}, .high = {2, static_cast<double>(height), 0}});
        c.walls = {{.axis = 0, .side = -1}, {.axis = 0, .side = 1, .place = 2}, {.axis = 1, .side = -1}};
        return c;
    }

    Column(Load load_kind, int cells, int steps, double drag = resistance)
        : kind(load_kind),
          height(cells),
          window(steps),
          fluid(fluid_config(cells, drag)),
          soil(mpm::make_solver<2>(soil_config(cells))),
          top(soil.state().points.back().place[1])
    {}

    void step()
    {
        pores.flow(fluid, soil, window);
        double const done = std::min(1.0, soil.time() / ramp), share = 0.5 * (1 - std::cos(std::numbers::pi * done));
        if (kind == Load::on_top)  // two points across two cells
            for (std::size_t i = pores.loads.size() - 2; i < pores.loads.size(); ++i) pores.loads[i][1] -= share * load;
        if (kind == Load::weight) soil.set_gravity({0, -share * load / (solid * excess * height)});
        soil.set_loads(pores.loads);
        soil.step(window);
    }
};

//! Errors of the pore pressure over the column (root mean square, largest of four times) and of the settlement, by the
//! load and the settlement at the end.
struct Errors
{
    double pressure = 0, settlement = 0;
};

Errors errors_of(Load kind, int height, int window = 1)
{
    Column column(kind, height, window);
    double const H = height;
    Errors worst;
    for (double const T : {0.1, 0.2, 0.5, 1.0}) {
        double const t = T * H * H / consolidation;
        while (column.soil.time() < t + 0.5 * ramp) column.step();
        auto const pressure = column.fluid.fields().pressure;
        double square = 0;
        for (int k = 0; k < height; ++k) {
            double const exact = load * excess_pressure(kind, H - k - 0.5, H, t);
            square += std::pow((pressure[2 * static_cast<std::size_t>(k)] - exact) / load, 2) / height;
        }
        worst.pressure = std::max(worst.pressure, std::sqrt(square));
        double const sunk = column.top - column.soil.state().points.back().place[1];
        double const last = load / stiffness * H * (kind == Load::on_top ? 1 : 0.5);
        worst.settlement = std::max(worst.settlement, std::abs(sunk - settlement(kind, column.top, H, t)) / last);
    }
    return worst;
}

}  // namespace

// Mark: the drained surface is known to a cell or so, spread over two as it is: c_v t/H^2 and u to that by H. At 32
// cells that is 3 %; and it goes with the cell.
TEST_CASE("P04: consolidation of a saturated column, of its own weight and under a load: pore pressure, settlement")
{
    for (auto const kind : {Load::weight, Load::on_top}) {
        verification::Stopwatch watch;
        std::string const name = kind == Load::weight ? ", own weight, 32 cells" : ", load on top, 32 cells";
        Errors const coarse = errors_of(kind, 16), fine = errors_of(kind, 32);
        CHECK(verification::report(
            {"P04", "pore pressure by load" + name, fine.pressure, 0, fine.pressure, 1.0 / 32, watch.seconds()}));
        CHECK(verification::report(
            {"P04", "settlement" + name, fine.settlement, 0, fine.settlement, 1.0 / 32, watch.seconds()}));
        double const ratio = fine.pressure / coarse.pressure;
        CHECK(verification::report(
            {"P04", "pressure by that at 16 cells" + name, ratio, 0.5, ratio, 0.6, watch.seconds()}));
    }
    verification::Stopwatch watch;
    Errors const four = errors_of(Load::weight, 32, 4);
    CHECK(verification::report({"P04", "pore pressure by load, own weight, windows of four steps", four.pressure, 0,
                                four.pressure, 1.0 / 32, watch.seconds()}));
}

// P05: in the time of the fast wave nothing flows through a bed of 1e4 a step, and its fluid carries 1/(1 + S E) of the
// weight. Mark: the top, where a cell drains. The force on the points goes through two solvers and back; it must not
// feed their vibration.
TEST_CASE("P05: a column so tight that nothing flows: its fluid carries the weight, and stays quiet")
{
    for (int const window : {1, 4}) {
        verification::Stopwatch watch;
        Column column(Load::weight, 32, window, 1e4);
        while (column.soil.time() < 8 * ramp) column.step();
        auto const pressure = column.fluid.fields().pressure;
        double square = 0;
        for (int k = 0; k < 32; ++k) {
            double const exact = (32 - k - 0.5) / 32 / (1 + storage * stiffness);
            square += std::pow(pressure[2 * static_cast<std::size_t>(k)] / load - exact, 2) / 32;
        }
        std::string const name = window == 1 ? ", windows of a step" : ", windows of four steps";
        CHECK(verification::report({"P05", "pore pressure by load" + name, std::sqrt(square), 0, std::sqrt(square),
                                    1.0 / 32, watch.seconds()}));
    }
}

// P06: a block that flies through fluid at rest, in a box with periods: what one loses the other gets. And both moving
// alike: nothing happens.
TEST_CASE("P06: a block in a fluid: momentum of both, nothing where they move together")
{
    for (bool const together : {false, true}) {
        verification::Stopwatch watch;
        auto c = Column::fluid_config(36, resistance);
        c.size = {40, 40};
        c.walls = {};
        for (std::size_t k = 0; k < 2; ++k) c.set_periodic(k);
        c.viscosity = 0.1;
        lbm::Solver<2> fluid(c);
        double const speed = 0.02;
        if (together)
            fluid.set_state([&](std::array<double, 2> const&) {
                return lbm::PointState<2>{.velocity = {speed, -speed}, .pressure = 0, .gradient = {}};
            });
        auto s = Column::soil_config(36);
        s.size = {40, 40, 0};
        s.walls.clear();
        s.bodies = {{.low = {10, 16, 0}, .high = {18, 24, 0}, .velocity = {speed, -speed, 0}}};
        auto soil = mpm::make_solver<2>(s);
        Pores pores;
        auto const momentum = [&] {
            auto sum = fluid.momentum();
            for (auto const& p : soil.state().points)
                for (std::size_t k = 0; k < 2; ++k) sum[k] += p.mass * p.velocity[static_cast<int>(k)];
            return sum;
        };
        auto const before = momentum();
        for (int k = 0; k < 300; ++k) {
            pores.flow(fluid, soil, 1);
            soil.set_loads(pores.loads);
            soil.step(1);
        }
        auto const after = momentum();
        double const size = 64 * solid * excess * speed;
        double const lost = std::max(std::abs(after[0] - before[0]), std::abs(after[1] - before[1])) / size;
        CHECK(
            verification::report({"P06", together ? "momentum lost, moving together" : "momentum lost, by the block's",
                                  lost, 0, lost, 1e-11, watch.seconds()}));
        double change = 0;
        for (auto const& p : soil.state().points)
            change = std::max(change, (p.velocity - mpm::Vec<2>(speed, -speed)).norm() / speed);
        if (together)
            CHECK(
                verification::report({"P06", "change of velocity where both move alike", change, 0, change, 1e-10, 0}));
        else
            CHECK(change > 0.1);
    }
}
