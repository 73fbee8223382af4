#include "participants/lbm/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "coupler/scene/reader.hpp"
#include "coupler/scene/threads.hpp"

namespace lbm {
namespace {

constexpr double sound_speed_lu = 0.57735026918962576;  //!< 1/sqrt(3) cells a step
constexpr double mach_refused = 0.3, mach_warned = 0.15;
constexpr double tau_warned = 0.505;
constexpr double tau_slow = 2.0;  //!< beyond, the lattice is accurate for Stokes flow alone
constexpr double flux_rate_with_les =
    1.2;  //!< s_q, see README.md: with magic = 3/16 vortices grow without bound at tau 0.506
constexpr double grid_reynolds_warned = 15;  //!< U dx/nu; D2Q9 MRT without les is known to ring beyond

template <class... Value>
std::string format(char const* pattern, Value... value)
{
    char text[300];
    std::snprintf(text, sizeof text, pattern, value...);
    return text;
}

double mach(Config const& c)
{
    return c.max_velocity / c.units().velocity_unit() / sound_speed_lu;
}

double grid_reynolds(Config const& c)
{
    return c.max_velocity * c.cell / c.viscosity;
}

Wall read_wall(sluice::Reader& walls, char const* side)
{
    if (walls.has(side) && !walls.is_scalar(side)) {
        sluice::Reader moving = walls.child(side);
        Wall const wall{.periodic = false, .velocity = moving.number("velocity", {.unit = "m/s"})};
        moving.finish();
        return wall;
    }
    return {.periodic = walls.choice_or(side, 0, {"no_slip", "periodic"}) == 1, .velocity = 0};
}

void read_walls(sluice::Reader& reader, Config& c)
{
    std::optional<sluice::Reader> walls = reader.child_if("walls");
    if (!walls) return;
    char const* const names[] = {"left", "right", "bottom", "top"};
    for (std::size_t s = 0; s < 4; ++s) c.walls[s] = read_wall(*walls, names[s]);
    walls->finish();
}

void read_collision(sluice::Reader& r, Config& c)
{
    c.collision = static_cast<Operator>(r.choice_or("operator", 0, {"mrt", "trt", "bgk"}));
    if (c.collision != Operator::bgk) c.magic = r.number_or("magic", c.magic, {.above = 0.0});
    if (c.collision == Operator::mrt) {
        if (std::optional<sluice::Reader> rates = r.child_if("rates")) {
            sluice::Bounds const stable{.above = 0.0, .below = 2.0, .unit = "1/step"};
            c.energy_rate = rates->number_or("energy", c.energy_rate, stable);
            c.square_rate = rates->number_or("square", c.square_rate, stable);
            c.flux_rate = rates->number_if("flux", stable);
            rates->finish();
        }
    }
    c.smagorinsky = r.number_if("les", {.above = 0.0, .max = 0.5}).value_or(0.0);
    bool const odd_rate_given = r.has("magic") || c.flux_rate;
    if (c.collision == Operator::mrt && c.smagorinsky > 0 && !odd_rate_given) c.flux_rate = flux_rate_with_les;
}

void read_step(sluice::Reader& r, Config& c)
{
    if (r.has("step")) {
        c.step = r.number("step", {.above = 0.0, .unit = "s"});
        c.max_velocity = r.number_or("max_velocity", 0.0, {.min = 0.0, .unit = "m/s"});
    } else {
        c.max_velocity = r.number("max_velocity", {.above = 0.0, .unit = "m/s"});
        double const lattice_velocity = r.number_or("lattice_velocity", 0.05, {.above = 0.0, .unit = "cells a step"});
        c.step = lattice_velocity * c.cell / c.max_velocity;
    }
}

std::string with_unit(double value, char const* unit)
{
    return format("%g %s", value, unit);
}

void find_geometry_issues(Config const& c, std::vector<Issue>& issues)
{
    char const* const axis[] = {"x", "y"};
    for (std::size_t k = 0; k < 2; ++k) {
        double const cells = c.size[k] / c.cell;
        if (!(c.size[k] > 0) || std::abs(cells - std::round(cells)) > 1e-6 * std::round(cells)) {
            double const whole = std::max(1.0, std::round(cells)) * c.cell;
            issues.push_back({"domain.size",
                              format("%g m in %s is %.6g cells of %g m (must be a whole number). Take %.9g m.",
                                     c.size[k], axis[k], cells, c.cell, whole),
                              true});
        } else if (cells > 1e6) {
            issues.push_back(
                {"cell", format("%g m makes %.3g cells in %s (at most 1e6).", c.cell, cells, axis[k]), true});
        }
    }
    if (c.walls[left].periodic != c.walls[right].periodic)
        issues.push_back({"walls", "left and right differ (periodic must be both or neither).", true});
    if (c.walls[bottom].periodic != c.walls[top].periodic)
        issues.push_back({"walls", "bottom and top differ (periodic must be both or neither).", true});
}

void find_flow_issues(Config const& c, std::vector<Issue>& issues)
{
    double const tau = c.relaxation_time();
    if (!(tau > 0.5) || !std::isfinite(tau))
        issues.push_back(
            {"viscosity", format("%g m2/s makes tau = %.9g (must be above 0.5).", c.viscosity, tau), true});
    else if (tau < tau_warned && c.smagorinsky == 0)
        issues.push_back({"viscosity",
                          format("%g m2/s makes tau = %.6g, near the limit 0.5. Take a smaller cell, or les: 0.1.",
                                 c.viscosity, tau),
                          false});
    else if (tau > tau_slow)
        issues.push_back(
            {"step",
             format("%g s makes tau = %.4g (above 2 only slow flow is accurate). Take a shorter step.", c.step, tau),
             false});
    double fastest = c.max_velocity;
    for (Wall const& w : c.walls) fastest = std::max(fastest, std::abs(w.velocity));
    double const number = fastest / c.units().velocity_unit() / sound_speed_lu;
    if (number > mach_refused)
        issues.push_back({"step",
                          format("%g s makes the Mach number %.3g at %g m/s (at most 0.3). Take at most %.3g s.",
                                 c.step, number, fastest, c.step * mach_refused / number),
                          true});
    else if (number > mach_warned)
        issues.push_back({"step",
                          format("%g s makes the Mach number %.3g: errors of its square, %.1f %%.", c.step, number,
                                 100 * number * number),
                          false});
    if (grid_reynolds(c) > grid_reynolds_warned && c.smagorinsky == 0)
        issues.push_back({"cell",
                          format("%g m makes the grid Reynolds number %.3g. Take a smaller cell, or les: 0.1.", c.cell,
                                 grid_reynolds(c)),
                          false});
}

}  // namespace

std::array<std::ptrdiff_t, 2> Config::cells() const noexcept
{
    return {std::lround(size[0] / cell), std::lround(size[1] / cell)};
}

std::vector<Issue> find_issues(Config const& c)
{
    if (!(c.cell > 0) || !(c.step > 0) || !(c.density > 0) || !(c.viscosity > 0) || !(c.hydrodynamic_radius > 0))
        return {{"cell, step, density, viscosity, hydrodynamic_radius", "one of them is not positive (must be > 0).",
                 true}};
    std::vector<Issue> issues;
    find_geometry_issues(c, issues);
    find_flow_issues(c, issues);
    if (c.threads < 1) issues.push_back({"threads", format("%d (must be at least 1).", c.threads), true});
    return issues;
}

std::vector<std::string> describe(Config const& c)
{
    auto const [nx, ny] = c.cells();
    char const* const names[] = {"MRT", "TRT", "BGK"};
    std::string model = names[static_cast<int>(c.collision)];
    if (c.smagorinsky > 0) model += format(" with Smagorinsky, C_s = %g", c.smagorinsky);
    return {format("lattice               %td x %td cells of %g m, D2Q9, ", nx, ny, c.cell) + model,
            "time step             " + with_unit(c.step, "s"),
            format("relaxation time       tau = %.6g (limit 0.5)", c.relaxation_time()),
            format("Mach number           %.3g at %g m/s (limit 0.3)", mach(c), c.max_velocity),
            format("grid Reynolds number  %.3g", grid_reynolds(c)),
            "sound speed           " + with_unit(sound_speed_lu * c.units().velocity_unit(), "m/s"),
            format("hydrodynamic radius   %g R", c.hydrodynamic_radius),
            format("threads               %d", c.threads)};
}

Config read_config(sluice::Reader& r, std::array<double, 2> gravity)
{
    Config c;
    sluice::Reader domain = r.child("domain");
    auto const origin = domain.numbers_or("origin", {0.0, 0.0}, {.unit = "m"});
    auto const size = domain.numbers("size", 2, {.above = 0.0, .unit = "m"});
    domain.finish();
    if (origin.size() == 2) c.origin = {origin[0], origin[1]};
    if (size.size() == 2) c.size = {size[0], size[1]};
    c.cell = r.number("cell", {.above = 0.0, .unit = "m"});
    c.density = r.number_or("density", c.density, {.above = 0.0, .unit = "kg/m3"});
    c.viscosity = r.number_or("viscosity", c.viscosity, {.above = 0.0, .unit = "m2/s"});
    read_step(r, c);
    read_collision(r, c);
    read_walls(r, c);
    auto const push = r.numbers_or("acceleration", {0.0, 0.0}, {.unit = "m/s2"});
    if (push.size() == 2) c.acceleration = {push[0], push[1]};
    if (r.flag_or("gravity", false)) {
        c.acceleration[0] += gravity[0];
        c.acceleration[1] += gravity[1];
    }
    c.hydrodynamic_radius = r.number_or("hydrodynamic_radius", 0.85, {.above = 0.0, .max = 1.0});
    c.threads = sluice::read_threads(r, "auto");
    bool const readable =
        c.cell > 0 && c.step > 0 && std::isfinite(c.step) && c.size[0] > 0 && c.viscosity > 0 && c.density > 0;
    if (readable)
        for (Issue const& issue : find_issues(c))
            if (issue.refused) r.problem(issue.key.substr(0, issue.key.find('.')), issue.text);
    r.finish();
    return c;
}

}  // namespace lbm
