#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <numbers>
#include <numeric>
#include <string>

#include "coupler/base/error.hpp"
#include "tests/verification/lbm/lattice_case.hpp"

//! Sweeps to where the solver no longer works, for each operator. Every trial ends stable, refused with a message, or
//! stopped by the watch with one: never with numbers that are none. SLUICE_STABILITY_CSV names a file for the map
//! (plot_stability.py draws it).
using namespace lattice_case;

namespace {

struct Scheme
{
    char const* name;
    lbm::Operator collision;
    double smagorinsky;
};
constexpr Scheme schemes[] = {{"bgk", lbm::Operator::bgk, 0},
                              {"trt", lbm::Operator::trt, 0},
                              {"mrt", lbm::Operator::mrt, 0},
                              {"mrt + les", lbm::Operator::mrt, 0.1},
                              {"central", lbm::Operator::central, 0}};

//! One point of a map, and what a run there comes to: a number that says how well it went.
struct Trial
{
    char const* sweep;
    std::string series, parameter;
    double value;
    char const* measure;
    std::function<double()> run;
};

struct Map
{
    std::ofstream csv;
    int stable = 0, refused = 0, stopped = 0, wrong = 0;

    Map()
    {
        if (char const* const file = std::getenv("SLUICE_STABILITY_CSV")) {
            csv.open(file, std::ios::app);
            if (csv.tellp() == 0) csv << "sweep,series,parameter,value,outcome,measure,measured\n";
        }
    }
    //! Returns whether the trial was stable.
    bool tried(Trial const& t)
    {
        char const* outcome = "stable";
        double measured = NAN;
        try {
            measured = t.run();
            std::isfinite(measured) ? ++stable : ++wrong;
            if (!std::isfinite(measured)) outcome = "not a number";
        } catch (sluice::Error const& e) {
            bool const watch = e.exit() == sluice::Exit::numerical;
            outcome = watch ? "blown up" : "refused";
            watch ? ++stopped : ++refused;
            wrong += std::string(e.what()).empty();
        }
        csv << t.sweep << ',' << t.series << ',' << t.parameter << ',' << t.value << ',' << outcome << ',' << t.measure
            << ',' << measured << '\n';
        std::printf("%-14s %-18s %s = %-8g %-9s %s %.3g\n", t.sweep, t.series.c_str(), t.parameter.c_str(), t.value,
                    outcome, t.measure, measured);
        return std::string(outcome) == "stable";
    }
    void report(char const* id, verification::Stopwatch const& watch) const
    {
        std::string const text = std::to_string(stable) + " stable, " + std::to_string(refused) + " refused, " +
                                 std::to_string(stopped) + " stopped; silent:";
        CHECK(verification::report(
            {id, text, static_cast<double>(wrong), 0, static_cast<double>(wrong), 0, watch.seconds()}));
    }
};

lbm::Config with(Scheme const& s, lbm::Config c)
{
    c.collision = s.collision;
    c.smagorinsky = s.smagorinsky;
    if (s.smagorinsky > 0) c.flux_rate = 1.2;  // as a scene with les has it
    return c;
}

//! Steps, with the watch's last look at the end; returns the fastest speed over `unit`.
double fastest_after(lbm::Solver<2>& solver, int steps, double unit)
{
    for (int k = 0; k < (steps + 63) / 64 * 64; ++k) solver.step();
    return solver.max_speed() / unit;
}

//! Minion and Brown (1997): two shear layers of width N/80 that roll up; U = 0.05, until t = 2 N/U.
double shear_layers(Scheme const& s, std::ptrdiff_t n, double reynolds)
{
    double const u = 0.05, size = static_cast<double>(n), pi = std::numbers::pi;
    lbm::Config c = with(s, config(n, n, 0.5 + 3 * u * size / reynolds));
    c.max_velocity = u;
    make_periodic(c, true, true);
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        double const x = at[0] / size, y = at[1] / size;
        return lbm::PointState<2>{.velocity = {u * std::tanh(80 * (y <= 0.5 ? y - 0.25 : 0.75 - y)),
                                               0.05 * u * std::sin(2 * pi * (x + 0.25))},
                                  .pressure = 0,
                                  .gradient = {}};
    });
    return fastest_after(solver, static_cast<int>(2 * size / u), u);
}

double vortices(Scheme const& s, double u, bool declared)
{
    double const k = 2 * std::numbers::pi / 32;
    lbm::Config c = with(s, config(32, 32, 0.8));
    if (declared) c.max_velocity = u;
    make_periodic(c, true, true);
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        return lbm::PointState<2>{
            .velocity = {-u * std::cos(k * at[0]) * std::sin(k * at[1]), u * std::sin(k * at[0]) * std::cos(k * at[1])},
            .pressure = -0.25 * u * u * (std::cos(2 * k * at[0]) + std::cos(2 * k * at[1])),
            .gradient = {}};
    });
    double const speed = fastest_after(solver, 128, u);
    return speed * std::exp(2 * c.viscosity * k * k * 128);  // 1 but for errors of Mach^2
}

double cavity(Scheme const& s, double reynolds)
{
    double const lid = 0.1, size = 128;
    lbm::Config c = with(s, config(128, 128, 0.5 + 3 * lid * size / reynolds));
    c.max_velocity = lid;
    c.walls[lbm::top<2>].velocity[0] = lid;
    lbm::Solver<2> solver(c);
    return fastest_after(solver, static_cast<int>(20 * size / lid), lid);
}

//! A free disc of r = 8 cells and a density of `ratio` times the fluid's, under gravity in a closed box that turns it
//! loose at rest. Returns how often its velocity turned round, over the last half of the steps.
double free_disc(Scheme const& s, double ratio, double tau)
{
    double const r = 8, g = 2e-5, mass = ratio * std::numbers::pi * r * r;
    lbm::Config c = with(s, config(96, 128, tau));
    c.acceleration = {0, -g, 0};
    lbm::Solver<2> solver(c);
    solver.set_state([&](std::array<double, 2> const& at) {
        return lbm::PointState<2>{.velocity = {}, .pressure = g * (64 - at[1]), .gradient = {}};
    });
    double y = 64, v = 0, last = 0, turns = 0;
    int const steps = 1024;
    for (int k = 0; k < steps; ++k) {
        Discs discs;
        discs.add(48, y, r, 0, v);
        solver.set_bodies(discs.view());
        solver.step();
        last = v;
        y += v;
        v += solver.loads().force[1] / mass - g;
        sluice::require(std::abs(v) < 0.4,
                        [] { return sluice::Error("disc: faster than 0.4 cells a step.", sluice::Exit::numerical); });
        turns += k > steps / 2 && v * last < 0;
    }
    return turns;
}

//! Two discs that are driven together until nothing is between them, then rest: the largest density excess.
double pressed_discs(Scheme const& s, double gap)
{
    lbm::Config const c = with(s, config(80, 48, 0.6));
    lbm::Solver<2> solver(c);
    double const speed = 0.005;
    double apart = gap + 2;  // cells
    double worst = 0;
    for (int k = 0; k < 3072; ++k) {
        bool const moves = apart > gap;
        Discs discs;
        discs.add(40 - 8 - 0.5 * apart, 24, 8, moves ? speed : 0);
        discs.add(40 + 8 + 0.5 * apart, 24, 8, moves ? -speed : 0);
        solver.set_bodies(discs.view());
        solver.step();
        if (moves) apart -= 2 * speed;
        if (k % 256 == 255)
            for (double const p : solver.fields().pressure) worst = std::max(worst, std::abs(3 * p));
    }
    return worst;
}

//! A disc that is set moving within 512 steps, through fluid at rest, 8 cells in radius: RMS of what its force differs
//! from the mean over the two cells around, over the force.
double moving_disc(Scheme const& s, double u)
{
    lbm::Config c = with(s, config(256, 64, 0.55));
    make_periodic(c, true, true);
    lbm::Solver<2> solver(c);
    std::vector<double> force;
    double x = 40;
    for (int k = 0; k < 1024; ++k) {
        double const speed = k < 512 ? 0.5 * u * (1 - std::cos(std::numbers::pi * k / 512)) : u;
        Discs discs;
        discs.add(x, 32.3, 8, speed);
        solver.set_bodies(discs.view());
        solver.step();
        x += speed;
        force.push_back(solver.loads().force[0]);
    }
    auto const half = static_cast<std::ptrdiff_t>(std::lround(1 / u));
    double squares = 0, sum = 0, n = 0;
    for (auto f = force.begin() + 512; f + half < force.end(); ++f) {
        double const mean = std::accumulate(f - half, f + half + 1, 0.0) / static_cast<double>(2 * half + 1);
        squares += (*f - mean) * (*f - mean), sum += mean, n += 1;
    }
    return std::sqrt(squares / n) / std::abs(sum / n);
}

double seen_radius(Scheme const& s, double factor, double radius)
{
    lbm::Config c = with(s, config(32, 32, 0.6));
    make_periodic(c, true, true);
    c.acceleration = {1e-6, 0, 0};
    c.hydrodynamic_radius = factor;
    lbm::Solver<2> solver(c);
    Discs discs;
    discs.add(16.2, 15.7, radius);
    solver.set_bodies(discs.view());
    fastest_after(solver, 4096, 1);
    return mean_velocity(solver, 0) / 1e-6;
}

//! Uniform flow in a frame that turns by w a step: how far its speed has grown after a hundred turns at most.
double turning(Scheme const& s, double w)
{
    lbm::Config c = with(s, config(8, 8, 0.6));
    make_periodic(c, true, true);
    sluice::Rotation rotation;
    rotation.rate = w;
    rotation.centrifugal = false;
    c.rotation = rotation;
    lbm::Solver<2> solver(c);
    solver.set_state([](std::array<double, 2> const&) {
        return lbm::PointState<2>{.velocity = {0.05, 0.02}, .pressure = 0, .gradient = {}};
    });
    return fastest_after(solver, 3072, std::hypot(0.05, 0.02)) - 1;
}

//! Gravity at once on fluid at rest of uniform density, 64 cells deep: largest pressure at the floor over the depth's.
double sudden_gravity(Scheme const& s, double mach_squared)
{
    double const g = mach_squared / 3 / 64;
    lbm::Config c = with(s, config(16, 64, 0.55));
    c.acceleration = {0, -g, 0};
    c.set_periodic(0);
    lbm::Solver<2> solver(c);
    double worst = 0;
    for (int k = 0; k < 1024; ++k) {
        solver.step();
        if (k % 8 == 0) worst = std::max(worst, solver.fields().pressure[3] / (g * 32));
    }
    return worst;
}

}  // namespace

TEST_CASE("stability: what must work and what must not go on unseen")
{
    verification::Stopwatch const watch;
    Map map;
    Scheme const &bgk = schemes[0], &mrt = schemes[2], &les = schemes[3], &central = schemes[4];
    // what must work: marks are those of the sweeps
    CHECK(map.tried({"shear layers", "mrt + les, N=64", "Re", 1e5, "U", [&] { return shear_layers(les, 64, 1e5); }}));
    CHECK(map.tried({"shear layers", "central, N=64", "Re", 1e5, "U", [&] { return shear_layers(central, 64, 1e5); }}));
    CHECK(map.tried({"free disc", "mrt", "density", 1.001, "turns", [&] { return free_disc(mrt, 1.001, 0.8); }}));
    CHECK(moving_disc(mrt, 0.1) < 0.05);
    CHECK(std::abs(turning(bgk, 0.1)) < 1e-9);
    // and what must not go on unseen
    CHECK(!map.tried({"mach", "bgk, declared", "u", 0.3, "u", [&] { return vortices(bgk, 0.3, true); }}));
    CHECK(!map.tried({"shear layers", "bgk, N=64", "Re", 1e6, "U", [&] { return shear_layers(bgk, 64, 1e6); }}));
    map.report("stability", watch);
}

TEST_CASE("stability: maps for each operator" * doctest::skip())
{
    verification::Stopwatch const watch;
    Map map;
    for (Scheme const& s : schemes) {
        std::string const name = s.name;
        for (std::ptrdiff_t const n : {64, 128})
            for (double const re : {1e4, 3e4, 1e5, 3e5, 1e6})
                map.tried({"shear layers", name + " N=" + std::to_string(n), "Re", re, "fastest/U",
                           [&] { return shear_layers(s, n, re); }});
        for (bool const declared : {true, false})
            for (double const u : {0.01, 0.05, 0.1, 0.15, 0.2, 0.3, 0.39, 0.5})
                map.tried({"mach", name + (declared ? " declared" : ""), "u", u, "speed left/exact",
                           [&] { return vortices(s, u, declared); }});
        for (double const re : {1e3, 5e3, 1e4, 2e4, 5e4})
            map.tried({"cavity", name, "Re", re, "fastest/U", [&] { return cavity(s, re); }});
        for (double const tau : {0.55, 0.8})
            for (double const ratio : {2.65, 1.5, 1.1, 1.001, 0.9, 0.5, 0.3, 0.1, 0.01})
                map.tried({"free disc", name + (tau < 0.6 ? " tau 0.55" : " tau 0.8"), "density ratio", ratio, "turns",
                           [&] { return free_disc(s, ratio, tau); }});
        for (double const gap : {2.0, 1.0, 0.5, 0.1, 0.0})
            map.tried({"pressed discs", name, "gap", gap, "density excess", [&] { return pressed_discs(s, gap); }});
        for (double const f : {0.3, 0.5, 0.7, 0.85, 1.0})
            map.tried({"seen radius", name + " R=4", "f", f, "U/a", [&] { return seen_radius(s, f, 4); }});
        for (double const u : {0.02, 0.05, 0.1, 0.2, 0.3})
            map.tried({"moving disc", name, "u", u, "force noise", [&] { return moving_disc(s, u); }});
        for (double const w : {1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2})
            map.tried({"turning frame", name, "w dt", w, "growth", [&] { return turning(s, w); }});
        for (double const m : {1e-3, 0.01, 0.05, 0.1, 0.2})
            map.tried({"sudden gravity", name, "g H/c_s^2", m, "p/p_h", [&] { return sudden_gravity(s, m); }});
    }
    for (double const cs : {0.05, 0.1, 0.17, 0.3, 0.5})
        for (double const re : {1e4, 1e6}) {
            Scheme const s{"mrt + les", lbm::Operator::mrt, cs};
            map.tried({"les", re < 1e5 ? "mrt Re=1e4" : "mrt Re=1e6", "C_s", cs, "fastest/U",
                       [&] { return shear_layers(s, 64, re); }});
        }
    map.report("stability", watch);
}
