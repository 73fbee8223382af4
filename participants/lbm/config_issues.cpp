// What a Config is that cannot run, or that should not; and what it says of itself at the start.
#include <algorithm>
#include <array>
#include <cmath>

#include "coupler/base/format.hpp"
#include "coupler/scene/side_names.hpp"
#include "participants/lbm/config.hpp"

namespace lbm {
namespace {

using sluice::format;

constexpr double least_grain = 0.1;                     //!< of the fluid's density (README, Light grains)
constexpr double sound_speed_lu = 0.57735026918962576;  //!< 1/sqrt(3) cells a step
constexpr double mach_refused = 0.3, mach_warned = 0.15;
constexpr double tau_warned = 0.505;
constexpr double tau_slow = 2.0;             //!< beyond, the lattice is accurate for Stokes flow alone
constexpr double grid_reynolds_warned = 15;  //!< U dx/nu; D2Q9 MRT without les is known to ring beyond

double mach(Config const& c)
{
    return c.max_velocity / c.units().velocity_unit() / sound_speed_lu;
}

double grid_reynolds(Config const& c)
{
    return c.max_velocity * c.cell / c.viscosity;
}

std::string with_unit(double value, char const* unit)
{
    return format("%g %s", value, unit);
}

void find_geometry_issues(Config const& c, std::vector<Issue>& issues)
{
    char const* const axis[] = {"x", "y", "z"};
    for (std::size_t k = 0; k < c.axes(); ++k) {
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
}

void find_side_issues(Config const& c, std::vector<Issue>& issues)
{
    bool inflow = false, outlet = false;
    for (std::size_t s = 0; s < 2 * c.axes(); ++s) {
        bool const in = c.walls[s].kind == Border::inflow, out = c.walls[s].kind == Border::pressure;
        inflow = inflow || in;
        outlet = outlet || out;
        if (c.rotation && (in || out))
            issues.push_back({"walls",
                              format("%s is open in a frame that turns (must be a wall, free_slip or periodic).",
                                     sluice::side_name(c.dimension, s)),
                              true});
        if (s % 2 == 1 || (c.walls[s].kind == Border::periodic) == (c.walls[s + 1].kind == Border::periodic)) continue;
        issues.push_back({"walls",
                          format("%s and %s differ (periodic must be both or neither).",
                                 sluice::side_name(c.dimension, s), sluice::side_name(c.dimension, s + 1)),
                          true});
    }
    if (inflow && !outlet)
        issues.push_back({"walls",
                          "an inflow, and nowhere to go (needs a side with a pressure). Write e.g. right: {pressure: "
                          "0}.",
                          true});
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
    for (Wall const& wall : c.walls)
        fastest = std::max(fastest, std::hypot(wall.velocity[0], wall.velocity[1], wall.velocity[2]));
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

void find_surface_issues(Config const& c, std::vector<Issue>& issues)
{
    if (c.lightest_grain > 0 && c.surface != Surface::interpolated)
        issues.push_back(
            {"lightest_grain",
             format("%g kg/m3, with fluid kept inside grains (the coupling of light ones is unstable then). "
                    "Try grains: interpolated.",
                    c.lightest_grain),
             true});
    if (c.lightest_grain > 0 && c.lightest_grain < least_grain * c.density)
        issues.push_back({"lightest_grain",
                          format("%g kg/m3 is %.2g of the fluid's density: the coupling was tried down to %g of it.",
                                 c.lightest_grain, c.lightest_grain / c.density, least_grain),
                          false});
    if (c.surface != Surface::interpolated) return;
    if (c.rotation)
        issues.push_back({"grains",
                          "interpolated, in a frame that turns (known for covered ones only). Try grains: "
                          "covered.",
                          true});
    for (std::size_t s = 0; s < 2 * c.axes(); ++s)
        if (c.walls[s].kind == Border::slip)
            issues.push_back({"grains",
                              "interpolated, with a side without friction (what it mirrors into a grain would be "
                              "lost). Try grains: covered, or a wall.",
                              true});
    if (c.phase)
        issues.push_back({"grains",
                          "interpolated, beside solids finer than a cell (known for covered ones only). Try "
                          "grains: covered.",
                          true});
}

void find_phase_issues(Config const& c, std::vector<Issue>& issues)
{
    if (!c.phase) return;
    if (!(c.phase->diameter > 0) || !(c.phase->solid_density > (c.phase->matter ? c.density : 0)))
        issues.push_back(
            {"phase",
             format("grains of %g m and %g kg/m3 (must be > 0; a continuum of them heavier than the fluid, "
                    "%g kg/m3).",
                    c.phase->diameter, c.phase->solid_density, c.density),
             true});
    auto const cells = c.cells();
    for (std::size_t k = 0; k < c.axes(); ++k)
        if (c.phase->spread > cells[k])
            issues.push_back(
                {"phase.spread",
                 format("%d cells in a domain of %td along %c (at most as many).", c.phase->spread, cells[k], "xyz"[k]),
                 true});
    if (c.phase->diameter > c.cell)
        issues.push_back(
            {"phase.diameter",
             format("%g m is more than a cell of %g m (a law of drag stands for many grains). Take a larger "
                    "cell, or resolve the grains.",
                    c.phase->diameter, c.cell),
             false});
}

}  // namespace

std::vector<Issue> find_issues(Config const& c)
{
    if (!(c.cell > 0) || !(c.step > 0) || !(c.density > 0) || !(c.viscosity > 0) || !(c.hydrodynamic_radius > 0))
        return {{"cell, step, density, viscosity, hydrodynamic_radius", "one of them is not positive (must be > 0).",
                 true}};
    std::vector<Issue> issues;
    find_geometry_issues(c, issues);
    find_side_issues(c, issues);
    find_flow_issues(c, issues);
    find_phase_issues(c, issues);
    find_surface_issues(c, issues);
    if (c.threads < 1) issues.push_back({"threads", format("%d (must be at least 1).", c.threads), true});
    return issues;
}

std::vector<std::string> describe(Config const& c)
{
    auto const [nx, ny, nz] = c.cells();
    std::string const lattice = c.dimension == 2 ? format("%td x %td cells of %g m, D2Q9, ", nx, ny, c.cell)
                                                 : format("%td x %td x %td cells of %g m, D3Q19, ", nx, ny, nz, c.cell);
    char const* const names[] = {"MRT", "TRT", "BGK", "central moments"};
    std::string model = names[static_cast<int>(c.collision)];
    if (c.smagorinsky > 0) model += format(" with Smagorinsky, C_s = %g", c.smagorinsky);
    constexpr std::array surfaces{"cover cells in part", "interpolated surfaces", "direct forcing"};
    std::vector<std::string> lines{
        "lattice               " + lattice + model,
        "time step             " + with_unit(c.step, "s"),
        format("relaxation time       tau = %.6g (limit 0.5)", c.relaxation_time()),
        format("Mach number           %.3g at %g m/s (limit 0.3)", mach(c), c.max_velocity),
        format("grid Reynolds number  %.3g", grid_reynolds(c)),
        c.precision == Precision::float64 ? "populations           double precision"
                                          : "populations           single precision",
        "sound speed           " + with_unit(sound_speed_lu * c.units().velocity_unit(), "m/s"),
        format("hydrodynamic radius   %g R", c.hydrodynamic_radius),
        std::string("moving grains         ") + surfaces[static_cast<std::size_t>(c.surface)],
        c.rotation ? format("frame                 turns at %g rad/s%s", c.rotation->rate,
                            c.hydrostatic ? "" : "; its field as gravity's: not on the lattice")
                   : "frame                 inertial",
        format("threads               %d", c.threads)};
    if (c.phase)
        lines.push_back("bulk modulus          " + with_unit(c.units().pressure_unit() / 3, "Pa") +
                        ", of the fluid in pores: rho_0 c_s^2");
    return lines;
}

}  // namespace lbm
