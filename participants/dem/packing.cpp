#include "participants/dem/packing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

#include "participants/dem/packing_file.hpp"
#include "participants/dem/random.hpp"
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

//! Whether a grain of this radius lies within a column's container.
template <int D>
bool fits(Setup<D> const& setup, Vec<D> centre, double radius)
{
    for (Wall<D> const& wall : setup.walls) {
        auto const at = std::visit([&](auto const& shape) { return shape.facing(centre); }, wall.shape);
        if (at.distance < radius) return false;
    }
    return true;
}

//! Grains on a grid of cells of one largest diameter, each at a random place in its cell; lowest rows first. Cells that
//! are not wholly within the container stay empty.
template <int D>
Grains<D> loose_grains(Config const& config, Setup<D> const& setup)
{
    ColumnConfig const& column = *config.column;
    Random random(column.seed);
    double const width = column_width(config), pitch = 1.02 * config.diameter_max;
    double const left = column.container == Container::cylinder ? -width : 0.0;
    double const depth = D == 2 ? 0.0 : column.container == Container::box ? column.depth : width - left;
    auto const cells = [&](double length) {
        return std::max<std::int64_t>(1, static_cast<std::int64_t>(length / pitch));
    };
    std::int64_t const columns = cells(width - left), rows = D == 2 ? 1 : cells(depth);
    double const cell_x = (width - left) / static_cast<double>(columns), cell_y = depth / static_cast<double>(rows);
    double const front = column.container == Container::box ? 0.0 : left;
    Grains<D> grains;
    for (std::int64_t k = 0; static_cast<std::int64_t>(grains.size()) < column.count; ++k) {
        double const x0 = left + static_cast<double>(k % columns) * cell_x;
        double const y0 = front + static_cast<double>(k / columns % rows) * cell_y;
        double const up0 = static_cast<double>(k / columns / rows) * pitch;
        double const radius = 0.5 * random.uniform(config.diameter_min, config.diameter_max);
        double const x = x0 + random.uniform(radius, cell_x - radius);
        Vec<D> centre;
        if constexpr (D == 2) {
            centre = {x, up0 + random.uniform(radius, pitch - radius)};
        } else {
            double const y = y0 + random.uniform(radius, cell_y - radius);
            centre = {x, y, up0 + random.uniform(radius, pitch - radius)};
        }
        if (fits(setup, centre, radius)) grains.add(centre, radius, config.density);
    }
    return grains;
}

//! Kinetic energy over sum m g d_mean [-].
template <int D>
double kinetic_ratio(Solver<D> const& solver, Config const& config)
{
    Grains<D> const& g = solver.grains();
    double mass = 0.0;
    for (double const m : g.mass) mass += m;
    return kinetic_energy(g) / (mass * norm(config.gravity) * 0.5 * (config.diameter_min + config.diameter_max));
}

//! `rate` [1/s]: external force -rate m v on every grain.
template <int D>
void step_with_drag(Solver<D>& solver, double dt, double rate)
{
    Grains<D>& g = solver.grains();
    for (std::size_t i = 0; i < g.size(); ++i)
        g.external[i] = {(-rate * g.mass[i]) * g.motion[i].velocity, (-rate * g.inertia[i]) * g.motion[i].spin};
    solver.step(dt);
}

//! Steps until the kinetic ratio has been below `enough` at `checks` checks in a row; at most until `limit` [s] more.
template <int D>
double run_until(Solver<D>& solver, Config const& config, Progress const& progress, char const* stage, double dt,
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

template <int D>
Packing<D> pour_packing(Config const& config, Progress const& progress)
{
    Config dry = config;  // buoyancy, gates and moving walls belong to the run
    dry.fluid_density = 0.0;
    dry.gravity = settling_gravity(config);
    dry.gravity_ramp = 0.0;
    dry.scheme = Scheme::predicted;
    dry.loads = true;  // the drag
    for (WallConfig& wall : dry.walls) {
        wall.removed_at = std::numeric_limits<double>::infinity();
        wall.motion = {};
    }
    ContactConfig const& c = dry.contact;
    Setup<D> setup = make_setup<D>(dry);
    setup.features.friction = true;
    auto const soft_with = [&](double friction) {
        ContactConfig soft = c;
        soft.damping_ratio = std::max(c.damping_ratio, pouring_damping);
        soft.tangential_damping = pouring_damping;
        soft.friction = friction;
        soft.may_pull = false;
        Setup<D> all = setup;
        all.law = contact_law(soft);
        for (Wall<D>& wall : all.walls) wall.law = all.law;
        return all;
    };
    double const pi = std::numbers::pi, gravity = norm(dry.gravity), width = column_width(dry);
    auto const mass = [&](double d) { return dry.density * (D == 2 ? pi / 4.0 * d * d : pi / 6.0 * d * d * d); };
    double const height = width * dry.column->aspect_ratio, fall = std::sqrt(height / gravity);  // [s]
    double const step = contact_time_of(c, D, mass(dry.diameter_min), 0.5 * dry.diameter_min);
    // a sound wave through the column [s]; t_c = pi sqrt(m*/k) of the smallest grains is a measure of stiffness
    double const wave =
        height / dry.diameter_min * std::sqrt(2.0 * mass(dry.diameter_max) / mass(dry.diameter_min)) * step / pi;

    Solver<D> solver(setup, loose_grains<D>(dry, setup));
    solver.set_laws(soft_with(dry.column->packing_friction));
    run_until(solver, dry, progress, "pouring", step / 20.0, 2.0 / fall, 1e-4, 3, 20.0 * fall);
    double ratio = 1.0;
    for (int round = 0; round < longest_hold && ratio > settled_kinetic_ratio; ++round) {
        solver.set_laws(soft_with(c.friction));
        run_until(solver, dry, progress, "relaxing", step / 20.0, 1.0 / wave, 0.01 * settled_kinetic_ratio, 2,
                  200.0 * wave);
        solver.set_laws(setup);
        ratio = run_until(solver, dry, progress, "holding", step / 50.0, 0.0, settled_kinetic_ratio, 5, 40.0 * wave);
    }
    if (ratio > settled_kinetic_ratio) say(progress, "NOT settled (needed: 1e-8)", solver.time(), ratio);
    return {solver.grains().place, records_of(solver.state()), ratio};
}

template <int D>
Packing<D> prepare_packing(Config const& config, std::filesystem::path const& cache, Progress const& progress)
{
    if (!config.column) return {};
    std::filesystem::path const file = cache / packing_file_name(config);
    if (!cache.empty()) {
        std::string damage;
        if (auto packing = load_packing<D>(file, damage)) return std::move(*packing);
        if (!damage.empty() && progress) progress(damage);
    }
    Packing<D> packing = pour_packing<D>(config, progress);
    if (!cache.empty()) write_packing(packing, file);
    return packing;
}

template Packing<2> pour_packing<2>(Config const&, Progress const&);
template Packing<3> pour_packing<3>(Config const&, Progress const&);
template Packing<2> prepare_packing<2>(Config const&, std::filesystem::path const&, Progress const&);
template Packing<3> prepare_packing<3>(Config const&, std::filesystem::path const&, Progress const&);

}  // namespace dem
