#include "participants/dem/packing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

#include "participants/dem/packing_file.hpp"
#include "participants/dem/random.hpp"
#include "participants/dem/restitution.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/solver.hpp"

//! Three stages, each a few numbers:
//!   pour   grains fall from a loose jittered grid; friction of the packing, strong dashpots, a background drag whose
//!          terminal speed is a fraction of the free fall's
//!   relax  the scene's friction; the drag near-critical for the slowest sound wave of the column
//!   hold   the scene's own laws, no drag: what is accepted stays at rest by itself
namespace dem {
namespace {

constexpr double pouring_damping = 0.5;  //!< alpha_n and alpha_t while poured and relaxed [-]
constexpr int longest_hold = 8;          //!< rounds of relax and hold before giving up

void say(Progress const& progress, char const* stage, double time, double ratio)
{
    if (!progress) return;
    char text[160];
    std::snprintf(text, sizeof text, "packing: %s, t = %.3f s, kinetic energy / m g d = %.1e", stage, time, ratio);
    progress(text);
}

//! Grains on a grid of cells of one largest diameter, each at a random place in its cell; lowest rows first.
Grains loose_grains(Config const& config)
{
    Random random(config.column->seed);
    double const width = column_width(config), pitch = 1.02 * config.diameter_max;
    auto const columns = std::max<std::int64_t>(1, static_cast<std::int64_t>(width / pitch));
    double const cell = width / static_cast<double>(columns);
    Grains grains;
    for (std::int64_t i = 0; i < config.column->count; ++i) {
        double const radius = 0.5 * random.uniform(config.diameter_min, config.diameter_max);
        double const x = static_cast<double>(i % columns) * cell + random.uniform(radius, cell - radius);
        double const y = static_cast<double>(i / columns) * pitch + random.uniform(radius, pitch - radius);
        grains.add({x, y}, radius, config.density);
    }
    return grains;
}

//! Kinetic energy over sum m g d_mean [-].
double kinetic_ratio(Solver const& solver, Config const& config)
{
    Grains const& g = solver.grains();
    double kinetic = 0.0, mass = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        kinetic +=
            0.5 * g.mass[i] * (g.vx[i] * g.vx[i] + g.vy[i] * g.vy[i]) + 0.5 * g.inertia[i] * g.spin[i] * g.spin[i];
        mass += g.mass[i];
    }
    double const gravity = std::hypot(config.gravity.x, config.gravity.y);
    return kinetic / (mass * gravity * 0.5 * (config.diameter_min + config.diameter_max));
}

//! `rate` [1/s]: external force -rate m v on every grain.
void step_with_drag(Solver& solver, double dt, double rate)
{
    Grains& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i) {
        g.external_fx[i] = -rate * g.mass[i] * g.vx[i];
        g.external_fy[i] = -rate * g.mass[i] * g.vy[i];
        g.external_torque[i] = -rate * g.inertia[i] * g.spin[i];
    }
    solver.step(dt);
}

//! Steps until the kinetic ratio has been below `enough` at `checks` checks in a row; at most until `limit` [s] more.
double run_until(Solver& solver, Config const& config, Progress const& progress, char const* stage, double dt,
                 double drag, double enough, int checks, double limit)
{
    double const end = solver.time() + limit, every = limit / 100.0;  // [s] between checks
    double next = solver.time() + every, ratio = 1.0;
    for (int quiet = 0; quiet < checks && solver.time() < end;) {
        step_with_drag(solver, dt, drag);
        if (solver.time() < next) continue;
        next += every;
        ratio = kinetic_ratio(solver, config);
        quiet = ratio <= enough ? quiet + 1 : 0;
        say(progress, stage, solver.time(), ratio);
    }
    return ratio;
}

}  // namespace

Packing pour_packing(Config const& config, Progress const& progress)
{
    Config dry = config;  // buoyancy and gates belong to the run
    dry.fluid_density = 0.0;
    for (WallConfig& wall : dry.walls) wall.removed_at = std::numeric_limits<double>::infinity();
    ContactConfig const& c = dry.contact;
    Setup setup = make_setup(dry);
    setup.features.friction = true;
    NormalForce const soft_landing = make_normal_force(c.normal_stiffness, std::max(c.damping_ratio, pouring_damping));
    auto tangential = [&](double mu) { return make_tangential_force(c.tangential_stiffness, pouring_damping, mu); };

    Solver solver(setup, loose_grains(dry));
    double const gravity = std::hypot(dry.gravity.x, dry.gravity.y), width = column_width(dry);
    double const height = width * dry.column->aspect_ratio, fall = std::sqrt(height / gravity);  // [s]
    double const heaviest = dry.density * std::numbers::pi / 4.0 * dry.diameter_max * dry.diameter_max;
    double const wave = height / dry.diameter_min * std::sqrt(heaviest / c.normal_stiffness);  // through the column [s]
    double const step = contact_time(c.normal_stiffness, c.tangential_stiffness,
                                     0.5 * dry.density * std::numbers::pi / 4.0 * dry.diameter_min * dry.diameter_min);
    solver.set_laws(soft_landing, tangential(dry.column->packing_friction));
    run_until(solver, dry, progress, "pouring", step / 20.0, 2.0 / fall, 1e-4, 3, 20.0 * fall);
    double ratio = 1.0;
    for (int round = 0; round < longest_hold && ratio > settled_kinetic_ratio; ++round) {
        solver.set_laws(soft_landing, tangential(c.friction));
        run_until(solver, dry, progress, "relaxing", step / 20.0, 1.0 / wave, 0.01 * settled_kinetic_ratio, 2,
                  200.0 * wave);
        solver.set_laws(setup.normal_force, setup.tangential_force);
        ratio = run_until(solver, dry, progress, "holding", step / 50.0, 0.0, settled_kinetic_ratio, 5, 40.0 * wave);
    }
    if (ratio > settled_kinetic_ratio) say(progress, "NOT settled (needed: 1e-8)", solver.time(), ratio);
    Grains const& g = solver.grains();
    return {g.x, g.y, g.radius, springs_of(solver.state()), ratio};
}

Packing prepare_packing(Config const& config, std::filesystem::path const& cache, Progress const& progress)
{
    if (!config.column) return {};
    std::filesystem::path const file = cache / packing_file_name(config);
    if (!cache.empty()) {
        std::string damage;
        if (auto packing = load_packing(file, damage)) return std::move(*packing);
        if (!damage.empty() && progress) progress(damage);
    }
    Packing packing = pour_packing(config, progress);
    if (!cache.empty()) write_packing(packing, file);
    return packing;
}

}  // namespace dem
