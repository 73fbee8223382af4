#include "participants/mpm/setup.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "coupler/base/error.hpp"
#include "participants/mpm/axial.hpp"
#include "participants/mpm/field.hpp"

namespace mpm {
namespace {

using sluice::Error;
using sluice::require;

constexpr double reach = 1e-9;  //!< cells by which a point may lie outside its body: rounding

template <int D>
Vec<D> vector(std::array<double, 3> const& numbers)
{
    Vec<D> out;
    for (int k = 0; k < D; ++k) out[k] = numbers[static_cast<std::size_t>(k)];
    return out;
}

template <int D>
bool is_in(BodyConfig const& body, Vec<D> const& place, double slack)
{
    if (body.ball) return (place - vector<D>(body.centre)).norm() <= body.radius + slack;
    Vec<D> const low = vector<D>(body.low), high = vector<D>(body.high);
    return ((place - low).array() >= -slack).all() && ((place - high).array() <= slack).all();
}

//! The stress that a column of `height` under its own weight has at a depth; zero above the surface.
template <int D>
Mat3 weight_of(Config const& c, Potential<D> const& potential, Vec<D> const& place)
{
    Vec<D> top = place;
    top[D - 1] = std::max(place[D - 1], c.geostatic->surface);
    double const vertical = -c.density * std::abs(potential(top) - potential(place));
    Vec3 across = Vec3::Constant(c.geostatic->k0 * vertical);
    across[D - 1] = vertical;
    return across.asDiagonal();
}

template <int D>
double volume_of(BodyConfig const& body)
{
    if (body.ball) return (D == 2 ? 1 : 4.0 / 3) * std::numbers::pi * std::pow(body.radius, D);
    return (vector<D>(body.high) - vector<D>(body.low)).prod();
}

template <int D>
void fill(Config const& c, Potential<D> const& potential, BodyConfig const& body, State<D>& state)
{
    double const spacing = c.cell / c.points;
    Vec<D> const origin = vector<D>(c.origin);
    Vec<D> const low = body.ball ? Vec<D>(vector<D>(body.centre).array() - body.radius) : vector<D>(body.low);
    Vec<D> const high = body.ball ? Vec<D>(vector<D>(body.centre).array() + body.radius) : vector<D>(body.high);
    std::array<std::ptrdiff_t, 3> first{}, count{1, 1, 1};
    for (int k = 0; k < D; ++k) {
        auto const a = static_cast<std::size_t>(k);
        first[a] = static_cast<std::ptrdiff_t>(std::floor((low[k] - origin[k]) / spacing));
        count[a] = static_cast<std::ptrdiff_t>(std::ceil((high[k] - origin[k]) / spacing)) - first[a];
    }
    std::size_t const before = state.points.size();
    for (std::ptrdiff_t n = 0; n < count[0] * count[1] * count[2]; ++n) {
        std::array<std::ptrdiff_t, 3> const at{n % count[0], n / count[0] % count[1], n / count[0] / count[1]};
        Point<D> point;
        for (int k = 0; k < D; ++k) {
            auto const a = static_cast<std::size_t>(k);
            point.place[k] = origin[k] + (static_cast<double>(first[a] + at[a]) + 0.5) * spacing;
        }
        if (!is_in<D>(body, point.place, reach * c.cell)) continue;
        point.id = static_cast<std::int64_t>(state.points.size());
        point.velocity = vector<D>(body.velocity);
        if (c.geostatic) point.matter.stress = weight_of<D>(c, potential, point.place);
        state.points.push_back(point);
    }
    require(state.points.size() > before,
            [] { return Error("mpm: a body has no points (needs a size of half a cell or more). Try a finer cell."); });
    double const share = volume_of<D>(body) / static_cast<double>(state.points.size() - before);
    for (std::size_t p = before; p < state.points.size(); ++p) {
        Point<D>& point = state.points[p];
        point.volume = share * girth(c.symmetry, point.place);
        point.mass = c.density * point.volume;
    }
}

}  // namespace

template <int D>
Setup<D> make_setup(Config const& c)
{
    Setup<D> setup;
    setup.origin = vector<D>(c.origin);
    for (std::size_t k = 0; k < D; ++k) setup.cells[k] = static_cast<int>(std::lround(c.size[k] / c.cell));
    setup.cell = c.cell;
    setup.half_width = 0.5 / c.points;
    setup.width = c.width;
    setup.symmetry = c.symmetry;
    setup.density = c.density;
    setup.basis = c.basis;
    setup.scheme = c.scheme;
    setup.flip = c.flip;
    setup.affine = c.affine;
    setup.shared_volume = c.shared_volume;
    setup.damping = c.damping;
    setup.courant = c.courant;
    setup.gravity = vector<D>(c.gravity);
    if (c.rotation) setup.frame.emplace(*c.rotation);
    setup.law = c.law;
    setup.walls = c.walls;
    for (Wall const& wall : c.walls)
        if (wall.kind == WallKind::joined)
            setup.period[wall.axis] = c.cell * setup.cells[static_cast<std::size_t>(wall.axis)];
    auto const own = [](Vec3 const& v) -> Vec<D> { return v.head<D>(); };
    for (Plate<3> const& p : c.plates)
        setup.plates.push_back(
            {own(p.point), own(p.normal), p.friction, motion::converted<Vec<D>>(p.motion, own), p.removed_at});
    return setup;
}

template <int D>
State<D> make_state(Config const& c)
{
    State<D> state;
    Potential<D> const potential(make_setup<D>(c), 0);
    for (BodyConfig const& body : c.bodies) fill<D>(c, potential, body, state);
    return state;
}

template <int D>
Solver<D> make_solver(Config const& c, ranks::Peers* peers)
{
    Solver<D> solver(make_setup<D>(c), make_state<D>(c), peers);
    if (c.threads > 1) solver.use_threads(c.threads);
    double const longest = largest_courant * solver.limit();
    require(!c.step || *c.step <= longest, [&] {
        char text[200];
        std::snprintf(text, sizeof text,
                      "mpm: step = %.4g s (must be at most %.4g s, %g cells at the speed of sound and of the fastest "
                      "point). Try step: auto.",
                      *c.step, longest, largest_courant);
        return Error(text);
    });
    return solver;
}

template Setup<2> make_setup<2>(Config const&);
template Setup<3> make_setup<3>(Config const&);
template State<2> make_state<2>(Config const&);
template State<3> make_state<3>(Config const&);
template Solver<2> make_solver<2>(Config const&, ranks::Peers*);
template Solver<3> make_solver<3>(Config const&, ranks::Peers*);

}  // namespace mpm
