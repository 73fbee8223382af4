#include "participants/dem/packing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

#include "participants/dem/packing_file.hpp"
#include "participants/dem/packing_start.hpp"
#include "participants/dem/setup.hpp"
#include "participants/dem/solver.hpp"

//! Three stages, each a few numbers:
//!   pour   grains fall from a loose state (poured columns only); friction of the packing, strong dashpots, a
//!   background drag whose
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

//! Kinetic energy over sum m g d_mean [-].
template <int D>
double kinetic_ratio(Solver<D> const& solver, Config const& config)
{
    Grains<D> const& g = solver.grains();
    double mass = 0.0;
    for (double const m : g.mass) mass += m;
    return kinetic_energy(g) / (mass * norm(config.gravity) * config.sizes.moment(1));
}

//! How long a stage lasts.
struct Patience
{
    double enough;  //!< the kinetic ratio that it must be below [-]
    int checks;     //!< at so many checks in a row
    double every;   //!< between checks [s]
    double limit;   //!< the longest [s]
};

template <int D>
double run_until(Solver<D>& solver, Config const& config, Progress const& progress, char const* stage, double dt,
                 double drag, Patience const& until)
{
    auto const [enough, checks, every, limit] = until;
    double const end = solver.time() + limit;
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

//! The loose state that a column is poured from.
template <int D>
Grains<D> to_be_poured(Config const& config, Setup<D> const& setup)
{
    return is_scattered(config) ? scattered(config, setup, scattered_fraction(D)) : loose_grid(config, setup);
}

template <int D>
Grains<D> start_of(Config const& config, Setup<D> const& setup, Progress const& progress)
{
    switch (config.column->preparation) {
        case Preparation::random:
            return grown(config, setup, progress);
        case Preparation::regular:
            return lattice(config, setup);
        case Preparation::poured:
            break;
    }
    return to_be_poured(config, setup);
}

//! What the stages take from the scene.
struct Times
{
    double step;  //!< t_c of the smallest grains [s]
    double fall;  //!< through the column under the first stage's gravity [s]
    double wave;  //!< of sound through the column [s]; t_c = pi sqrt(m*/k) is a measure of stiffness
};

template <int D>
Times times_of(Config const& dry, double gravity)
{
    double const pi = std::numbers::pi, width = column_width(dry);
    auto const mass = [&](double d) { return dry.density * (D == 2 ? pi / 4.0 * d * d : pi / 6.0 * d * d * d); };
    double const height = width * dry.column->aspect_ratio, fall = std::sqrt(height / gravity);  // [s]
    double const step = contact_time_of(dry.contact, D, mass(dry.diameter_min), 0.5 * dry.diameter_min);
    double const wave =
        height / dry.diameter_min * std::sqrt(2.0 * mass(dry.diameter_max) / mass(dry.diameter_min)) * step / pi;
    return {step, fall, wave};
}

}  // namespace

template <int D>
Packing<D> pour_packing(Config const& config, Progress const& progress)
{
    Config dry = config;  // the fluid, gates, moving walls and sleep belong to the run
    dry.fluid_density = 0.0;
    dry.lubrication = {};
    dry.sleep = {};
    dry.gravity = settling_gravity(config);
    dry.gravity_ramp = 0.0;
    dry.rotation.reset();
    dry.scheme = Scheme::predicted;
    dry.loads = true;  // the drag
    for (WallConfig& wall : dry.walls) {
        wall.removed_at = std::numeric_limits<double>::infinity();
        wall.motion = {};
    }
    ContactConfig const& c = dry.contact;
    ColumnConfig const& column = *dry.column;
    Setup<D> setup = make_setup<D>(dry);
    setup.features.friction = true;
    double const own = norm(dry.gravity);  // [m/s2]
    if (own == 0.0) return {start_of(dry, setup, progress).place, {}, 0.0};
    double const share = column.pouring_gravity > 0.0 ? column.pouring_gravity / own : 1.0;  // of it, at first
    auto const soft_with = [&](double friction, double part) {
        ContactConfig soft = c;
        soft.damping_ratio = std::max(c.damping_ratio, pouring_damping);
        soft.tangential_damping = pouring_damping;
        soft.friction = friction;
        soft.may_pull = false;
        Setup<D> all = setup;
        all.gravity = part * setup.gravity;
        all.law = contact_law(soft);
        for (Wall<D>& wall : all.walls) wall.law = all.law;
        return all;
    };
    auto const in_frame = [&](Setup<D> all) {  // that of the run's begin; poured under what it is at the foot
        if (!config.rotation || config.rotation->ramp > 0.0) return all;
        all.gravity = to_dimension<D>(starting_gravity(config));
        all.frame.emplace(*config.rotation);
        return all;
    };
    Config at_first = dry;
    at_first.gravity = share * dry.gravity;
    auto const [step, fall, wave] = times_of<D>(dry, share * own);

    Solver<D> solver(setup, start_of(dry, setup, progress));
    if (column.preparation == Preparation::poured) {
        solver.set_laws(soft_with(column.packing_friction, share));
        run_until(solver, at_first, progress, "pouring", step / 20.0, 2.0 / fall, {1e-4, 3, 0.2 * fall, 20.0 * fall});
    }
    if (column.pouring_gravity > 0.0) {
        solver.set_laws(soft_with(c.friction, share));
        run_until(solver, at_first, progress, "resting under its first weight", step / 20.0, 1.0 / wave,
                  {0.01 * settled_kinetic_ratio, 2, 2.0 * wave, 200.0 * wave});
    }
    // what the drag has let down slowly falls in earnest only now: as long as from the top to the floor
    double const own_fall = fall * std::sqrt(share);
    double ratio = 1.0;
    for (int round = 0; round < longest_hold && ratio > settled_kinetic_ratio; ++round) {
        solver.set_laws(in_frame(soft_with(c.friction, 1.0)));
        run_until(solver, dry, progress, "relaxing", step / 20.0, 1.0 / wave,
                  {0.01 * settled_kinetic_ratio, 2, 2.0 * wave, 60.0 * wave});
        solver.set_laws(in_frame(setup));
        ratio = run_until(solver, dry, progress, "holding", step / 50.0, 0.0,
                          {settled_kinetic_ratio, 5, 0.4 * wave, 40.0 * wave + 2.0 * own_fall});
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
