#include "participants/mpm/grains.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include "coupler/base/error.hpp"
#include "participants/mpm/cell.hpp"
#include "participants/mpm/walls.hpp"

namespace mpm {
namespace {

constexpr double reach = 1;  // cells: a point further from a grain does not touch it in a step
//! Share of a gap < 0 that is opened in a step, and softness of a contact by the inertia of its face: "error reduction"
//! and "constraint force mixing" of Smith, Open Dynamics Engine (2006), sec. 3.7 and 3.8, who names 0.1 to 0.8 for the
//! first. Both matter little: a face under a pressure p is softness / opened dt^2 p / (rho h) inside, 0.1 h p / (rho
//! c^2) at most. Without softness neighbours that share nodes work against each other, and the sweeps do not end.
constexpr double opened = 0.2, softness = 0.1;
constexpr double tolerance = 1e-5;  // cells by which a sweep may still move a face; the next step sees what is left
constexpr int most_sweeps = 40;
constexpr double fewest_cells = 0.5;  // of a radius: less would slip between the points of a cell

template <int D>
void require_size(Setup<D> const& setup, Grain<D> const& g)
{
    double const cells = g.radius / setup.cell;
    sluice::require(cells >= fewest_cells, [&] {
        char text[300];
        std::snprintf(text, sizeof text,
                      "mpm: grain %lld has a radius of %g m, %.3g cells (must be at least %g). Try a finer cell, or "
                      "leave grains as small as that out of the coupling (region).",
                      static_cast<long long>(g.id), g.radius, cells, fewest_cells);
        return sluice::Error(text);
    });
}

//! `apart`: there is a way out of it.
template <int D>
void require_outside(Setup<D> const& setup, double gap, std::int64_t point, char const* body, std::int64_t number,
                     bool apart)
{
    sluice::require(gap > -reach * setup.cell && apart, [&] {
        char text[300];
        std::snprintf(text, sizeof text,
                      "mpm: point %lld is %.3g cells inside %s %lld (must stay outside). Try a start in which they are "
                      "apart, a shorter window, or a stiffer material.",
                      static_cast<long long>(point), -gap / setup.cell, body, static_cast<long long>(number));
        return sluice::Error(text, sluice::Exit::numerical);
    });
}

}  // namespace

//! Places of points run half a step ahead of the time: so does the plate's.
template <int D>
std::vector<PlateNow<D>> plates_at(Setup<D> const& setup, double time, double dt)
{
    std::vector<PlateNow<D>> now;
    for (std::size_t k = 0; k < setup.plates.size(); ++k) {
        Plate<D> const& p = setup.plates[k];
        if (p.removed_at <= time) continue;
        Vec<D> const from = p.motion.shift(time + 0.5 * dt), to = p.motion.shift(time + 1.5 * dt);
        now.push_back({k, p.point + from, p.normal, (to - from) / dt, p.friction});
    }
    return now;
}

template <int D>
void GrainContacts<D>::set(std::vector<Grain<D>> grains)
{
    grains_ = std::move(grains);
    speed_ = 0;
    for (Grain<D> const& g : grains_) speed_ = std::max(speed_, g.velocity.norm() + g.spin.norm() * g.radius);
}

//! With a ring around the domain: points may be pressed into its sides. Elsewhere: the number of cells.
template <int D>
std::size_t GrainContacts<D>::cell_at(Setup<D> const& setup, Vec<D> const& place) const
{
    auto const cell = cell_of(setup, place);
    std::size_t at = 0;
    for (std::size_t k = D; k-- > 0;) {
        if (cell[k] < -1 || cell[k] > cells_[k]) return first_.size();
        at = at * static_cast<std::size_t>(cells_[k] + 2) + static_cast<std::size_t>(cell[k] + 1);
    }
    return at;
}

//! The cells that the surface of a grain may be near to.
template <int D>
void GrainContacts<D>::mark(Setup<D> const& setup, std::size_t grain)
{
    Grain<D> const& g = grains_[grain];
    double const h = setup.cell, within = (2 * reach + 0.5 * std::sqrt(D)) * h;
    Vec<D> const out = Vec<D>::Constant(g.radius + within);
    auto low = cell_of(setup, Vec<D>(g.place - out)), high = cell_of(setup, Vec<D>(g.place + out));
    std::size_t count = 1;
    std::array<std::size_t, 3> size{1, 1, 1};
    for (std::size_t k = 0; k < D; ++k) {
        low[k] = std::max(low[k], -1), high[k] = std::min(high[k], cells_[k]);
        if (high[k] < low[k]) return;
        count *= size[k] = static_cast<std::size_t>(high[k] - low[k] + 1);
    }
    for (std::size_t n = 0; n < count; ++n) {
        std::array<std::size_t, 3> const at{n % size[0], n / size[0] % size[1], n / size[0] / size[1]};
        Vec<D> centre;
        for (std::size_t k = 0; k < D; ++k) {
            auto const a = static_cast<int>(k);
            centre[a] = setup.origin[a] + h * (low[k] + static_cast<int>(at[k]) + 0.5);
        }
        if (std::abs((centre - g.place).norm() - g.radius) > within) continue;
        std::size_t const cell = cell_at(setup, centre);
        if (first_[cell] == none) marked_.push_back(cell);
        marks_.push_back({grain, first_[cell]});
        first_[cell] = static_cast<std::int32_t>(marks_.size() - 1);
    }
}

template <int D>
void GrainContacts<D>::begin(Setup<D> const& setup)
{
    if (first_.empty()) {
        cells_ = setup.cells;
        std::size_t all = 1;
        for (int const n : cells_) all *= static_cast<std::size_t>(n + 2);
        first_.assign(all, none);
        nodes_ = Grid<D, TouchedNode<D>>(cells_);
    }
    for (std::size_t const cell : marked_) first_[cell] = none;
    marked_.clear();
    marks_.clear();
    contacts_.clear();
    shares_.clear();
    nodes_.clear();
    pushes_.assign(grains_.size(), {});
    plate_impulses_.assign(plates_.size(), Vec<D>::Zero());
    sweeps_ = 0;
    for (std::size_t g = 0; g < grains_.size(); ++g) {
        require_size(setup, grains_[g]);
        mark(setup, g);
    }
}

template <int D>
void GrainContacts<D>::consider(Setup<D> const& setup, double dt, std::int64_t id, Vec<D> const& place, double ratio)
{
    double const h = setup.cell;
    double const half_width = h * setup.half_width * std::min(1.0, D == 2 ? std::sqrt(ratio) : std::cbrt(ratio));
    std::size_t const cell = cell_at(setup, place);
    for (std::int32_t m = cell < first_.size() ? first_[cell] : none; m != none;
         m = marks_[static_cast<std::size_t>(m)].next) {
        std::size_t const body = marks_[static_cast<std::size_t>(m)].grain;
        Grain<D> const& g = grains_[body];
        Vec<D> const apart = place - g.place;
        double const distance = apart.norm(), gap = distance - g.radius - half_width;
        if (gap > reach * h) continue;
        require_outside(setup, gap, id, "grain", g.id, distance > 0);
        Vec<D> const normal = apart / distance, face = place - half_width * normal, arm = face - g.place;
        add(setup, dt, gap, face, {id, body, friction, normal, arm, g.velocity + velocity_of<D>(g.spin, arm)});
    }
    for (std::size_t k = 0; k < plates_.size(); ++k) {
        PlateNow<D> const& p = plates_[k];
        double const gap = (place - p.point).dot(p.normal) - half_width;
        if (gap > reach * h) continue;
        require_outside(setup, gap, id, "plate", static_cast<std::int64_t>(p.number), true);
        Vec<D> const face = place - half_width * p.normal;
        add(setup, dt, gap, face, {id, grains_.size() + k, p.friction, p.normal, face - p.point, p.velocity});
    }
}

//! By hat functions for every basis: their nodes are among those of the point, but for one of no more weight than
//! rounding, where half a point's width is half a cell; it may have no mass, and gets nothing.
template <int D>
void GrainContacts<D>::add(Setup<D> const& setup, double dt, double gap, Vec<D> const& face, Contact c)
{
    c.bias = (gap > 0 ? 1 : opened) * gap / dt;
    Stencil<D, Linear> const at(Vec<D>::Zero(), (face - setup.origin) / setup.cell, setup.cell);
    c.first = shares_.size();
    at.each(nodes_, [&](TouchedNode<D>& node, double weight, Vec<D> const&) {
        shares_.push_back({static_cast<std::size_t>(&node - nodes_.nodes().data()), weight});
    });
    c.last = shares_.size();
    contacts_.push_back(c);
}

template <int D>
Vec<D> GrainContacts<D>::slip(Contact const& c, Vec<D> TouchedNode<D>::*velocity) const
{
    Vec<D> u = -c.body_velocity;
    for (auto const& [node, weight] : shares(c)) u += weight * nodes_.nodes()[node].*velocity;
    return u;
}

template <int D>
void GrainContacts<D>::hold(Setup<D> const& setup, TouchedNode<D>& node) const
{
    node.held = node.velocity;
    for (std::size_t w = 0; node.walls >> w != 0; ++w)
        if (node.walls >> w & 1) mpm::hold<D>(setup.walls[w], node.held);
}

//! Changes one impulse so that it obeys its law; returns the change of velocity at the face.
template <int D>
double GrainContacts<D>::relax(Setup<D> const& setup, Contact& c)
{
    Vec<D> const u = slip(c, &TouchedNode<D>::held), &n = c.normal;
    double const across = c.impulse.dot(n), into = n.dot(u);
    double const normal = std::max(0.0, (across - c.response * (into + c.bias)) / (1 + softness));
    Vec<D> along = c.impulse - across * n - c.response * (u - into * n);
    double const most = c.friction * normal, size = along.norm();
    if (size > most) along *= most / size;
    Vec<D> const change = normal * n + along - c.impulse;
    if (change.isZero(0)) return 0;
    c.impulse += change;
    for (auto const& [at, weight] : shares(c)) {
        TouchedNode<D>& node = nodes_.nodes()[at];
        if (node.mass <= 0) continue;
        node.velocity += weight / node.mass * change;
        hold(setup, node);
    }
    return change.norm() / c.response;
}

//! Gauss and Seidel's way, to and fro; walls act after every change, so that contacts see what they will do.
template <int D>
void GrainContacts<D>::solve(Setup<D> const& setup, double time, double dt, Booked& booked)
{
    // in an order that does not depend on that of the points; those of one are together already
    std::stable_sort(contacts_.begin(), contacts_.end(),
                     [](Contact const& a, Contact const& b) { return a.point < b.point; });
    for (TouchedNode<D>& node : nodes_.nodes()) {
        for (std::size_t w = 0; w < setup.walls.size(); ++w)
            if (setup.walls[w].removed_at > time && holds<D>(setup.walls[w], setup, node.index))
                node.walls |= std::uint32_t{1} << w;
        hold(setup, node);
    }
    for (Contact& c : contacts_) {
        double compliance = 0;
        for (auto const& [node, weight] : shares(c))
            if (double const m = nodes_.nodes()[node].mass; m > 0) compliance += weight * weight / m;
        c.response = compliance > 0 ? 1 / compliance : 0;
    }
    double const enough = tolerance * setup.cell / dt;
    for (double worst = 2 * enough; worst > enough && sweeps_ < most_sweeps; ++sweeps_) {
        worst = 0;
        for (std::size_t k = 0; k < contacts_.size(); ++k)
            worst = std::max(worst, relax(setup, contacts_[sweeps_ % 2 == 0 ? k : contacts_.size() - 1 - k]));
    }
    for (Contact const& c : contacts_) {
        Vec<D> const along = c.impulse - c.impulse.dot(c.normal) * c.normal;
        booked.external_work += c.impulse.dot(c.body_velocity);
        booked.sliding -= 0.5 * along.dot(slip(c, &TouchedNode<D>::before) + slip(c, &TouchedNode<D>::held));
        if (c.body >= grains_.size()) {
            plate_impulses_[c.body - grains_.size()] -= c.impulse;
            continue;
        }
        pushes_[c.body].impulse -= c.impulse;
        pushes_[c.body].angular -= moment_of<D>(c.arm, c.impulse);
    }
}

template std::vector<PlateNow<2>> plates_at<2>(Setup<2> const&, double, double);
template std::vector<PlateNow<3>> plates_at<3>(Setup<3> const&, double, double);
template class GrainContacts<2>;
template class GrainContacts<3>;

}  // namespace mpm
