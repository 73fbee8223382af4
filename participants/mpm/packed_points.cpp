#include "participants/mpm/packed_points.hpp"

#include <algorithm>
#include <numeric>

namespace mpm {
namespace {

//! each(column, where it lies in a point)
template <int D, class P, class Each>
void each_number(P& p, Each&& each)
{
    using C = PackedColumns<D>;
    auto& m = p.matter;
    for (int a = 0; a < D; ++a) {
        auto const k = static_cast<std::size_t>(a);
        each(C::place + k, p.place[a]), each(C::velocity + k, p.velocity[a]);
        for (int b = 0; b < D; ++b) {
            auto const at = static_cast<std::size_t>(a * D + b);
            each(C::slope + at, p.slope(a, b)), each(C::gradient + at, m.gradient(a, b));
        }
    }
    if (D == 2) each(C::around, m.gradient(2, 2));
    each(C::mass, p.mass), each(C::volume, p.volume), each(C::ratio, m.ratio);
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < std::max(D, i + 1); ++j) each(C::stress + PackStress<D>::at(i, j), m.stress(i, j));
    each(C::strain, m.plastic_strain), each(C::gap, m.gap);
}

}  // namespace

template <int D>
void PackedPoints<D>::resize(std::size_t count)
{
    order_.resize(count);
    for (auto& column : column_) column.assign((count + 3) / 4 * 4, 0.0);
}

template <int D>
void PackedPoints<D>::take(State<D> const& state, std::size_t begin, std::size_t end)
{
    resize(end - begin);
    if (state.order.size() == state.points.size())
        std::copy_n(state.order.begin() + static_cast<std::ptrdiff_t>(begin), end - begin, order_.begin());
    else
        std::iota(order_.begin(), order_.end(), static_cast<std::int32_t>(begin));
    for (std::size_t k = 0; k < order_.size(); ++k)
        each_number<D>(state.points[static_cast<std::size_t>(order_[k])],
                       [&](std::size_t c, double value) { column_[c][k] = value; });
}

template <int D>
void PackedPoints<D>::give(State<D>& state, std::size_t begin, bool slopes) const
{
    state.order.resize(state.points.size());
    std::copy(order_.begin(), order_.end(), state.order.begin() + static_cast<std::ptrdiff_t>(begin));
    for (std::size_t k = 0; k < order_.size(); ++k) {
        Point<D>& p = state.points[static_cast<std::size_t>(order_[k])];
        each_number<D>(p, [&](std::size_t c, double& value) { value = column_[c][k]; });
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < i; ++j) p.matter.stress(i, j) = p.matter.stress(j, i);
        if (!slopes) p.slope.setZero();
    }
}

template <int D>
void PackedPoints<D>::add_row(std::size_t k, std::vector<double>& rows) const
{
    rows.push_back(order_[k]);
    for (std::size_t c = 0; c < C::kept; ++c) rows.push_back(column_[c][k]);
}

template <int D>
void PackedPoints<D>::set_row(std::size_t k, double const* numbers)
{
    order_[k] = static_cast<std::int32_t>(numbers[0]);
    for (std::size_t c = 0; c < C::kept; ++c) column_[c][k] = numbers[1 + c];
}

template <int D>
void PackedPoints<D>::place_fillers()
{
    for (std::size_t k = size(); k < column_[C::place].size(); ++k) {
        for (auto& column : column_) column[k] = 0;
        for (std::size_t a = 0; a < D; ++a) {
            column_[C::place + a][k] = column_[C::place + a][size() - 1];
            column_[C::gradient + a * D + a][k] = 1;
        }
        column_[C::ratio][k] = column_[C::around][k] = 1;
    }
}

template <int D>
void PackedPoints<D>::move(std::span<std::uint32_t const> to)
{
    std::vector<double> moved(column_[C::place].size(), 0.0);
    for (std::size_t c = 0; c < C::kept; ++c) {
        for (std::size_t k = 0; k < to.size(); ++k)
            if (to[k] != nowhere) moved[to[k]] = column_[c][k];
        column_[c].swap(moved);
    }
    std::vector<std::int32_t> order(order_.size());
    for (std::size_t k = 0; k < to.size(); ++k)
        if (to[k] != nowhere) order[to[k]] = order_[k];
    order_.swap(order);
}

template class PackedPoints<2>;
template class PackedPoints<3>;

}  // namespace mpm
