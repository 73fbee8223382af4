#include "participants/lbm/body_cells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lbm {
namespace {

//! The cells along an axis whose centre k + 1/2 is within a body: the lowest and the highest.
template <int D>
std::array<std::ptrdiff_t, 2> within(Body<D> const& b, std::size_t axis)
{
    return {static_cast<std::ptrdiff_t>(std::ceil(b.centre[axis] - b.radius - 0.5)),
            static_cast<std::ptrdiff_t>(std::floor(b.centre[axis] + b.radius - 0.5))};
}

}  // namespace

template <int D>
BodyCells<D>::BodyCells(Domain<D> const& domain, std::array<bool, 3> periodic)
    : cells_(domain.whole().cells()), periodic_(periodic), begin_(domain.begin()), end_(domain.end())
{
    std::ptrdiff_t const layers = cells_[D - 1], below = domain.peers() && domain.peers()->count() > 1 ? 1 : 0;
    if (periodic_[D - 1]) {
        known_ = std::min(end_ - begin_ + 2 * below, layers);
        lowest_ = wrap(begin_ - below, layers);
    } else {
        lowest_ = std::max<std::ptrdiff_t>(begin_ - below, 0);
        known_ = std::min(end_ + below, layers) - lowest_;
    }
    std::ptrdiff_t const in_layer = cells_[0] * (D == 2 ? 1 : cells_[1]);
    owner_.assign(static_cast<std::size_t>(known_ * in_layer), nobody);
    for (std::size_t q = 0; q < offset_.size(); ++q) {
        auto const& c = Lattice<D>::c[q];
        offset_[q] = (D == 2 ? c[1] : c[2] * cells_[1] + c[1]) * cells_[0] + c[0];
    }
    first_here_ = static_cast<std::size_t>(place(begin_) * in_layer);
}

template <int D>
std::array<std::ptrdiff_t, 2> BodyCells<D>::reach(Body<D> const& body) const noexcept
{
    auto const [low, high] = within(body, D - 1);
    return {low - 1, high + 2};
}

template <int D>
void BodyCells<D>::restart(std::span<Body<D> const> bodies)
{
    std::ranges::fill(owner_, nobody);
    list(bodies);
    left_.clear();
}

template <int D>
void BodyCells<D>::move(std::span<Body<D> const> bodies)
{
    std::swap(old_runs_, runs_);
    std::swap(old_first_, first_);
    for (Run const& run : old_runs_)
        std::fill_n(owner_.begin() + static_cast<std::ptrdiff_t>(index(run.first.at)), run.count, vacated);
    list(bodies);
    left_.clear();
    for (std::size_t i = 0; i + 1 < old_first_.size(); ++i)
        for (std::size_t r = old_first_[i]; r < old_first_[i + 1]; ++r)
            each_cell(old_runs_[r], [&](Cell const& cell) {
                if (owner(cell.at) == vacated) left_.push_back({static_cast<std::int32_t>(i), cell});
            });
}

template <int D>
void BodyCells<D>::settle()
{
    for (Changed const& change : left_) owner_[index(change.cell.at)] = nobody;
}

template <int D>
void BodyCells<D>::list(std::span<Body<D> const> bodies)
{
    runs_.clear();
    first_.assign(1, 0);
    entered_.clear();
    count_here_ = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        auto const [begin, end] = within(bodies[i], D - 1);
        auto const body = static_cast<std::int32_t>(i);
        for (std::ptrdiff_t layer = begin; layer <= end; ++layer) {
            Extent at{0, layer, layer};
            if (!bring_in(at, D - 1) || !is_known(at)) continue;
            if constexpr (D == 2)
                list_row(body, bodies[i], {0, layer, 0});
            else
                for (auto [y, top] = within(bodies[i], 1); y <= top; ++y) list_row(body, bodies[i], {0, y, layer});
        }
        first_.push_back(runs_.size());
    }
}

//! The cells of a row within a body that no body before it has.
template <int D>
void BodyCells<D>::list_row(std::int32_t body, Body<D> const& b, Extent at)
{
    Cell cell{.at = {}, .layer = at[D - 1], .arm = {}};
    double square = b.radius * b.radius;
    for (std::size_t k = 1; k < D; ++k) {
        cell.arm[k] = static_cast<double>(at[k]) + 0.5 - b.centre[k];
        square -= cell.arm[k] * cell.arm[k];
        if (!bring_in(at, k)) return;
    }
    if (square < 0) return;
    double const half = std::sqrt(square);
    auto const end = static_cast<std::ptrdiff_t>(std::floor(b.centre[0] + half - 0.5));
    for (auto x = static_cast<std::ptrdiff_t>(std::ceil(b.centre[0] - half - 0.5)); x <= end; ++x) {
        at[0] = x;
        if (!bring_in(at, 0)) continue;
        cell.at = at;
        cell.arm[0] = static_cast<double>(x) + 0.5 - b.centre[0];
        own(body, cell);
    }
}

template <int D>
void BodyCells<D>::own(std::int32_t body, Cell const& cell)
{
    std::int32_t& owner = owner_[index(cell.at)];
    if (owner >= 0) return;
    bool const here = is_here(cell.at);
    if (owner == nobody && here) entered_.push_back({body, cell});
    owner = body;
    count_here_ += here;
    if (runs_.size() > first_.back()) {
        Run& last = runs_.back();
        bool const same_row = last.first.at[1] == cell.at[1] && last.first.at[2] == cell.at[2];
        if (same_row && last.first.at[0] + last.count == cell.at[0]) {
            ++last.count;
            return;
        }
    }
    runs_.push_back({cell, 1});
}

template class BodyCells<2>;
template class BodyCells<3>;

}  // namespace lbm
