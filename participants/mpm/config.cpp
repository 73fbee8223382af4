#include "participants/mpm/config.hpp"

#include <cmath>

#include "coupler/base/format.hpp"
#include "coupler/scene/reader.hpp"
#include "coupler/scene/side_names.hpp"
#include "coupler/scene/threads.hpp"
#include "participants/motion/read_motion.hpp"
#include "participants/mpm/law_config.hpp"

namespace mpm {
namespace {

constexpr double most_nodes = 1e9;  //!< an index of each is kept, 4 bytes

using sluice::format;

std::array<double, 3> three(std::vector<double> const& numbers)
{
    std::array<double, 3> out{};
    for (std::size_t k = 0; k < std::min<std::size_t>(numbers.size(), 3); ++k) out[k] = numbers[k];
    return out;
}

std::array<double, 3> vector_of(sluice::Reader& r, char const* key, int dimension, sluice::Bounds const& bounds)
{
    return three(r.numbers(key, static_cast<std::size_t>(dimension), bounds));
}

std::array<double, 3> vector_or_zero(sluice::Reader& r, char const* key, int dimension, sluice::Bounds const& bounds)
{
    return three(r.numbers_or(key, std::vector<double>(static_cast<std::size_t>(dimension), 0.0), bounds));
}

bool is_whole(double cells)
{
    return std::abs(cells - std::round(cells)) <= 1e-6 * std::max(1.0, std::round(cells));
}

void read_domain(sluice::Reader& r, Config& c)
{
    sluice::Reader domain = r.child("domain");
    c.origin = vector_or_zero(domain, "origin", c.dimension, {.unit = "m"});
    c.size = vector_of(domain, "size", c.dimension, {.above = 0.0, .unit = "m"});
    domain.finish();
    c.cell = r.number("cell", {.above = 0.0, .unit = "m"});
    if (!r.diagnostics()->problems.empty()) return;
    for (std::size_t k = 0; k < static_cast<std::size_t>(c.dimension); ++k) {
        double const cells = c.size[k] / c.cell;
        if (!is_whole(cells) || cells < 0.5)
            r.problem("domain",
                      format("has a size of %g m along %c, %.6g cells of %g m (must be a whole number). Take %.9g m.",
                             c.size[k], "xyz"[k], cells, c.cell, std::max(1.0, std::round(cells)) * c.cell));
    }
}

//! The nodes of the grid are known by domain and basis.
void check_nodes(sluice::Reader& r, Config const& c)
{
    if (!r.diagnostics()->problems.empty()) return;
    double nodes = 1;
    for (std::size_t k = 0; k < static_cast<std::size_t>(c.dimension); ++k)
        nodes *= c.size[k] / c.cell + 1 + 2 * rings_of_nodes(c.basis, c.dimension);
    if (nodes > most_nodes) r.problem("cell", format("= %g m makes %.3g nodes (at most 1e9).", c.cell, nodes));
}

void read_basis(sluice::Reader& r, Config& c, Beside const& beside)
{
    c.points = static_cast<int>(r.integer_or("points", c.points, {.min = 1, .max = 16}));
    c.basis = static_cast<BasisKind>(r.choice_or("basis", 0, {"gimp", "linear", "spline", "cpdi"}));
    c.width = static_cast<Width>(r.choice_or("width", 0, {"fixed", "stretch"}));
    auto const refuse = [&](char const* key, bool where, char const* text) {
        if (where) r.refuse(key, text);
    };
    refuse("width", c.width == Width::stretch && (c.basis == BasisKind::linear || c.basis == BasisKind::spline),
           "beside basis = linear or spline (whose points have no width). Leave width out, or try basis: gimp.");
    if (c.basis != BasisKind::cpdi) return;
    refuse("width", c.width == Width::stretch,
           "beside basis = cpdi (its points follow all of F). Leave width out, or try basis: gimp.");
    refuse("basis", beside.grains,
           "beside a partner's grains (their contact knows points that stay as they were). Try basis: gimp.");
    refuse("basis", r.has("plates"),
           "beside plates (their contact knows points that stay as they were). Try basis: gimp, or walls.");
}

void read_scheme(sluice::Reader& r, Config& c)
{
    c.scheme = static_cast<Scheme>(r.choice_or("scheme", 0, {"musl", "usl"}));
    c.flip = r.number_or("flip", c.flip, {.min = 0.0, .max = 1.0});
    bool const hats = c.basis == BasisKind::linear;
    c.affine = r.flag_or("affine", !hats);
    if (c.affine && hats)
        r.refuse("affine",
                 "beside basis = linear (its slopes do not vanish with its weights: a node of little mass would "
                 "kick the gradient). Leave it out, or try basis: gimp.");
    c.damping = r.number_or("damping", c.damping, {.min = 0.0, .unit = "1/s"});
    c.courant = r.number_or("courant", c.courant, {.above = 0.0, .max = largest_courant});
    c.step = r.number_unless("step", "auto", {.above = 0.0, .unit = "s"});
}

//! Rings around the axis have what they need (axial.hpp), and no partner's bodies lie in the plane.
void read_symmetry(sluice::Reader& r, Config& c, Beside const& beside)
{
    c.symmetry = static_cast<Symmetry>(r.choice_or("symmetry", 0, {"plane", "axial"}));
    if (c.symmetry == Symmetry::plane) return;
    auto const refuse = [&](bool where, char const* beside_what) {
        if (where) r.refuse("symmetry", std::string("beside ") + beside_what);
    };
    refuse(c.dimension != 2, "dimension: 3 (needs 2: x is the radius, y along the axis). Leave it out.");
    refuse(c.origin[0] < 0, "a domain that reaches beyond the axis x = 0 (needs domain.origin: [0, ...] or above).");
    refuse(c.basis == BasisKind::linear || c.basis == BasisKind::spline,
           "basis: linear or spline (no weights of rings are known). Leave basis out, or try cpdi.");
    refuse(c.gravity[0] != 0, "gravity across the axis (needs [0, g]).");
    refuse(beside.grains, "a partner's grains (discs of the plane are no rings). Couple in space.");
    refuse(beside.fluid, "a partner's fluid (it has no axis). Couple in the plane or in space.");
    refuse(beside.rotation != nullptr, "frame: rotating, whose axis is another one (needs an inertial frame).");
}

Wall read_wall(sluice::Reader& walls, char const* name, int axis, int side)
{
    Wall wall{.axis = axis, .side = side};
    if (walls.has(name) && !walls.is_scalar(name)) {
        sluice::Reader rough = walls.child(name);
        wall.kind = WallKind::rough;
        wall.friction = rough.number("friction", {.min = 0.0});
        rough.finish();
        return wall;
    }
    WallKind const kinds[] = {WallKind::roller, WallKind::fixed, WallKind::open, WallKind::joined};
    wall.kind = kinds[walls.choice_or(name, 0, {"roller", "fixed", "open", "periodic"})];
    return wall;
}

void read_walls(sluice::Reader& r, Config& c, Beside const& beside)
{
    std::optional<sluice::Reader> walls = r.child_if("walls");
    for (int axis = 0; axis < c.dimension; ++axis)
        for (int side : {-1, 1}) {
            char const* const name =
                sluice::side_name(c.dimension, static_cast<std::size_t>(2 * axis + (side + 1) / 2));
            auto const a = static_cast<std::size_t>(axis);
            Wall wall = walls ? read_wall(*walls, name, axis, side) : Wall{.axis = axis, .side = side};
            wall.place = side < 0 ? c.origin[a] : c.origin[a] + c.size[a];
            c.walls.push_back(wall);
        }
    bool const has_axis = c.symmetry == Symmetry::axial && c.origin[0] == 0;
    if (has_axis && c.walls[0].kind != WallKind::roller && c.walls[0].kind != WallKind::joined)
        walls->refuse("left", "on the axis of symmetry: axial (needs roller: nothing moves across). Leave it out.");
    for (int axis = 0; axis < c.dimension; ++axis) {
        auto const at = static_cast<std::size_t>(2 * axis);
        bool const low = c.walls[at].kind == WallKind::joined, high = c.walls[at + 1].kind == WallKind::joined;
        auto const name = [&](std::size_t side) { return sluice::side_name(c.dimension, side); };
        if (low != high)
            walls->refuse(name(low ? at : at + 1),
                          std::string("has no opposite (needs ") + name(low ? at + 1 : at) + ": periodic, too).");
        if (!low) continue;
        auto const refuse = [&](bool where, char const* what) {
            if (where) walls->refuse(name(at), std::string("beside ") + what);
        };
        int const fewest = c.basis == BasisKind::cpdi ? 2 * (c.dimension + 1) : 4;
        refuse(c.size[at / 2] < (fewest - 0.5) * c.cell && c.cell > 0,
               format("fewer than %d cells (a point would meet itself).", fewest).c_str());
        refuse(beside.grains, "a partner's grains (contacts do not reach round). Take another wall.");
        refuse(beside.fluid, "a partner's fluid. Take another wall.");
        refuse(beside.rotation != nullptr, "frame: rotating (its pull differs from side to side).");
        refuse(c.symmetry == Symmetry::axial && axis == 0, "symmetry: axial (the axis is no side).");
        refuse(r.has("plates"), "plates (contacts do not reach round). Take a wall.");
    }
    if (walls) walls->finish();
}

//! Gates hold matter back on their lower side, and vanish.
void read_gates(sluice::Reader& r, Config& c)
{
    for (sluice::Reader gate : r.list("gates")) {
        Wall wall{.side = 1};
        wall.axis = static_cast<int>(c.dimension == 2 ? gate.choice_or("across", 0, {"x", "y"})
                                                      : gate.choice_or("across", 0, {"x", "y", "z"}));
        wall.place = gate.number("at", {.unit = "m"});
        wall.removed_at = gate.number("removed_at", {.min = 0.0, .unit = "s"});
        wall.friction = gate.number_or("friction", 0.0, {.min = 0.0});
        wall.kind = gate.has("friction") ? WallKind::rough : WallKind::roller;
        if (c.cell > 0 && !is_whole((wall.place - c.origin[static_cast<std::size_t>(wall.axis)]) / c.cell))
            gate.refuse("at", format("m (must be on a grid line: origin plus a multiple of %g m)", c.cell));
        if (c.walls[static_cast<std::size_t>(2 * wall.axis)].kind == WallKind::joined)
            gate.refuse("across",
                        format("beside periodic sides across %c (what it holds back would come in behind it). "
                               "Take walls there, or another axis.",
                               "xyz"[wall.axis]));
        gate.finish();
        c.walls.push_back(wall);
    }
}

Vec3 eigen(std::array<double, 3> const& v)
{
    return {v[0], v[1], v[2]};
}

void read_plates(sluice::Reader& r, Config& c)
{
    for (sluice::Reader plate : r.list("plates")) {
        Plate<3> p;
        p.point = eigen(vector_of(plate, "point", c.dimension, {.unit = "m"}));
        p.normal = eigen(vector_of(plate, "normal", c.dimension, {.min = -1e6, .max = 1e6}));
        if (!(p.normal.norm() > 0) && plate.has("normal"))
            plate.problem("normal", "has no length (needed: a vector towards the matter).");
        p.normal.normalize();
        p.friction = plate.number_or("friction", 0.0, {.min = 0.0});
        p.motion = motion::read_motion(plate, static_cast<std::size_t>(c.dimension),
                                       [](std::vector<double> const& v) { return eigen(three(v)); });
        if (auto const time = plate.number_if("removed_at", {.min = 0.0, .unit = "s"})) p.removed_at = *time;
        plate.finish();
        c.plates.push_back(p);
    }
}

BodyConfig read_body(sluice::Reader& r, Config const& c)
{
    int const dimension = c.dimension;
    BodyConfig body;
    if (r.has("box") == r.has("ball")) r.problem("box", "needs one of box, ball.");
    if (auto box = r.child_if("box")) {
        body.low = vector_of(*box, "low", dimension, {.unit = "m"});
        body.high = vector_of(*box, "high", dimension, {.unit = "m"});
        for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k)
            if (!(body.high[k] >= body.low[k])) box->problem("high", "is below low (must be above it on each axis).");
        box->finish();
    }
    if (auto ball = r.child_if("ball")) {
        body.ball = true;
        body.centre = vector_of(*ball, "centre", dimension, {.unit = "m"});
        body.radius = ball->number("radius", {.above = 0.0, .unit = "m"});
        if (c.symmetry == Symmetry::axial && body.centre[0] < body.radius)
            ball->refuse("centre",
                         format("beside symmetry: axial, over the axis (must be at r >= %g m: a ball is a ring "
                                "there). Take a box, or dimension: 3.",
                                body.radius));
        ball->finish();
    }
    body.velocity = vector_or_zero(r, "velocity", dimension, {.unit = "m/s"});
    r.finish();
    return body;
}

//! A column stands in the lower corner of the domain, in space as deep as it.
void read_column(sluice::Reader& r, Config& c)
{
    auto column = r.child_if("column");
    if (!column) return;
    ColumnConfig size;
    size.width = column->number("width", {.above = 0.0, .unit = "m"});
    size.height = size.width * column->number("aspect_ratio", {.above = 0.0});
    column->finish();
    BodyConfig body;
    body.low = c.origin;
    body.high = {c.origin[0] + size.width, c.origin[1] + c.size[1], c.origin[2] + c.size[2]};
    body.high[static_cast<std::size_t>(c.dimension - 1)] =
        c.origin[static_cast<std::size_t>(c.dimension - 1)] + size.height;
    c.bodies.push_back(body);
    c.column = size;
}

void read_geostatic(sluice::Reader& r, Config& c)
{
    auto weight = r.child_if("geostatic");
    if (!weight) return;
    bool const column = c.column && c.bodies.size() == 1;
    auto const up = static_cast<std::size_t>(c.dimension - 1);
    GeostaticConfig g;
    g.surface = column ? weight->number_or("surface", c.origin[up] + c.column->height, {.unit = "m"})
                       : weight->number("surface", {.unit = "m"});
    double const nu = elasticity_of(c.law).poissons_ratio;
    g.k0 = weight->number_or("k0", nu / (1 - nu), {.min = 0.0, .max = 10.0});
    weight->finish();
    if (std::holds_alternative<NeoHookean>(c.law))
        r.problem("geostatic",
                  "stands beside material.law = neo_hookean, whose stress follows from its deformation "
                  "(needs another law).");
    c.geostatic = g;
}

//! What the fluid displaced would weigh and what inertia it would have is the fluid's: the matter has the rest.
void read_fluid(sluice::Reader& r, Config& c, bool coupled)
{
    auto block = r.child_if("fluid");
    if (!block) {
        if (coupled)
            r.problem("fluid",
                      "is missing (a partner computes the fluid in the pores). Try fluid: {density: 1000, porosity: "
                      "0.4}.");
        return;
    }
    FluidConfig fluid;
    fluid.density = block->number("density", {.above = 0.0, .unit = "kg/m3"});
    fluid.porosity = block->number("porosity", {.above = 0.0, .below = 1.0});
    block->finish();
    if (!coupled)
        r.problem("fluid", "stands here, but no partner computes one (needs edges with data: phase and body_force).");
    double const displaced = (1 - fluid.porosity) * fluid.density;
    if (c.density > 0 && !(c.density > displaced))
        r.problem("fluid",
                  format("displaced has %g kg/m3 of the matter, which has %g itself (must have more: it would rise).",
                         displaced, c.density));
    else
        c.density -= displaced;
    c.fluid = fluid;
}

}  // namespace

Config read_config(sluice::Reader& r, int dimension, std::array<double, 3> const& gravity, Beside const& beside)
{
    Config c;
    c.dimension = dimension;
    c.gravity = gravity;
    if (beside.rotation) c.rotation = *beside.rotation;
    read_domain(r, c);
    read_basis(r, c, beside);
    check_nodes(r, c);
    read_scheme(r, c);
    read_symmetry(r, c, beside);
    sluice::Reader material = r.child("material");
    c.density = material.number("density", {.above = 0.0, .unit = "kg/m3"});
    c.law = read_law(material);
    material.finish();
    read_fluid(r, c, beside.fluid);
    c.shared_volume = r.flag_or("shared_volume", is_plastic(c.law));
    read_walls(r, c, beside);
    read_gates(r, c);
    read_plates(r, c);
    read_column(r, c);
    for (sluice::Reader body : r.list("bodies")) c.bodies.push_back(read_body(body, c));
    if (c.bodies.empty()) r.problem("column", "is missing (give column, bodies or both).");
    read_geostatic(r, c);
    if (auto contact = r.child_if("grains")) {
        c.grain_friction = contact->number("friction", {.min = 0.0});
        contact->finish();
    } else if (beside.grains) {
        r.problem("grains",
                  "is missing (a partner sends grains: needs the friction of the matter on them). Try grains: "
                  "{friction: 0.5}.");
    }
    c.front_depth = r.number_if("front_depth", {.above = 0.0, .unit = "m"});
    c.threads = sluice::read_threads(r, "1", beside.processes);
    r.finish();
    return c;
}

}  // namespace mpm
