#include "participants/lbm/coverage.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/sphere_volume.hpp"

namespace lbm {
namespace {

constexpr std::ptrdiff_t wrap(std::ptrdiff_t i, std::ptrdiff_t n)
{
    return (i % n + n) % n;
}

std::size_t box_side(double radius)
{
    return static_cast<std::size_t>(2 * radius) + 3;
}
//! Of a row of a body's fractions.
std::size_t row_length(double radius)
{
    return box_side(radius) + strip_lanes - 1;
}

}  // namespace

template <int D>
Coverage<D>::Coverage(Extent cells, std::array<bool, 3> periodic)
    : cells_(cells), periodic_(periodic), row_start_(static_cast<std::size_t>(cells[1] * cells[2]) + 1)
{}

template <int D>
void Coverage<D>::set_patches(std::vector<Patch<D>> patches)
{
    patches_ = std::move(patches);
    for (Patch<D>& patch : patches_) {
        auto const length = static_cast<std::size_t>(patch.size[0]), stride = length + strip_lanes - 1;
        auto const rows = static_cast<std::size_t>(patch.size[1] * patch.size[2]);
        std::vector<double> padded(rows * stride, 0.0);
        for (std::size_t r = 0; r < rows; ++r)
            std::copy_n(patch.fraction.data() + r * length, length, padded.data() + r * stride);
        patch.fraction = std::move(padded);
    }
    shape_.clear();
    lay_out({});
    sort_by_row();
}

template <int D>
std::span<std::uint32_t const> Coverage<D>::row(std::ptrdiff_t r) const noexcept
{
    std::size_t const begin = row_start_[static_cast<std::size_t>(r)],
                      end = row_start_[static_cast<std::size_t>(r) + 1];
    return {by_row_.data() + begin, end - begin};
}

//! Gives every body its place in fraction_ and strips_; patches come last.
template <int D>
void Coverage<D>::lay_out(std::span<Body<D> const> bodies)
{
    std::size_t const n = bodies.size();
    box_start_.resize(n);
    for (auto* v : {&first_, &count_, &room_}) v->assign(n + patches_.size(), 0);
    std::size_t cells = 0, strips = 0;
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t const side = box_side(bodies[i].radius), rows = D == 2 ? side : side * side;
        std::size_t const pieces = periodic_[0] ? 2 + side / static_cast<std::size_t>(cells_[0]) : 1;
        box_start_[i] = cells;
        first_[i] = strips;
        room_[i] = rows * pieces;
        cells += rows * row_length(bodies[i].radius);
        strips += room_[i];
    }
    fraction_.resize(cells);
    for (std::size_t p = 0; p < patches_.size(); ++p) {
        first_[n + p] = strips;
        room_[n + p] = static_cast<std::size_t>(patches_[p].size[1] * patches_[p].size[2]);
        strips += room_[n + p];
    }
    strips_.resize(strips);
    for (std::size_t p = 0; p < patches_.size(); ++p) lay_out_patch(n + p, patches_[p]);
}

//! One strip for each row, from its first cell with solid to its last.
template <int D>
void Coverage<D>::lay_out_patch(std::size_t index, Patch<D> const& patch)
{
    std::ptrdiff_t const stride = patch.size[0] + strip_lanes - 1;
    for (std::ptrdiff_t row = 0; row < patch.size[1] * patch.size[2]; ++row) {
        Extent const at{0, patch.first[1] + row % patch.size[1], patch.first[2] + row / patch.size[1]};
        if (at[1] < 0 || at[1] >= cells_[1] || at[2] < 0 || at[2] >= cells_[2]) continue;
        std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -patch.first[0]),
                       end = std::min(patch.size[0], cells_[0] - patch.first[0]);
        double const* const fraction = patch.fraction.data() + row * stride;
        while (begin < end && fraction[begin] == 0) ++begin;
        while (begin < end && fraction[end - 1] == 0) --end;
        if (begin >= end) continue;
        std::array<double, D> arm;
        Extent const cell{patch.first[0] + begin, at[1], at[2]};
        for (std::size_t k = 0; k < D; ++k) arm[k] = static_cast<double>(cell[k]) + 0.5 - patch.centre[k];
        strips_[first_[index] + count_[index]++] = {static_cast<std::ptrdiff_t>(index),
                                                    at[2] * cells_[1] + at[1],
                                                    cell[0],
                                                    end - begin,
                                                    fraction + begin,
                                                    arm,
                                                    patch.drag};
    }
}

template <int D>
std::ptrdiff_t Coverage<D>::update(std::span<Body<D> const> bodies, sluice::Team& team)
{
    auto const same_layout = [&] {
        if (shape_.size() != bodies.size()) return false;
        for (std::size_t i = 0; i < bodies.size(); ++i)
            if (shape_[i].radius != bodies[i].radius) return false;
        return true;
    };
    if (!same_layout()) {
        lay_out(bodies);
        shape_.assign(bodies.size(), Shape{{}, NAN});
    }
    std::atomic<std::ptrdiff_t> changed = 0;
    team.share(static_cast<std::ptrdiff_t>(bodies.size()), 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            Shape const now{bodies[i].centre, bodies[i].radius};
            if (shape_[i] == now) continue;
            shape_[i] = now;
            cover(i, bodies[i]);
            changed.fetch_add(1, std::memory_order_relaxed);
        }
    });
    if (changed > 0 || bodies.empty()) sort_by_row();
    return changed;
}

//! Rasterises body i and lists its strips, clipped to the domain or wrapped around it.
template <int D>
void Coverage<D>::cover(std::size_t i, Body<D> const& body)
{
    thread_local RasterScratch scratch;
    thread_local std::vector<std::ptrdiff_t> columns;
    SphereBox box;
    if constexpr (D == 2) {
        auto const [x0, y0, width, height] = disc_box(body.centre[0], body.centre[1], body.radius);
        box = {{x0, y0, 0}, {width, height, 1}};
    } else {
        box = sphere_box(body.centre, body.radius);
    }
    std::ptrdiff_t const rows = box.size[1] * box.size[2], stride = box.size[0] + strip_lanes - 1;
    columns.resize(static_cast<std::size_t>(2 * rows));
    std::span<double> const fraction{fraction_.data() + box_start_[i], static_cast<std::size_t>(rows * stride)};
    if constexpr (D == 2)
        rasterise(body.centre[0], body.centre[1], body.radius, {box.first[0], box.first[1], box.size[0], box.size[1]},
                  fraction, columns, scratch);
    else
        rasterise(body.centre, body.radius, box, fraction, columns);
    count_[i] = 0;
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
        auto const begin = columns[static_cast<std::size_t>(2 * row)],
                   end = columns[static_cast<std::size_t>(2 * row + 1)];
        Extent at{box.first[0] + begin, box.first[1] + row % box.size[1], box.first[2] + row / box.size[1]};
        std::array<double, D> arm;
        for (std::size_t k = 0; k < D; ++k) arm[k] = static_cast<double>(at[k]) + 0.5 - body.centre[k];
        bool inside = begin < end;
        for (std::size_t k = 1; k < D; ++k) {
            if (periodic_[k]) at[k] = wrap(at[k], cells_[k]);
            inside = inside && at[k] >= 0 && at[k] < cells_[k];
        }
        if (!inside) continue;
        count_[i] += add_strips(first_[i] + count_[i],
                                {static_cast<std::ptrdiff_t>(i), at[2] * cells_[1] + at[1], at[0], end - begin,
                                 fraction.data() + row * stride + begin, arm, drag_of_curvature<D>(1 / body.radius)});
    }
}

//! Writes the parts of a strip that lie in the domain to strips_[at...]; returns how many there are.
template <int D>
std::size_t Coverage<D>::add_strips(std::size_t at, Strip<D> strip)
{
    std::size_t parts = 0;
    std::ptrdiff_t const nx = cells_[0];
    while (strip.count > 0) {
        std::ptrdiff_t const begin = periodic_[0] ? wrap(strip.begin, nx) : std::max<std::ptrdiff_t>(strip.begin, 0);
        std::ptrdiff_t const skipped = periodic_[0] ? 0 : begin - strip.begin;
        std::ptrdiff_t const taken = std::min(strip.count - skipped, nx - begin);
        if (taken <= 0) break;
        Strip<D>& part = strips_[at + parts++] = strip;
        part.begin = begin;
        part.count = taken;
        part.fraction += skipped;
        part.arm[0] += static_cast<double>(skipped);
        if (!periodic_[0]) break;
        strip.begin += taken;
        strip.count -= taken;
        strip.fraction += taken;
        strip.arm[0] += static_cast<double>(taken);
    }
    return parts;
}

//! Counting sort: by row, and within a row by body.
template <int D>
void Coverage<D>::sort_by_row()
{
    std::fill(row_start_.begin(), row_start_.end(), 0U);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k)
            ++row_start_[static_cast<std::size_t>(strips_[k].row) + 1];
    for (std::size_t r = 1; r < row_start_.size(); ++r) row_start_[r] += row_start_[r - 1];
    by_row_.resize(row_start_.back());
    std::vector<std::uint32_t> next(row_start_.begin(), row_start_.end() - 1);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k)
            by_row_[next[static_cast<std::size_t>(strips_[k].row)]++] = static_cast<std::uint32_t>(k);
}

template class Coverage<2>;
template class Coverage<3>;

}  // namespace lbm
