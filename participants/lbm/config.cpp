#include "participants/lbm/config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "coupler/base/error.hpp"
#include "coupler/scene/beside_scene.hpp"
#include "coupler/scene/reader.hpp"
#include "coupler/scene/side_names.hpp"
#include "coupler/scene/threads.hpp"
#include "participants/lbm/mesh_solid.hpp"

namespace lbm {
namespace {

constexpr double least_grain = 0.1;                     //!< of the fluid's density (README, Light grains)
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

//! `velocity`: in the plane along the side, +x or +y; in space a vector along it.
void read_moving(sluice::Reader& side, std::size_t axis, int dimension, Wall& wall)
{
    if (dimension == 2) {
        wall.velocity[1 - axis] = side.number("velocity", {.unit = "m/s"});
    } else if (auto const v = side.numbers("velocity", 3, {.unit = "m/s"}); v.size() == 3) {
        std::copy(v.begin(), v.end(), wall.velocity.begin());
        if (v[axis] != 0.0)
            side.problem("velocity",
                         format("%g m/s across the wall (must be 0: walls move along themselves).", v[axis]));
    }
}

//! `inflow`: across the side, into the domain, or a vector.
void read_inflow(sluice::Reader& side, Side which, int dimension, Wall& wall)
{
    std::size_t const axis = which / 2;
    wall.kind = Border::inflow;
    if (side.is_list("inflow")) {
        auto const v = side.numbers("inflow", static_cast<std::size_t>(dimension), {.unit = "m/s"});
        std::copy(v.begin(), v.end(), wall.velocity.begin());
    } else {
        wall.velocity[axis] = (which % 2 == 0 ? 1 : -1) * side.number("inflow", {.unit = "m/s"});
    }
    wall.parabola = side.choice_or("profile", 0, {"uniform", "parabola"}) == 1;
    wall.ramp = side.number_or("ramp", 0.0, {.min = 0.0, .unit = "s"});
}

Wall read_wall(sluice::Reader& walls, Side which, int dimension)
{
    char const* const name = sluice::side_name(dimension, which);
    Wall wall;
    if (!walls.has(name) || walls.is_scalar(name)) {
        constexpr Border kinds[] = {Border::wall, Border::periodic, Border::slip};
        wall.kind = kinds[walls.choice_or(name, 0, {"no_slip", "periodic", "free_slip"})];
        return wall;
    }
    sluice::Reader side = walls.child(name);
    if (side.has("inflow")) {
        read_inflow(side, which, dimension, wall);
    } else if (side.has("pressure")) {
        wall.kind = Border::pressure;
        wall.pressure = side.number("pressure", {.unit = "Pa"});
        wall.absorbing = side.flag_or("absorbing", false);
    } else {
        read_moving(side, which / 2, dimension, wall);
    }
    side.finish();
    return wall;
}

void read_walls(sluice::Reader& reader, Config& c)
{
    std::optional<sluice::Reader> walls = reader.child_if("walls");
    if (!walls) return;
    for (std::size_t s = 0; s < 2 * c.axes(); ++s) c.walls[s] = read_wall(*walls, static_cast<Side>(s), c.dimension);
    walls->finish();
}

//! A closed surface from a file, metres; centre and size of the box about it.
void read_mesh(sluice::Reader r, Solid& solid)
{
    solid.shape = Solid::Shape::mesh;
    std::filesystem::path const file = r.text("file");
    double const scale = r.number_or("scale", 1.0, {.above = 0.0, .max = 1e6, .unit = "m"});
    r.finish();
    if (file.empty()) return;
    try {
        solid.surface = files::read_stl(sluice::beside_scene(r, file));
    } catch (sluice::Error const& e) {
        r.refuse("file", std::string("cannot be used: ") + e.what());
        return;
    }
    if (auto const open = open_edges(solid.surface); !open.empty()) r.problem("file", file.string() + " " + open);
    std::array<double, 3> low, high;
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (files::Triangle& t : solid.surface)
        for (files::Point& corner : t)
            for (std::size_t k = 0; k < 3; ++k) {
                corner[k] *= scale;
                low[k] = std::min(low[k], corner[k]);
                high[k] = std::max(high[k], corner[k]);
            }
    for (std::size_t k = 0; k < 3; ++k) {
        solid.centre[k] = 0.5 * (low[k] + high[k]);
        solid.size[k] = high[k] - low[k];
    }
}

Solid read_solid(sluice::Reader& reader, std::size_t index, int dimension)
{
    auto const axes = static_cast<std::size_t>(dimension);
    Solid solid;
    solid.name = reader.word_or("name", "solid_" + std::to_string(index));
    auto const vector = [&](sluice::Reader& r, char const* key) {
        std::array<double, 3> v{};
        auto const numbers = r.numbers(key, axes, {.unit = "m"});
        std::copy(numbers.begin(), numbers.end(), v.begin());
        return v;
    };
    char const* const round = dimension == 2 ? "disc" : "sphere";
    if (auto box = reader.child_if("box")) {
        solid.shape = Solid::Shape::box;
        auto const low = vector(*box, "low"), high = vector(*box, "high");
        for (std::size_t k = 0; k < axes; ++k) {
            solid.centre[k] = 0.5 * (low[k] + high[k]);
            solid.size[k] = high[k] - low[k];
            if (!(solid.size[k] > 0))
                box->problem("high", format("is %g m along %c, not above low, %g m.", high[k], "xyz"[k], low[k]));
        }
        box->finish();
    } else if (auto cylinder = dimension == 3 ? reader.child_if("cylinder") : std::nullopt) {
        solid.shape = Solid::Shape::cylinder;
        solid.centre = vector(*cylinder, "point");
        solid.axis = cylinder->choice("axis", {"x", "y", "z"});
        solid.radius = cylinder->number("radius", {.above = 0.0, .unit = "m"});
        cylinder->finish();
    } else if (auto mesh = dimension == 3 ? reader.child_if("mesh") : std::nullopt) {
        read_mesh(*mesh, solid);
    } else {
        sluice::Reader ball = reader.child(round);
        solid.centre = vector(ball, "centre");
        solid.radius = ball.number("radius", {.above = 0.0, .unit = "m"});
        ball.finish();
    }
    reader.finish();
    return solid;
}

//! An axis along which a solid lies wholly beyond the domain.
std::optional<std::size_t> axis_beyond(Solid const& solid, Config const& c)
{
    for (std::size_t k = 0; k < c.axes(); ++k) {
        if (solid.shape == Solid::Shape::cylinder && solid.axis == k) continue;
        bool const boxed = solid.shape == Solid::Shape::box || solid.shape == Solid::Shape::mesh;
        double const half = boxed ? 0.5 * solid.size[k] : solid.radius;
        if (solid.centre[k] + half <= c.origin[k] || solid.centre[k] - half >= c.origin[k] + c.size[k]) return k;
    }
    return {};
}

void read_solids(sluice::Reader& reader, Config& c)
{
    for (sluice::Reader& solid : reader.list("solids")) {
        c.solids.push_back(read_solid(solid, c.solids.size(), c.dimension));
        if (auto const k = axis_beyond(c.solids.back(), c))
            solid.problem(
                "name",
                format("%s lies outside the domain, which goes from %g to %g m along %c (a part of it must be within).",
                       c.solids.back().name.c_str(), c.origin[*k], c.origin[*k] + c.size[*k], "xyz"[*k]));
        for (std::size_t k = 0; k + 1 < c.solids.size(); ++k)
            if (c.solids[k].name == c.solids.back().name)
                solid.problem("name", c.solids[k].name + " is there twice (names of solids must differ).");
    }
}

void read_collision(sluice::Reader& r, Config& c)
{
    c.collision = static_cast<Operator>(
        r.choice_or("operator", c.dimension == 2 || r.has("les") ? 0 : 1, {"mrt", "trt", "bgk", "central"}));
    if (c.collision == Operator::mrt || c.collision == Operator::trt)
        c.magic = r.number_or("magic", c.magic, {.above = 0.0});
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

void read_phase(sluice::Reader& r, Config& c, bool sent)
{
    std::optional<sluice::Reader> block = r.child_if("phase");
    if (!block) {
        if (sent)
            r.problem(
                "phase",
                "is missing (a partner sends solids finer than a cell: needs their law of drag). Try phase: {drag: "
                "ergun, diameter: 1.0e-3, solid_density: 2650}.");
        return;
    }
    PhaseConfig phase;
    constexpr Drag laws[] = {Drag::ergun, Drag::carman_kozeny, Drag::di_felice};
    phase.law = laws[block->choice("drag", {"ergun", "carman_kozeny", "di_felice"})];
    phase.diameter = block->number("diameter", {.above = 0.0, .unit = "m"});
    phase.matter = block->choice_or("points", 0, {"matter", "grains"}) == 0;
    phase.solid_density = block->number("solid_density", {.above = phase.matter ? c.density : 0.0, .unit = "kg/m3"});
    phase.spread = static_cast<int>(block->integer_or("spread", phase.spread, {.min = 1, .max = 8}));
    block->finish();
    if (!sent) r.problem("phase", "stands here, but nobody sends one (needs an edge with data: phase to this fluid).");
    c.phase = phase;
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

std::array<std::ptrdiff_t, 3> Config::cells() const noexcept
{
    return {std::lround(size[0] / cell), std::lround(size[1] / cell), dimension == 2 ? 1 : std::lround(size[2] / cell)};
}

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

Config read_config(sluice::Reader& r, int dimension, std::array<double, 3> gravity,
                   std::optional<sluice::Rotation> const& rotation, bool phase, int processes)
{
    Config c;
    c.rotation = rotation;
    c.dimension = dimension;
    std::vector<double> const zero(c.axes(), 0.0);
    sluice::Reader domain = r.child("domain");
    auto const origin = domain.numbers_or("origin", zero, {.unit = "m"});
    auto const size = domain.numbers("size", c.axes(), {.above = 0.0, .unit = "m"});
    domain.finish();
    auto const take = [&](std::vector<double> const& from, std::array<double, 3>& to) {
        if (from.size() == c.axes()) std::copy(from.begin(), from.end(), to.begin());
    };
    take(origin, c.origin);
    take(size, c.size);
    c.cell = r.number("cell", {.above = 0.0, .unit = "m"});
    c.density = r.number_or("density", c.density, {.above = 0.0, .unit = "kg/m3"});
    c.viscosity = r.number_or("viscosity", c.viscosity, {.above = 0.0, .unit = "m2/s"});
    read_step(r, c);
    read_collision(r, c);
    read_walls(r, c);
    read_solids(r, c);
    c.output = read_output(r, dimension, c.origin, c.size);
    take(r.numbers_or("acceleration", zero, {.unit = "m/s2"}), c.acceleration);
    if (auto block = r.child_if("oscillation")) {
        Oscillation oscillation;
        take(block->numbers("amplitude", c.axes(), {.unit = "m/s2"}), oscillation.amplitude);
        // ten steps a period: an explicit scheme resolves no less
        oscillation.frequency = block->number("frequency", {.above = 0.0, .max = 0.1 / c.step, .unit = "Hz"});
        block->finish();
        c.oscillation = oscillation;
    }
    c.hydrostatic = r.flag_or("gravity", false);
    if (c.hydrostatic)
        for (std::size_t k = 0; k < c.axes(); ++k) c.acceleration[k] += gravity[k];
    c.hydrodynamic_radius = r.number_or("hydrodynamic_radius", 0.85, {.above = 0.0, .max = 1.0});
    read_phase(r, c, phase);
    c.surface = static_cast<Surface>(r.choice_or("grains", 0, {"covered", "interpolated", "forced"}));
    c.lightest_grain = r.number_or("lightest_grain", 0, {.min = 0.0, .unit = "kg/m3"});
    c.precision = static_cast<Precision>(r.choice_or("precision", 0, {"double", "single"}));
    c.threads = sluice::read_threads(r, "auto", processes);
    bool const readable =
        c.cell > 0 && c.step > 0 && std::isfinite(c.step) && c.size[0] > 0 && c.viscosity > 0 && c.density > 0;
    if (readable)
        for (Issue const& issue : find_issues(c))
            if (issue.refused) r.problem(issue.key.substr(0, issue.key.find('.')), issue.text);
    r.finish();
    return c;
}

}  // namespace lbm
