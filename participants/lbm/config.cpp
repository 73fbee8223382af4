#include "participants/lbm/config.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/base/error.hpp"
#include "coupler/base/format.hpp"
#include "coupler/scene/beside_scene.hpp"
#include "coupler/scene/reader.hpp"
#include "coupler/scene/side_names.hpp"
#include "coupler/scene/threads.hpp"
#include "participants/lbm/mesh_solid.hpp"

namespace lbm {
namespace {

using sluice::format;

constexpr double flux_rate_with_les =
    1.2;  //!< s_q, see README.md: with magic = 3/16 vortices grow without bound at tau 0.506

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

}  // namespace

std::array<std::ptrdiff_t, 3> Config::cells() const noexcept
{
    return {std::lround(size[0] / cell), std::lround(size[1] / cell), dimension == 2 ? 1 : std::lround(size[2] / cell)};
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
