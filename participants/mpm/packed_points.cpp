#include "participants/mpm/packed_points.hpp"

#include <numeric>

namespace mpm {
namespace {

//! each(column, where it lies in a point)
template <class P, class Each>
void each_number(P& p, Each&& each)
{
    using C = PackedPoints;
    auto& m = p.matter;
    each(C::x, p.place[0]), each(C::y, p.place[1]);
    each(C::vx, p.velocity[0]), each(C::vy, p.velocity[1]);
    each(C::lxx, p.slope(0, 0)), each(C::lxy, p.slope(0, 1)), each(C::lyx, p.slope(1, 0)), each(C::lyy, p.slope(1, 1));
    each(C::mass, p.mass), each(C::volume, p.volume), each(C::ratio, m.ratio);
    each(C::sxx, m.stress(0, 0)), each(C::syy, m.stress(1, 1)), each(C::szz, m.stress(2, 2));
    each(C::sxy, m.stress(0, 1));
    each(C::fxx, m.gradient(0, 0)), each(C::fxy, m.gradient(0, 1));
    each(C::fyx, m.gradient(1, 0)), each(C::fyy, m.gradient(1, 1));
    each(C::strain, m.plastic_strain), each(C::gap, m.gap);
}

}  // namespace

void PackedPoints::take(State<2> const& state)
{
    std::size_t const n = state.points.size(), filled = (n + 3) / 4 * 4;
    order_ = state.order;
    if (order_.size() != n) {
        order_.resize(n);
        std::iota(order_.begin(), order_.end(), 0);
    }
    for (auto& column : column_) column.assign(filled, 0.0);
    for (std::size_t k = 0; k < n; ++k)
        each_number(state.points[static_cast<std::size_t>(order_[k])],
                    [&](Column c, double value) { column_[c][k] = value; });
}

void PackedPoints::give(State<2>& state, bool slopes) const
{
    state.order = order_;
    for (std::size_t k = 0; k < order_.size(); ++k) {
        Point<2>& p = state.points[static_cast<std::size_t>(order_[k])];
        each_number(p, [&](Column c, double& value) { value = column_[c][k]; });
        p.matter.stress(1, 0) = p.matter.stress(0, 1);
        if (!slopes) p.slope.setZero();
    }
}

void PackedPoints::place_fillers()
{
    for (std::size_t k = size(); k < column_[x].size(); ++k) {
        for (auto& column : column_) column[k] = 0;
        for (Column c : {x, y}) column_[c][k] = column_[c][size() - 1];
        for (Column c : {ratio, fxx, fyy}) column_[c][k] = 1;
    }
}

void PackedPoints::sort(std::span<std::uint32_t const> keys, std::size_t key_count)
{
    std::vector<std::uint32_t> next(key_count + 1, 0), to(keys.size());
    for (std::uint32_t const key : keys) ++next[key + 1];
    for (std::size_t k = 1; k <= key_count; ++k) next[k] += next[k - 1];
    for (std::size_t k = 0; k < keys.size(); ++k) to[k] = next[keys[k]]++;
    std::vector<double> sorted(column_[x].size(), 0.0);
    for (std::size_t c = 0; c < columns_kept; ++c) {
        for (std::size_t k = 0; k < to.size(); ++k) sorted[to[k]] = column_[c][k];
        column_[c].swap(sorted);
    }
    std::vector<std::int32_t> order(order_.size());
    for (std::size_t k = 0; k < to.size(); ++k) order[to[k]] = order_[k];
    order_.swap(order);
}

}  // namespace mpm
