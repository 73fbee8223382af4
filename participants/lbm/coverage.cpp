#include "participants/lbm/coverage.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/sphere_volume.hpp"

namespace lbm {
namespace {

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
Coverage<D>::Coverage(Domain<D> const& domain, std::array<bool, 3> periodic, std::vector<Patch<D>> patches)
    : domain_(&domain),
      layout_(&domain.own()),
      periodic_(periodic),
      row_start_(static_cast<std::size_t>(layout_->rows()) + 1)
{
    std::vector<std::size_t> offsets;
    for (Patch<D> const& patch : patches) add_patch(patch, offsets);
    for (std::size_t k = 0; k < offsets.size(); ++k) patch_strips_[k].fraction = patch_fraction_.data(offsets[k]);
    lay_out({});
    sort_by_row();
}

//! One strip for each row and each part of it that is stored here, from its first cell with solid to its last.
template <int D>
void Coverage<D>::add_patch(Patch<D> const& patch, std::vector<std::size_t>& offsets)
{
    auto const index = static_cast<std::ptrdiff_t>(patches_.size());
    Extent low, high;
    for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::max<std::ptrdiff_t>(0, patch.first[k]);
        high[k] = std::min(patch.first[k] + patch.size[k], layout_->cells()[k]);
    }
    Kept kept{.centre = patch.centre, .layers = {low[D - 1], high[D - 1]}};
    auto const each_strip = [&](Layout const& layout, std::ptrdiff_t y, std::ptrdiff_t z, auto&& visit) {
        double const* const fraction = patch.row(y, z) - patch.first[0];
        for (std::uint32_t const r : layout.across(y, z)) {
            Row const& row = layout.row(r);
            std::ptrdiff_t begin = std::max<std::ptrdiff_t>(low[0], row.first),
                           end = std::min<std::ptrdiff_t>(high[0], row.first + row.cells);
            while (begin < end && fraction[begin] == 0) ++begin;
            while (begin < end && fraction[end - 1] == 0) --end;
            if (begin >= end) continue;
            std::array<double, D> arm;
            Extent const cell{begin, y, z};
            for (std::size_t k = 0; k < D; ++k) arm[k] = static_cast<double>(cell[k]) + 0.5 - patch.centre[k];
            visit(Strip<D>{index, r, begin - row.first, end - begin, fraction + begin, arm, patch.drag});
        }
    };
    for (std::ptrdiff_t z = low[2]; z < high[2]; ++z)
        for (std::ptrdiff_t y = low[1]; y < high[1]; ++y) {
            each_strip(domain_->whole(), y, z, [&](Strip<D> const& s) {
                for (std::ptrdiff_t x = 0; x < s.count; ++x) {
                    kept.volume += s.fraction[x];
                    for (std::size_t k = 0; k < D; ++k)
                        kept.first_moment[k] += s.fraction[x] * (s.arm[k] + (k == 0 ? static_cast<double>(x) : 0.0));
                }
            });
            each_strip(*layout_, y, z, [&](Strip<D> const& s) {
                std::vector<double> padded(s.fraction, s.fraction + s.count);
                padded.resize(padded.size() + strip_lanes - 1, 0.0);
                offsets.push_back(patch_fraction_.add(padded));
                patch_strips_.push_back(s);
            });
        }
    patch_start_.push_back(patch_strips_.size());
    patches_.push_back(kept);
}

template <int D>
bool Coverage<D>::has_all_of(std::size_t i) const noexcept
{
    auto const [begin, end] = i < shape_.size() ? shape_[i].layers() : patches_[i - shape_.size()].layers;
    return domain_->has_layers(begin, end);
}

//! Whether a body may cover cells of this process.
template <int D>
bool Coverage<D>::is_near(Shape const& shape) const noexcept
{
    auto const [begin, end] = shape.layers();
    bool const wraps = periodic_[D - 1] && (begin < 0 || end > layout_->cells()[D - 1]);
    return wraps || (begin < domain_->end() && end > domain_->begin());
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
        std::size_t const turns = periodic_[0] ? 2 + side / static_cast<std::size_t>(layout_->cells()[0]) : 1;
        box_start_[i] = cells;
        first_[i] = strips;
        room_[i] = rows * turns * layout_->most_across();
        cells += rows * row_length(bodies[i].radius);
        strips += room_[i];
    }
    fraction_.resize(cells);
    strips_.resize(strips + patch_strips_.size());
    for (std::size_t p = 0; p < patches_.size(); ++p) {
        first_[n + p] = strips + patch_start_[p];
        count_[n + p] = room_[n + p] = patch_start_[p + 1] - patch_start_[p];
    }
    std::copy(patch_strips_.begin(), patch_strips_.end(), strips_.begin() + static_cast<std::ptrdiff_t>(strips));
    for (std::size_t k = strips; k < strips_.size(); ++k) strips_[k].body += static_cast<std::ptrdiff_t>(n);
    row_of_strip_.resize(strips_.size());
    for (std::size_t k = strips; k < strips_.size(); ++k) row_of_strip_[k] = static_cast<std::uint32_t>(strips_[k].row);
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
    bool const same = same_layout();
    if (!same) {
        lay_out(bodies);
        shape_.assign(bodies.size(), Shape{{}, NAN});
    }
    std::atomic<std::ptrdiff_t> changed = 0;
    team.share(static_cast<std::ptrdiff_t>(bodies.size()), 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            Shape const now{bodies[i].centre, bodies[i].radius};
            if (shape_[i] == now) continue;
            shape_[i] = now;
            count_[i] = 0;
            if (is_near(now)) cover(i, bodies[i]);
            changed.fetch_add(1, std::memory_order_relaxed);
        }
    });
    if (changed > 0 || !same) sort_by_row();
    return changed;
}

//! Rasterises body i and lists its strips, clipped to the domain or wrapped around it.
template <int D>
void Coverage<D>::cover(std::size_t i, Body<D> const& body)
{
    Extent const& cells = layout_->cells();
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
            if (periodic_[k]) at[k] = wrap(at[k], cells[k]);
            inside = inside && at[k] >= 0 && at[k] < cells[k];
        }
        if (!inside) continue;
        count_[i] += add_strips(first_[i] + count_[i],
                                {static_cast<std::ptrdiff_t>(i), 0, at[0], end - begin,
                                 fraction.data() + row * stride + begin, arm, drag_of_curvature<D>(1 / body.radius)},
                                at[1], at[2]);
    }
}

//! Writes the parts that are stored of a strip in a row (y, z) of the lattice to strips_[at...]; returns how many there
//! are. Its begin is that in the lattice.
template <int D>
std::size_t Coverage<D>::add_strips(std::size_t at, Strip<D> const& whole, std::ptrdiff_t y, std::ptrdiff_t z)
{
    std::ptrdiff_t const nx = layout_->cells()[0];
    if (!periodic_[0]) return add_within_lattice(at, whole, y, z);
    Strip<D> strip = whole;
    std::size_t parts = 0;
    while (strip.count > 0) {
        Strip<D> part = strip;
        part.begin = wrap(strip.begin, nx);
        part.count = std::min(strip.count, nx - part.begin);
        parts += add_within_lattice(at + parts, part, y, z);
        strip.begin += part.count;
        strip.count -= part.count;
        strip.fraction += part.count;
        strip.arm[0] += static_cast<double>(part.count);
    }
    return parts;
}

template <int D>
std::size_t Coverage<D>::add_within_lattice(std::size_t at, Strip<D> const& strip, std::ptrdiff_t y, std::ptrdiff_t z)
{
    std::size_t parts = 0;
    for (std::uint32_t const r : layout_->across(y, z)) {
        Row const& row = layout_->row(r);
        std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(strip.begin, row.first),
                             end = std::min<std::ptrdiff_t>(strip.begin + strip.count, row.first + row.cells),
                             skipped = begin - strip.begin;
        if (begin >= end) continue;
        Strip<D>& part = strips_[at + parts];
        part.body = strip.body;
        part.row = r;
        part.begin = begin - row.first;
        part.count = end - begin;
        part.fraction = strip.fraction + skipped;
        for (std::size_t k = 0; k < D; ++k) part.arm[k] = strip.arm[k];
        part.arm[0] += static_cast<double>(skipped);
        part.drag = strip.drag;
        row_of_strip_[at + parts++] = r;
    }
    return parts;
}

//! Counting sort: by row, and within a row by body.
template <int D>
void Coverage<D>::sort_by_row()
{
    std::fill(row_start_.begin(), row_start_.end(), 0U);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k) ++row_start_[row_of_strip_[k] + 1];
    for (std::size_t r = 1; r < row_start_.size(); ++r) row_start_[r] += row_start_[r - 1];
    by_row_.resize(row_start_.back());
    std::vector<std::uint32_t> next(row_start_.begin(), row_start_.end() - 1);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k)
            by_row_[next[row_of_strip_[k]]++] = static_cast<std::uint32_t>(k);
}

template class Coverage<2>;
template class Coverage<3>;

}  // namespace lbm
