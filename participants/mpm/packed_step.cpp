#include "participants/mpm/packed_step.hpp"

#include <algorithm>
#include <cmath>

#include "coupler/base/team.hpp"
#include "participants/mpm/cell.hpp"
#include "participants/mpm/packed_deform.hpp"
#include "participants/mpm/room.hpp"
#include "participants/mpm/walls.hpp"

namespace mpm {
namespace {

using namespace packed;

constexpr std::int64_t sorted_every = 32;  //!< steps; 8 to 128 are within 2 %
constexpr double most_nodes_of_a_point = 50;

//! Makes room for `count` planes of zeros.
void reserve(Planes& planes, std::vector<double>& numbers, std::size_t count)
{
    planes.plane = static_cast<std::size_t>(planes.stride) * static_cast<std::size_t>(planes.rows) + 4;
    numbers.assign(count * planes.plane, 0.0);
    planes.data = numbers.data();
}

}  // namespace

PackedStep::PackedStep(int threads) : threads_(threads), team_(std::make_unique<sluice::Team>(threads)) {}
PackedStep::PackedStep(PackedStep const& other) : PackedStep(other.threads_)
{
    points_ = other.points_;
}
PackedStep& PackedStep::operator=(PackedStep const& other)
{
    return *this = PackedStep(other);
}
PackedStep::PackedStep(PackedStep&&) noexcept = default;
PackedStep& PackedStep::operator=(PackedStep&&) noexcept = default;
PackedStep::~PackedStep() = default;

bool PackedStep::serves(Setup<2> const& setup)
{
    return setup.basis != BasisKind::linear && setup.width == Width::fixed && setup.tractions.empty() &&
           (std::holds_alternative<MohrCoulomb>(setup.law) || std::holds_alternative<LinearElastic>(setup.law)) &&
           !setup.one_at_a_time;
}

template <class Each>
void PackedStep::each_chunk(Each&& each)
{
    auto const body = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t c = begin; c < end; ++c) each(chunks_[static_cast<std::size_t>(c)]);
    };
    auto const count = static_cast<std::ptrdiff_t>(chunks_.size());
    threads_ == 1 ? body(0, count) : team_->share(count, 1, body);
}

//! Places in cells, and the boxes of nodes around them.
bool PackedStep::lay_out(Setup<2> const& setup)
{
    points_.place_fillers();
    std::size_t const filled = (points_.size() + 3) / 4 * 4;
    chunks_.resize((filled + chunk - 1) / chunk);
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        chunks_[c].begin = c * chunk;
        chunks_[c].end = std::min(filled, (c + 1) * chunk);
    }
    Pack const ox = all(setup.origin[0]), oy = all(setup.origin[1]), h = all(setup.cell);
    each_chunk([&](Chunk& c) {
        Pack low_x = all(1e300), low_y = low_x, high_x = -low_x, high_y = -low_x;
        for (std::size_t k = c.begin; k < c.end; k += 4) {
            Pack const x = (load(points_[P::x] + k) - ox) / h, y = (load(points_[P::y] + k) - oy) / h;
            store(points_[P::cx] + k, x), store(points_[P::cy] + k, y);
            low_x = sluice::packs::smaller(low_x, x), high_x = sluice::packs::larger(high_x, x);
            low_y = sluice::packs::smaller(low_y, y), high_y = sluice::packs::larger(high_y, y);
        }
        auto const least = [](Pack v) { return std::min(std::min(v[0], v[1]), std::min(v[2], v[3])); };
        auto const node = [](double place) { return static_cast<int>(std::floor(place - 0.5)); };
        c.planes.x0 = node(least(low_x)), c.planes.y0 = node(least(low_y));
        c.planes.stride = node(-least(-high_x)) - c.planes.x0 + 3;
        c.planes.rows = node(-least(-high_y)) - c.planes.y0 + 3;
        c.outcome = {};
    });
    Planes all_nodes = chunks_[0].planes;
    int right = all_nodes.x0, top = all_nodes.y0;
    double nodes = 0;
    for (Chunk const& c : chunks_) {
        all_nodes.x0 = std::min(all_nodes.x0, c.planes.x0), all_nodes.y0 = std::min(all_nodes.y0, c.planes.y0);
        right = std::max(right, c.planes.x0 + c.planes.stride), top = std::max(top, c.planes.y0 + c.planes.rows);
        nodes += double(c.planes.stride) * c.planes.rows;
    }
    all_nodes.stride = right - all_nodes.x0, all_nodes.rows = top - all_nodes.y0;
    nodes += double(all_nodes.stride) * all_nodes.rows;
    if (nodes > most_nodes_of_a_point * static_cast<double>(points_.size()) + 1e4) return false;
    nodes_ = all_nodes;
    reserve(nodes_, numbers_, taken);
    each_chunk([](Chunk& c) { reserve(c.planes, c.numbers, given); });
    return true;
}

//! By cells, row by row.
void PackedStep::sort(Setup<2> const& setup)
{
    std::vector<std::uint32_t> keys(points_.size());
    int x0 = INT32_MAX, y0 = x0, x1 = INT32_MIN, y1 = x1;
    auto const node = [&](P::Column c, std::size_t k) {
        auto const axis = c == P::x ? 0 : 1;
        return static_cast<int>(std::floor((points_[c][k] - setup.origin[axis]) / setup.cell - 0.5));
    };
    for (std::size_t k = 0; k < keys.size(); ++k) {
        x0 = std::min(x0, node(P::x, k)), x1 = std::max(x1, node(P::x, k));
        y0 = std::min(y0, node(P::y, k)), y1 = std::max(y1, node(P::y, k));
    }
    auto const width = static_cast<std::uint32_t>(x1 - x0 + 1), height = static_cast<std::uint32_t>(y1 - y0 + 1);
    if (double(width) * height > 100 * most_nodes_of_a_point * static_cast<double>(keys.size())) return;
    for (std::size_t k = 0; k < keys.size(); ++k)
        keys[k] =
            static_cast<std::uint32_t>(node(P::y, k) - y0) * width + static_cast<std::uint32_t>(node(P::x, k) - x0);
    points_.sort(keys, std::size_t{width} * height);
}

//! Planes of all chunks' boxes onto the nodes, in the order of the chunks.
void PackedStep::add_boxes(std::size_t from, std::size_t count, std::size_t to)
{
    auto const rows = [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (Chunk const& c : chunks_) {
            auto const offset = static_cast<std::ptrdiff_t>(c.planes.y0 - nodes_.y0);
            auto const last = std::min<std::ptrdiff_t>(end, offset + c.planes.rows);
            for (std::ptrdiff_t row = std::max(begin, offset); row < last; ++row)
                for (std::size_t q = 0; q < count; ++q) {
                    double const* in = c.planes[from + q] + c.planes.at(c.planes.x0, static_cast<int>(row) + nodes_.y0);
                    double* out = nodes_[to + q] + nodes_.at(c.planes.x0, static_cast<int>(row) + nodes_.y0);
                    for (int i = 0; i < c.planes.stride; ++i) out[i] += in[i];
                }
        }
    };
    threads_ == 1 ? rows(0, nodes_.rows) : team_->share(nodes_.rows, std::max(8, nodes_.rows / (4 * threads_)), rows);
}

//! The mean of what the points gave to their cells; what they gave is forgotten.
void PackedStep::share_mean(std::size_t from, std::size_t volume, std::size_t value, std::size_t mean)
{
    add_boxes(from, 2, volume);
    for (std::size_t i = 0; i < nodes_.plane; ++i) {
        double const v = nodes_[volume][i];
        nodes_[mean][i] = v > 0 ? nodes_[value][i] / v : 0;
        nodes_[volume][i] = nodes_[value][i] = 0;
    }
    each_chunk([&](Chunk& c) { std::fill_n(c.planes[from], 2 * c.planes.plane, 0.0); });
}

//! Adds the loads to the forces of the nodes. Until strain needs them, n_ux and n_uy hold them by themselves.
void PackedStep::take_loads(Setup<2> const& setup, double half_width, std::span<Vec<2> const> loads)
{
    each_chunk([&](Chunk& c) { loads_to_grid(points_, loads, c.begin, c.end, half_width, setup.cell, c.planes); });
    add_boxes(g_qx, 2, n_ux);
    each_chunk([&](Chunk& c) { std::fill_n(c.planes[g_qx], 2 * c.planes.plane, 0.0); });
    for (std::size_t i = 0; i < nodes_.plane; ++i) {
        nodes_[n_fx][i] += nodes_[n_ux][i];
        nodes_[n_fy][i] += nodes_[n_uy][i];
    }
}

//! Their work, once the nodes have moved.
void PackedStep::book_loads(Setup<2> const& setup, double dt, Outcome& outcome)
{
    double const undamped = std::exp(setup.damping * dt);
    double work = 0;
    for (std::size_t i = 0; i < nodes_.plane; ++i)
        work += nodes_[n_ux][i] * (nodes_[n_bx][i] + undamped * nodes_[n_vx][i]) +
                nodes_[n_uy][i] * (nodes_[n_by][i] + undamped * nodes_[n_vy][i]);
    outcome.booked.external_work += 0.5 * dt * work;
}

template <bool turning>
void PackedStep::move_nodes(Setup<2> const& setup, Field<2> const& field, double dt, Outcome& outcome)
{
    double const kept = std::exp(-setup.damping * dt), gx = setup.gravity[0], gy = setup.gravity[1];
    double const least = light_mass(setup);
    double damped = 0;
    std::int64_t light = 0, reached = 0;
    for (std::size_t i = 0; i < nodes_.plane; ++i) {
        double const m = nodes_[n_mass][i];
        if (m <= 0) continue;
        double bx = nodes_[n_px][i] / m, by = nodes_[n_py][i] / m, vx, vy;
        if constexpr (turning) {
            Vec<2> const place = corner_of<2>(setup, nodes_.index(i)), force(nodes_[n_fx][i], nodes_[n_fy][i]);
            Vec<2> const half = 0.5 * dt * (force / m + field.acceleration(place));
            Vec<2> const before = field.turned({bx, by}), v = field.turned({bx + half[0], by + half[1]}) + half;
            bx = before[0], by = before[1], vx = v[0], vy = v[1];
        } else {
            vx = bx + dt * (nodes_[n_fx][i] / m + gx), vy = by + dt * (nodes_[n_fy][i] / m + gy);
        }
        damped += m * (vx * vx + vy * vy);
        vx *= kept, vy *= kept;
        nodes_[n_bx][i] = bx, nodes_[n_by][i] = by;
        nodes_[n_vx][i] = vx, nodes_[n_vy][i] = vy;
        nodes_[n_dx][i] = vx - bx, nodes_[n_dy][i] = vy - by;
        light += m < least;
        ++reached;
    }
    outcome.booked.damping = 0.5 * (1 - kept * kept) * damped;
    outcome.light_nodes = light;
    outcome.nodes = static_cast<std::size_t>(reached);
}

void PackedStep::touch_grains(Setup<2> const& setup, double time, double dt, GrainContacts<2>& grains, Outcome& outcome)
{
    grains.begin(setup);
    double const *x = points_[P::x], *y = points_[P::y], *ratio = points_[P::ratio];
    for (std::size_t k = 0; k < points_.size(); ++k)
        if (Vec<2> const place(x[k], y[k]); grains.is_near(setup, place))
            grains.consider(setup, dt, points_.order()[k], place, ratio[k]);
    for (TouchedNode<2>& node : grains.nodes()) {
        std::size_t const i = nodes_.at(node.index[0], node.index[1]);
        node.mass = nodes_[n_mass][i];
        node.before = {nodes_[n_bx][i], nodes_[n_by][i]};
        node.velocity = {nodes_[n_vx][i], nodes_[n_vy][i]};
    }
    grains.solve(setup, time, dt, outcome.booked);
    for (TouchedNode<2> const& node : grains.nodes()) {
        std::size_t const i = nodes_.at(node.index[0], node.index[1]);
        nodes_[n_vx][i] = node.velocity[0], nodes_[n_vy][i] = node.velocity[1];
        nodes_[n_dx][i] = node.velocity[0] - node.before[0], nodes_[n_dy][i] = node.velocity[1] - node.before[1];
    }
}

void PackedStep::hold_nodes(Setup<2> const& setup, double time, Outcome& outcome)
{
    gripped_.clear();
    for (Wall const& wall : setup.walls) {
        if (wall.removed_at <= time || wall.kind == WallKind::open) continue;
        int const line = line_of(wall, setup);
        int x0 = nodes_.x0, x1 = x0 + nodes_.stride, y0 = nodes_.y0, y1 = y0 + nodes_.rows;
        int& low = wall.axis == 0 ? x0 : y0;
        int& high = wall.axis == 0 ? x1 : y1;
        wall.side < 0 ? high = std::min(high, line + 1) : low = std::max(low, line);
        for (int iy = y0; iy < y1; ++iy)
            for (int ix = x0; ix < x1; ++ix) {
                std::size_t const i = nodes_.at(ix, iy);
                double const m = nodes_[n_mass][i];
                if (m <= 0) continue;
                Vec<2> const before(nodes_[n_bx][i], nodes_[n_by][i]);
                Vec<2> v(nodes_[n_vx][i], nodes_[n_vy][i]), rubbed = v;
                Grip const grip = hold<2>(wall, v);
                if (grip == Grip::none) continue;
                gripped_.push_back({i, wall.axis, grip});
                nodes_[n_vx][i] = v[0], nodes_[n_vy][i] = v[1];
                nodes_[n_dx][i] = v[0] - before[0], nodes_[n_dy][i] = v[1] - before[1];
                if (wall.kind != WallKind::rough) continue;
                rubbed -= v;
                rubbed[wall.axis] = 0;
                outcome.booked.sliding += 0.5 * m * rubbed.dot(before + v);
            }
    }
}

//! As in Solver: a node of almost no mass is seen by strain at the velocity that the points brought.
void PackedStep::set_strain_velocities(Setup<2> const& setup, Outcome& outcome)
{
    double const least = light_mass(setup);
    if (setup.scheme == Scheme::usl) {
        for (std::size_t i = 0; outcome.light_nodes > 0 && i < nodes_.plane; ++i) {
            bool const light = nodes_[n_mass][i] < least;
            nodes_[n_ux][i] = nodes_[light ? n_bx : n_vx][i];
            nodes_[n_uy][i] = nodes_[light ? n_by : n_vy][i];
        }
        return;
    }
    add_boxes(g_qx, 2, n_qx);
    for (std::size_t i = 0; i < nodes_.plane; ++i) {
        double const m = nodes_[n_mass][i];
        if (m <= 0) continue;
        nodes_[n_ux][i] = nodes_[n_qx][i] / m, nodes_[n_uy][i] = nodes_[n_qy][i] / m;
    }
    for (Gripped const& g : gripped_) {
        Vec<2> u(nodes_[n_ux][g.node], nodes_[n_uy][g.node]);
        hold_again<2>(g.axis, g.grip, u);
        nodes_[n_ux][g.node] = u[0], nodes_[n_uy][g.node] = u[1];
    }
}

template <bool affine, bool shared, class Law>
void PackedStep::deform(double dt, Law const& law)
{
    each_chunk([&](Chunk& c) {
        auto const d = packed::deform<affine, shared>(points_, c.begin, c.end, dt, law, nodes_);
        c.outcome.stress = d.work;
        c.outcome.booked.plastic = d.plastic;
        c.outcome.speed = d.speed;
        c.outcome.all_upright = d.upright;
    });
}

template <bool affine, bool musl, bool shared>
void PackedStep::run(Setup<2> const& setup, double time, double dt, std::span<Vec<2> const> loads,
                     GrainContacts<2>& grains, Outcome& outcome)
{
    double const half_width = setup.basis == BasisKind::spline ? 0.5 : setup.half_width;
    if constexpr (shared) {
        each_chunk([&](Chunk& c) { mean_stress_to_cells(points_, c.begin, c.end, c.planes); });
        share_mean(g_volume, n_volume, n_value, n_mean);
    }
    each_chunk([&](Chunk& c) {
        c.outcome.kinetic_before =
            to_grid<affine, shared>(points_, c.begin, c.end, half_width, setup.cell, c.planes, nodes_);
    });
    add_boxes(g_mass, 5, n_mass);
    if (!loads.empty()) take_loads(setup, half_width, loads);
    Field<2> const field(setup, time, dt);
    setup.frame ? move_nodes<true>(setup, field, dt, outcome) : move_nodes<false>(setup, field, dt, outcome);
    if (!loads.empty()) book_loads(setup, dt, outcome);
    if (grains.any()) touch_grains(setup, time, dt, grains, outcome);
    hold_nodes(setup, time, outcome);
    auto const [low, high] = room_of<2>(setup);
    Room const room{{low[0], low[1]}, {high[0], high[1]}};
    each_chunk([&](Chunk& c) {
        auto const moved = setup.frame ? to_points<affine, musl, true>(points_, c.begin, c.end, setup, field,
                                                                       half_width, dt, room, c.planes, nodes_)
                                       : to_points<affine, musl, false>(points_, c.begin, c.end, setup, field,
                                                                        half_width, dt, room, c.planes, nodes_);
        c.outcome.kinetic_after = moved.kinetic;
        c.outcome.field = moved.field;
        c.outcome.all_inside = moved.inside;
    });
    set_strain_velocities(setup, outcome);
    bool const gathered = musl || outcome.light_nodes > 0;
    each_chunk([&](Chunk& c) {
        gathered ? gradients<true, shared>(points_, c.begin, c.end, setup, half_width, dt, c.planes, nodes_)
                 : gradients<false, shared>(points_, c.begin, c.end, setup, half_width, dt, c.planes, nodes_);
    });
    if constexpr (shared) share_mean(g_volume, n_volume, n_value, n_mean);
    if (auto const* law = std::get_if<MohrCoulomb>(&setup.law))
        deform<affine, shared>(dt, PackedMohrCoulomb(*law));
    else
        deform<affine, shared>(dt, PackedElastic(std::get<LinearElastic>(setup.law)));
}

bool PackedStep::step(Setup<2> const& setup, double time, std::int64_t steps, double dt, std::span<Vec<2> const> loads,
                      GrainContacts<2>& grains, Outcome& outcome)
{
    std::optional<sluice::Team::Awake> awake;
    if (threads_ > 1) awake.emplace(*team_);
    if (steps % sorted_every == 0) sort(setup);
    if (!lay_out(setup)) return false;
    outcome = {};
    auto const pick = [&]<bool affine, bool musl>() {
        setup.shared_volume ? run<affine, musl, true>(setup, time, dt, loads, grains, outcome)
                            : run<affine, musl, false>(setup, time, dt, loads, grains, outcome);
    };
    bool const musl = setup.scheme == Scheme::musl;
    if (setup.affine)
        musl ? pick.template operator()<true, true>() : pick.template operator()<true, false>();
    else
        musl ? pick.template operator()<false, true>() : pick.template operator()<false, false>();
    for (Chunk const& c : chunks_) {
        Outcome const& o = c.outcome;
        outcome.kinetic_before += o.kinetic_before, outcome.kinetic_after += o.kinetic_after;
        outcome.field += o.field, outcome.stress += o.stress;
        outcome.booked.plastic += o.booked.plastic;
        outcome.speed = std::max(outcome.speed, o.speed);
        outcome.all_inside &= o.all_inside, outcome.all_upright &= o.all_upright;
    }
    return true;
}

}  // namespace mpm
