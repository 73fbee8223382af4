#include "participants/mpm/packed_nodes.hpp"

#include <algorithm>
#include <cmath>

#include "participants/mpm/cell.hpp"
#include "participants/mpm/room.hpp"
#include "participants/mpm/walls.hpp"

namespace mpm {

template <int D>
void PackedNodes<D>::lay_out(Planes<D> const& box, Setup<D> const& setup)
{
    planes_ = box;
    rounds_ = {{}};
    for (std::size_t a = 0; a < D; ++a) {
        period_[a] = setup.period[static_cast<int>(a)] > 0 ? setup.cells[a] : 0;
        if (period_[a] == 0) continue;
        std::vector<std::array<int, D>> all;
        for (int const way : {-1, 0, 1})
            for (auto round : rounds_) {
                round[a] = way * period_[a];
                all.push_back(round);
            }
        rounds_ = all;
    }
    std::size_t const nodes = box.nodes();
    planes_.plane = nodes + 4;
    if (numbers_.size() < T::count * planes_.plane) numbers_.resize(T::count * planes_.plane);
    planes_.data = numbers_.data();
    for (std::size_t k = 0; k < T::count; ++k) std::fill_n(planes_[k] + nodes, 4, 0.0);
    slices_.resize(static_cast<std::size_t>(box.count[D - 1]));
    std::size_t const each = nodes / slices_.size();
    for (std::size_t s = 0; s < slices_.size(); ++s) {
        slices_[s].begin = s * each, slices_[s].end = (s + 1) * each;
        slices_[s].sums = {};
    }
    leave_out({});
}

template <int D>
typename PackedNodes<D>::Sums PackedNodes<D>::sums() const
{
    Sums all;
    for (Slice const& s : slices_) all.add(s.sums);
    return all;
}

template <int D>
void PackedNodes<D>::leave_out(std::span<NodeBox<D> const> boxes)
{
    bool const all = rounds_.size() == 1 && boxes.empty();
    counted_.assign(all ? 0 : planes_.nodes(), 1);
    auto const leave = [&](NodeBox<D> const& part) {
        planes_.each_row(part, [&](std::size_t row, std::size_t length) { std::fill_n(&counted_[row], length, 0); });
    };
    for (std::size_t a = 0; a < D && !all; ++a) {  // the same nodes once more
        if (period_[a] == 0) continue;
        NodeBox<D> again = planes_;
        again.first[a] += period_[a], again.count[a] -= period_[a];
        leave(again);
    }
    for (NodeBox<D> const& box : boxes)
        for (auto const& round : rounds_) leave(common<D>(planes_, box.moved(round)));
}

template <int D>
void PackedNodes<D>::add(std::size_t slice, std::span<Planes<D> const> boxes, std::size_t from, std::size_t count)
{
    Slice const& own = slices_[slice];
    for (std::size_t q = from; q < from + count; ++q) std::fill(planes_[q] + own.begin, planes_[q] + own.end, 0.0);
    int const line = planes_.first[D - 1] + static_cast<int>(slice);
    for (Planes<D> const& box : boxes)
        for (auto const& round : rounds_) add_box(line, box, round, from, count);
}

//! Of the nodes `round` beyond those of a line.
template <int D>
void PackedNodes<D>::add_box(int line, Planes<D> const& box, std::array<int, D> const& round, std::size_t from,
                             std::size_t count)
{
    std::array<int, D> low, high;
    for (std::size_t a = 0; a < D; ++a) {
        low[a] = std::max(planes_.first[a], box.first[a] - round[a]);
        high[a] = std::min(planes_.first[a] + planes_.count[a], box.first[a] + box.count[a] - round[a]);
    }
    if (line < low[D - 1] || line >= high[D - 1] || low[0] >= high[0]) return;
    low[D - 1] = line, high[D - 1] = line + 1;
    std::array<int, D> row = low, given;
    int const last = D == 2 ? low[1] + 1 : high[1];
    for (; row[1] < last; ++row[1]) {
        for (std::size_t a = 0; a < D; ++a) given[a] = row[a] + round[a];
        std::size_t const in = box.at(given), out = planes_.at(row);
        for (std::size_t q = from; q < from + count; ++q) {
            double const* const give = box[q] + in;
            double* const take = planes_[q] + out;
            for (int i = 0; i < high[0] - low[0]; ++i) take[i] += give[i];
        }
    }
}

template <int D>
void PackedNodes<D>::take_mean(std::size_t slice)
{
    double const *volume = planes_[T::volume], *value = planes_[T::value];
    for (std::size_t i = slices_[slice].begin; i < slices_[slice].end; ++i)
        planes_[T::mean][i] = volume[i] > 0 ? value[i] / volume[i] : 0;
}

template <int D>
void PackedNodes<D>::add_loads(std::size_t slice)
{
    for (std::size_t a = 0; a < D; ++a)
        for (std::size_t i = slices_[slice].begin; i < slices_[slice].end; ++i)
            planes_[T::force + a][i] += planes_[T::again + a][i];
}

template <int D>
void PackedNodes<D>::book_loads(std::size_t slice, Setup<D> const& setup, double dt)
{
    double const undamped = std::exp(setup.damping * dt);
    Slice& own = slices_[slice];
    for (std::size_t i = own.begin; i < own.end; ++i) {
        if (planes_[T::mass][i] <= 0 || !counts(i)) continue;
        Vec<D> const speeds = vector_at(T::before, i) + undamped * vector_at(T::velocity, i);
        own.sums.external.add(0.5 * dt * vector_at(T::again, i).dot(speeds));
    }
}

template <int D>
template <bool turning>
void PackedNodes<D>::move(std::size_t slice, Setup<D> const& setup, Field<D> const& field, double dt)
{
    double const kept = std::exp(-setup.damping * dt), least = light_mass(setup);
    Vec<D> const gravity = setup.gravity;
    Slice& own = slices_[slice];
    std::int64_t light = 0, reached = 0;
    for (std::size_t i = own.begin; i < own.end; ++i) {
        double const m = planes_[T::mass][i];
        if (m <= 0) {
            for (std::size_t q = T::velocity; q < T::mean; ++q) planes_[q][i] = 0;
            continue;
        }
        Vec<D> before = vector_at(T::momentum, i) / m, v = vector_at(T::force, i) / m;
        if constexpr (turning) {
            Vec<D> const half = 0.5 * dt * (v + field.acceleration(corner_of<D>(setup, planes_.index(i))));
            v = field.turned(before + half) + half;
            before = field.turned(before);
        } else {
            v = before + dt * (v + gravity);
        }
        bool const counted = counts(i);
        v *= kept;
        set(T::before, i, before), set(T::velocity, i, v), set(T::change, i, v - before);
        light += counted && m < least;
        reached += counted;
    }
    own.sums.light = light;
    own.sums.reached = reached;
}

template <int D>
void PackedNodes<D>::show(std::span<TouchedNode<D>> touched) const
{
    for (TouchedNode<D>& node : touched) {
        if (!planes_.has(node.index)) continue;
        std::size_t const i = planes_.at(node.index);
        node.mass = planes_[T::mass][i];
        node.before = vector_at(T::before, i), node.velocity = vector_at(T::velocity, i);
    }
}

template <int D>
void PackedNodes<D>::take(std::span<TouchedNode<D> const> touched)
{
    for (TouchedNode<D> const& node : touched) {
        if (!planes_.has(node.index)) continue;
        std::size_t const i = planes_.at(node.index);
        set(T::velocity, i, node.velocity), set(T::change, i, node.velocity - node.before);
    }
}

template <int D>
void PackedNodes<D>::hold(std::size_t slice, Setup<D> const& setup, double time, double dt)
{
    Slice& own = slices_[slice];
    own.gripped.clear();
    for (Wall const& wall : setup.walls) {
        if (wall.removed_at <= time || wall.kind == WallKind::open || wall.kind == WallKind::joined) continue;
        auto const axis = static_cast<std::size_t>(wall.axis);
        std::array<int, D> low = planes_.first, high;
        for (std::size_t a = 0; a < D; ++a) high[a] = low[a] + planes_.count[a];
        low[D - 1] += static_cast<int>(slice), high[D - 1] = low[D - 1] + 1;
        int const line = line_of(wall, setup);
        wall.side < 0 ? high[axis] = std::min(high[axis], line + 1) : low[axis] = std::max(low[axis], line);
        if (low[axis] >= high[axis]) continue;
        std::array<int, D> row = low;
        int const rows = D == 2 ? 1 : high[1] - low[1];
        for (int y = 0; y < rows; ++y) {
            if constexpr (D == 3) row[1] = low[1] + y;
            std::size_t const first = planes_.at(row), count = static_cast<std::size_t>(high[0] - low[0]);
            for (std::size_t i = first; i < first + count; ++i)
                if (planes_[T::mass][i] > 0) hold_node(i, wall, own);
        }
    }
    if (setup.damping > 0) book_damping(own, 0.5 * std::expm1(2 * setup.damping * dt));
}

//! `share`: of mass x the square of what is left of the velocity.
template <int D>
void PackedNodes<D>::book_damping(Slice& slice, double share) const
{
    for (std::size_t i = slice.begin; i < slice.end; ++i)
        if (planes_[T::mass][i] > 0 && counts(i))
            slice.sums.damped.add(share * planes_[T::mass][i] * vector_at(T::velocity, i).squaredNorm());
}

template <int D>
void PackedNodes<D>::hold_node(std::size_t i, Wall const& wall, Slice& slice)
{
    Vec<D> const before = vector_at(T::before, i);
    Vec<D> v = vector_at(T::velocity, i), rubbed = v;
    Grip const grip = mpm::hold<D>(wall, v);
    if (grip == Grip::none) return;
    slice.gripped.push_back({i, wall.axis, grip});
    set(T::velocity, i, v), set(T::change, i, v - before);
    if (wall.kind != WallKind::rough || !counts(i)) return;
    rubbed -= v;
    rubbed[wall.axis] = 0;
    slice.sums.sliding.add(0.5 * planes_[T::mass][i] * rubbed.dot(before + v));
}

template <int D>
void PackedNodes<D>::set_strain_velocities(std::size_t slice)
{
    Slice const& own = slices_[slice];
    double const* const mass = planes_[T::mass];
    for (std::size_t a = 0; a < D; ++a)
        for (std::size_t i = own.begin; i < own.end; ++i)
            if (mass[i] > 0) planes_[T::strain + a][i] = planes_[T::again + a][i] / mass[i];
    for (Gripped const& g : own.gripped) {
        Vec<D> u = vector_at(T::strain, g.node);
        hold_again<D>(g.axis, g.grip, u);
        set(T::strain, g.node, u);
    }
}

template <int D>
void PackedNodes<D>::pass_light_nodes(std::size_t slice, Setup<D> const& setup)
{
    double const least = light_mass(setup);
    for (std::size_t i = slices_[slice].begin; i < slices_[slice].end; ++i)
        set(T::strain, i, vector_at(planes_[T::mass][i] < least ? T::before : T::velocity, i));
}

template class PackedNodes<2>;
template class PackedNodes<3>;
template void PackedNodes<2>::move<false>(std::size_t, Setup<2> const&, Field<2> const&, double);
template void PackedNodes<2>::move<true>(std::size_t, Setup<2> const&, Field<2> const&, double);
template void PackedNodes<3>::move<false>(std::size_t, Setup<3> const&, Field<3> const&, double);
template void PackedNodes<3>::move<true>(std::size_t, Setup<3> const&, Field<3> const&, double);

}  // namespace mpm
