#include "participants/lbm/solver.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/lbm/blow_up.hpp"
#include "tests/participants/lbm/unit_config.hpp"
#include "tests/support/close_to.hpp"
#include "tests/support/contains.hpp"

namespace {

lbm::Config small(std::ptrdiff_t nx = 40, std::ptrdiff_t ny = 30)
{
    lbm::Config c;
    c.cell = 1e-3;
    c.step = 1e-3;
    c.size = {static_cast<double>(nx) * c.cell, static_cast<double>(ny) * c.cell};
    c.viscosity = 1e-4;
    return c;
}

std::string message(auto&& run)
{
    try {
        run();
    } catch (sluice::Error const& e) {
        return std::to_string(static_cast<int>(e.exit())) + " " + e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("lattice_units: SI to lattice and back")
{
    lbm::LatticeUnits const u{.cell = 2e-3, .step = 1e-4, .density = 1000};
    CHECK(u.velocity_unit() == close_to(20));
    CHECK(u.acceleration_unit() == close_to(2e5));
    CHECK(u.relaxation_time(1e-6) == close_to(0.5 + 3e-6 * 1e-4 / 4e-6));
    CHECK(u.pressure(u.density_excess_lu(12.5)) == close_to(12.5));
    CHECK(u.force_unit() == close_to(u.mass_unit() * u.acceleration_unit()));
    CHECK(u.torque_unit() == close_to(u.force_unit() * u.cell));
}

TEST_CASE("solver: fields give back the state that was set, in SI, and coarsen by averages")
{
    lbm::Solver<2> solver(small());
    solver.set_state([](std::array<double, 2> const& at) {
        auto const [x, y] = at;
        return lbm::PointState<2>{.velocity = {0.02 * x / 0.04, -0.01 * y / 0.03}, .pressure = 0.5 * x, .gradient = {}};
    });
    lbm::Fields const f = solver.fields();
    CHECK(f.velocity[2 * (7 * 40 + 3)] == close_to(0.02 * 3.5 / 40));
    CHECK(f.velocity[2 * (7 * 40 + 3) + 1] == close_to(-0.01 * 7.5 / 30));
    CHECK(f.pressure[7 * 40 + 3] == close_to(0.5 * 3.5e-3));
    lbm::Fields const c = solver.fields(4);
    CHECK(c.nx == 10);
    CHECK(c.ny == 8);  // the last row of blocks holds two rows of cells
    CHECK(c.spacing == close_to(4e-3));
    CHECK(c.velocity[2 * 1] == close_to(0.02 * 6 / 40));
    CHECK(c.velocity[2 * (7 * 10) + 1] == close_to(-0.01 * 29 / 30));
    CHECK(solver.max_speed() == close_to(std::hypot(0.02 * 39.5 / 40, 0.01 * 29.5 / 30)));
}

TEST_CASE("solver: vorticity of a rigid rotation is twice its rate")
{
    lbm::Solver<2> solver(small());
    solver.set_state([](std::array<double, 2> const& at) {
        auto const [x, y] = at;
        return lbm::PointState<2>{.velocity = {-2 * y, 2 * x}, .pressure = 0, .gradient = {}};
    });
    for (double const w : solver.fields(3).vorticity) CHECK(w == close_to(4).epsilon(1e-6));
}

TEST_CASE("solver: fluid at rest and a resting disc stay at rest, exactly, without gravity")
{
    for (auto const precision : {lbm::Precision::float64, lbm::Precision::float32}) {
        lbm::Config c = small();
        c.precision = precision;
        lbm::Solver<2> solver(c);
        std::vector<double> const position = {0.0203, 0.0151}, rest = {0, 0}, spin = {0}, radius = {6e-3};
        for (int k = 0; k < 100; ++k) {
            solver.set_bodies({position, rest, spin, radius});
            solver.step();
        }
        CHECK(solver.max_speed() == 0);
        CHECK(solver.loads().force[0] == 0);
        CHECK(solver.loads().torque[0] == 0);
        CHECK(solver.share().rebuilt_bodies == 0);
        CHECK(solver.share().covered_cells > 0.1);
    }
}

TEST_CASE("solver: fractions are reckoned anew of discs that moved or changed size, of no others, with the same bits")
{
    lbm::Solver<2> solver(small());
    std::vector<double> position = {0.0103, 0.0151, 0.0301, 0.0149}, radius = {5e-3, 4e-3};
    std::vector<double> const rest(4, 0.0), spin(2, 0.0);
    auto const rebuilt = [&](lbm::Solver<2>& any) {
        any.set_bodies({position, rest, spin, radius});
        any.step();
        return any.share().rebuilt_bodies;
    };
    CHECK(rebuilt(solver) == 1);
    CHECK(rebuilt(solver) == 0);
    position[2] += 1e-4;
    CHECK(rebuilt(solver) == 0.5);
    lbm::Solver<2> fresh(small());
    CHECK(rebuilt(fresh) == 1);
    CHECK(solver.share().covered_cells == fresh.share().covered_cells);  // of the last step alone
    CHECK((fresh.share().covered_cells > 0.05 && fresh.share().covered_cells < 0.5));
    CHECK(solver.fields().solid_fraction == fresh.fields().solid_fraction);
    radius[0] = 4.5e-3;  // all have other places in memory then
    CHECK(rebuilt(solver) == 1);
}

TEST_CASE("solver: a fluid column under gravity pushes a disc up by rho_0 V g")
{
    for (auto const collision : {lbm::Operator::mrt, lbm::Operator::central}) {
        lbm::Config c = small();
        c.collision = collision;
        c.acceleration = {0, -0.01};
        c.hydrodynamic_radius = 0.8;
        lbm::Solver<2> solver(c);
        solver.set_state([](std::array<double, 2> const& at) {
            double const y = at[1];
            return lbm::PointState<2>{.velocity = {}, .pressure = 1000 * 0.01 * (0.015 - y), .gradient = {}};
        });
        std::vector<double> const position = {0.0203, 0.0151}, rest = {0, 0}, spin = {0}, radius = {6e-3};
        solver.set_bodies({position, rest, spin, radius});
        for (int k = 0; k < 500; ++k) solver.step();
        double const weight = 1000 * 3.14159265358979 * 4.8e-3 * 4.8e-3 * 0.01;
        CHECK(solver.loads().force[1] == close_to(weight).epsilon(1e-6));
        CHECK(std::abs(solver.loads().force[0]) < 1e-6 * weight);
    }
}

TEST_CASE("solver: discs may come and go and change order and loads follow their ids")
{
    lbm::Solver<2> by_index(small()), by_id(small());
    std::vector<double> const position = {0.010, 0.012, 0.028, 0.017}, velocity = {0.01, 0, 0, -0.02}, spin = {0, 1},
                              radius = {4e-3, 5e-3};
    std::vector<double> const turned_position = {0.028, 0.017, 0.010, 0.012}, turned_velocity = {0, -0.02, 0.01, 0},
                              turned_spin = {1, 0}, turned_radius = {5e-3, 4e-3};
    std::vector<std::uint64_t> const id = {5, 9}, turned_id = {9, 5};
    for (int k = 0; k < 20; ++k) {
        by_index.set_bodies({position, velocity, spin, radius});
        by_index.step();
        if (k % 2 == 0)
            by_id.set_bodies({position, velocity, spin, radius, id});
        else
            by_id.set_bodies({turned_position, turned_velocity, turned_spin, turned_radius, turned_id});
        by_id.step();
    }
    CHECK(by_id.loads().force[2] == close_to(by_index.loads().force[0]).epsilon(1e-9));
    CHECK(by_id.loads().force[1] == close_to(by_index.loads().force[3]).epsilon(1e-9));
    by_id.set_bodies({});
    by_id.step();
    CHECK(by_id.loads().force.empty());
}

namespace {

template <int D>
void check_lids_keep_mass(std::mt19937& random)
{
    auto c = unit_config<D>({7, 6, D == 3 ? 5.0 : 0.0}, 0.1);
    constexpr auto sides = static_cast<std::size_t>(2 * D);
    for (std::size_t side = 0; side < sides; ++side) {
        c.walls[side].kind = random() % 3 == 0 ? lbm::Border::slip : lbm::Border::wall;
        if (c.walls[side].kind == lbm::Border::slip) continue;
        for (std::size_t k = 0; k < D; ++k)
            if (k != side / 2) c.walls[side].velocity[k] = 0.02 * (static_cast<double>(random() % 3) - 1);
    }
    lbm::Solver<D> solver(c);
    solver.set_state([](auto const&) { return lbm::PointState<D>{}; });
    double const before = solver.mass();
    constexpr int steps = 20;
    for (int k = 0; k < steps; ++k) solver.step();
    // one wall that brought u/6 through an edge of a single cell: 20 * 0.02/6 = 0.07
    CHECK(solver.mass() == close_to(before).epsilon(1e-13));
}

}  // namespace

TEST_CASE("solver: walls that move bring no mass, whatever walls and sides without friction they meet")
{
    std::mt19937 random(11);
    for (int k = 0; k < 20; ++k) {
        check_lids_keep_mass<2>(random);
        check_lids_keep_mass<3>(random);
    }
}

TEST_CASE("solver: a run that blows up stops with cell, place and time")
{
    lbm::Solver<2> fast(small());
    fast.set_state([](std::array<double, 2> const& at) {
        double const x = at[0];
        return lbm::PointState<2>{.velocity = {x > 0.02 ? 0.9 : 0.0, 0}, .pressure = 0, .gradient = {}};
    });
    std::string const text = message([&] {
        for (int k = 0; k < 200; ++k) fast.step();
    });
    CHECK(contains(text, "6 fluid: t = "));
    CHECK(contains(text, "cell ("));
    lbm::Solver<2> broken(small());
    broken.set_state([](std::array<double, 2> const& at) {
        double const x = at[0];
        return lbm::PointState<2>{
            .velocity = {x > 0.03 ? std::numeric_limits<double>::quiet_NaN() : 0.0, 0}, .pressure = 0, .gradient = {}};
    });
    CHECK(contains(message([&] {
                       for (int k = 0; k < 64; ++k) broken.step();
                   }),
                   "6 fluid: t = "));
}

TEST_CASE("blow up: what is told of a cell is what its limits are of")
{
    std::mt19937_64 random(3);
    std::normal_distribution<double> number(0, 0.12);
    std::array<double, lbm::Lattice<3>::directions> cell{};
    lbm::Slots<3, double> slots;
    for (std::size_t q = 0; q < cell.size(); ++q) slots[q] = &cell[q];
    int good = 0, bad = 0;
    for (int k = 0; k < 2000; ++k) {
        for (double& f : cell) f = number(random);
        auto const [speed, density] = lbm::speed_and_density<3>(slots, 0);
        bool const within = std::abs(speed) <= lbm::speed_limit && std::abs(density - 1) <= lbm::excess_limit;
        CHECK(lbm::has_blown_up<3>(slots, 1) == !within);
        ++(within ? good : bad);
    }
    CHECK(std::min(good, bad) > 200);
}

TEST_CASE("solver: discs that are not finite, or arrays that differ, are refused")
{
    lbm::Solver<2> solver(small());
    std::vector<double> const position = {0.02, std::nan("")}, rest = {0, 0}, spin = {0}, radius = {5e-3}, two = {1, 2},
                              lost = {0.02, -1e7};
    CHECK(contains(message([&] { solver.set_bodies({position, rest, spin, radius}); }), "6 fluid: body 0"));
    CHECK(contains(message([&] { solver.set_bodies({lost, rest, spin, radius}); }), "within 1e9 cells"));
    CHECK(contains(message([&] { solver.set_bodies({rest, rest, two, radius}); }), "4 ") == false);
    CHECK(contains(message([&] { solver.set_bodies({rest, rest, two, radius}); }), "differ in length"));
    CHECK(contains(message([&] {
                       lbm::Solver<2>(small(), {{.size = {3, 1, 1}, .fraction = {1, 1}}});
                   }),
                   "a patch of 3 cells has 2 fractions"));
}

TEST_CASE("solver: a state of another lattice is refused and changes nothing")
{
    lbm::Solver<2> solver(small());
    sluice::State before, after, other;
    solver.keep(before);
    other.put_integer("steps", 5);
    for (auto const name : {"bodies/place", "bodies/displaced", "last/velocity", "last/exchange", "populations/0"})
        other.put(name, std::span<double const>());
    for (auto const name : {"bodies/id", "last/id"}) other.put(name, std::span<std::int64_t const>());
    CHECK(contains(message([&] { solver.restore(other); }), "7 state: \"populations/0\" has 0 values"));
    CHECK(contains(message([&] { solver.restore(sluice::State()); }), "is not in it"));
    solver.keep(after);
    CHECK(before == after);

    lbm::Config config = small();
    config.precision = lbm::Precision::float32;
    lbm::Solver<2> single(config);
    CHECK(contains(message([&] { single.restore(before); }), "\"populations/0\""));
    config.size[0] *= 2;
    lbm::Solver<2> wider(config);
    sluice::State floats;
    single.keep(floats);
    CHECK(contains(message([&] { wider.restore(floats); }), "7 state: \"populations/0\" has 4800 bytes (needs 9600)"));
}

TEST_CASE("solver: a checkpoint in single precision takes half the room, and the run goes on bit for bit")
{
    lbm::Config config = small();
    config.precision = lbm::Precision::float32;
    lbm::Solver<2> whole(config), resumed(config);
    std::vector<double> const position = {0.0203, 0.0151}, velocity = {0.01, 0.02}, spin = {1}, radius = {6e-3};
    for (int k = 0; k < 40; ++k) {
        for (auto* solver : {&whole, &resumed}) {
            if (solver == &resumed && k < 20) continue;
            solver->set_bodies({position, velocity, spin, radius});
            solver->step();
        }
        if (k != 19) continue;
        sluice::State kept;
        whole.keep(kept);
        CHECK(kept.bytes("populations/3").size() == 40 * 30 * sizeof(float));
        resumed.restore(kept);
    }
    sluice::State a, b;
    whole.keep(a);
    resumed.keep(b);
    CHECK(a == b);
    for (double& length : config.size) length *= 10;
    std::size_t const in_single = lbm::Solver<2>(config).bytes();
    config.precision = lbm::Precision::float64;
    CHECK(2 * in_single <= lbm::Solver<2>(config).bytes() + (2UL << 20));  // whole pages of 2 MiB
}

namespace {

//! The velocity of pictures is that of a cell's momentum midway through the collision: summed up, what the lattice has
//! less half of what it gives to the bodies in the step that follows.
template <int D>
void check_pictures(lbm::Surface surface, double viscosity)
{
    auto c = unit_config<D>({14, 12, D == 3 ? 13.0 : 0.0}, viscosity);
    c.surface = surface;
    for (std::size_t k = 0; k < D; ++k) c.set_periodic(k);
    lbm::Solver<D> solver(c);
    solver.set_state([](auto const&) {
        lbm::PointState<D> state;
        state.velocity[0] = 0.03;
        return state;
    });
    std::vector<double> position(D, 6.3), velocity(D, -0.01), spin(lbm::spins<D>, 0.002), radius{1.9};  // no core
    double const cells = c.size[0] * c.size[1] * (D == 3 ? c.size[2] : 1.0);
    double const rounding = std::numeric_limits<double>::epsilon() * cells * 0.03 * cells;  // of a sum one by one
    for (int k = 0; k < 5; ++k) {
        solver.set_bodies({position, velocity, spin, radius});
        auto const fields = solver.fields();
        auto expected = solver.momentum();
        solver.step();
        for (std::size_t axis = 0; axis < D; ++axis) {
            double sum = 0;
            for (std::size_t cell = 0; cell < fields.pressure.size(); ++cell)
                sum += (1 + 3 * fields.pressure[cell]) * fields.velocity[D * cell + axis];
            double const given = solver.exchange().force[axis];
            CHECK(std::abs(given) > 1e-4);
            CHECK(std::abs(sum - (expected[axis] - 0.5 * given)) < rounding);
        }
        for (std::size_t axis = 0; axis < D; ++axis) position[axis] += velocity[axis];
    }
}

}  // namespace

TEST_CASE("solver: pictures show the velocity of fluid and grains together, covered and forced")
{
    for (double const viscosity : {0.005, 0.1}) {
        check_pictures<2>(lbm::Surface::covered, viscosity);
        check_pictures<2>(lbm::Surface::forced, viscosity);
        check_pictures<3>(lbm::Surface::forced, viscosity);
    }
}

TEST_CASE("solver: samples between cells are linear, and at a side those of the last cell")
{
    lbm::Config c;
    c.dimension = 2;
    c.cell = 0.5, c.step = 0.1, c.density = 1000;
    c.viscosity = 0.1;
    c.origin = {1, 2, 0};
    c.size = {10, 8, 0};
    lbm::Solver<2> solver(c);
    auto const pressure = [](double x, double y) { return 3 * x - 5 * y; };
    solver.set_state([&](std::array<double, 2> const& at) {
        lbm::PointState<2> state;
        state.pressure = pressure(at[0], at[1]);
        return state;
    });
    std::vector<std::array<double, 2>> const places{{4.1, 6.3}, {1.25, 2.25}, {10.7, 9.6}, {1, 5.25}, {5.25, 10}};
    auto const samples = solver.samples(places);
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(samples[k].pressure == close_to(pressure(places[k][0], places[k][1])).epsilon(1e-12));
        CHECK(std::abs(samples[k].velocity[0]) < 1e-12);
        CHECK(samples[k].solid_fraction == 0);
    }
    CHECK(samples[3].pressure == close_to(pressure(1.25, 5.25)).epsilon(1e-12));
    CHECK(samples[4].pressure == close_to(pressure(5.25, 9.75)).epsilon(1e-12));
}

TEST_CASE("solver: energy, enstrophy and Q-criterion of flows that have closed forms")
{
    lbm::Config c;
    c.dimension = 2;
    c.cell = 0.5, c.step = 0.01, c.density = 1000;
    c.viscosity = 0.1;
    c.size = {16, 16, 0};
    for (std::size_t k = 0; k < 2; ++k) c.set_periodic(k);
    double const u = 0.1, wave = 2 * std::numbers::pi / 16;
    lbm::Solver<2> vortices(c);
    vortices.set_state([&](std::array<double, 2> const& at) {
        lbm::PointState<2> state;
        state.velocity = {u * std::sin(wave * at[1]), 0};
        return state;
    });
    auto const energies = vortices.energies();
    // differences of neighbours see a wave number of sin(k dx)/dx; squares of sines are 1/2 in the mean, exactly
    double const seen = std::sin(wave * c.cell) / c.cell;
    CHECK(energies.kinetic == close_to(0.25 * c.density * u * u * 256).epsilon(1e-12));
    CHECK(energies.enstrophy == close_to(0.25 * u * u * seen * seen * 256).epsilon(1e-12));
    for (double const q : vortices.fields(1, {.q_criterion = true}).q_criterion) CHECK(std::abs(q) < 1e-12);  // shear

    lbm::Config box = c;
    box.walls = {};
    lbm::Solver<2> turning(box);
    double const rate = 0.05;
    turning.set_state([&](std::array<double, 2> const& at) {
        lbm::PointState<2> state;
        state.velocity = {-rate * (at[1] - 8), rate * (at[0] - 8)};
        return state;
    });
    auto const fields = turning.fields(
        1, {.velocity = false, .pressure = false, .vorticity = false, .solid_fraction = false, .q_criterion = true});
    CHECK(fields.velocity.empty());
    CHECK(fields.vorticity.empty());
    for (double const q : fields.q_criterion) CHECK(q == close_to(rate * rate).epsilon(1e-10));
}
