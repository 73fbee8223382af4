#include "participants/lbm/coverage.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "participants/lbm/disc_area.hpp"
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/sphere_volume.hpp"

namespace lbm {
namespace {

std::size_t box_side(double radius)
{
    return static_cast<std::size_t>(2 * radius) + 3;
}
template <int D>
std::size_t list_room(double radius)
{
    return (D == 2 ? most_listed(radius) : most_listed_of_sphere(radius)) + RowCover::slack;
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
    for (std::size_t k = 0; k < offsets.size(); ++k) patch_strips_[k].listed = patch_fraction_.data(offsets[k]);
    lay_out({});
    sort_by_row();
}

//! One strip for each row and each part of it that is stored here, from its first cell with solid to its last.
template <int D>
void Coverage<D>::add_patch(Patch<D> const& patch, std::vector<std::size_t>& offsets)
{
    auto const index = static_cast<std::int32_t>(patches_.size());
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
            auto const count = static_cast<std::int32_t>(end - begin);
            RowCover const cover{static_cast<std::int32_t>(begin - row.first), count, count, 0, fraction + begin};
            visit(Strip<D>{cover, index, r, arm, patch.drag});
        }
    };
    for (std::ptrdiff_t z = low[2]; z < high[2]; ++z)
        for (std::ptrdiff_t y = low[1]; y < high[1]; ++y) {
            each_strip(domain_->whole(), y, z, [&](Strip<D> const& s) {
                for (std::ptrdiff_t x = 0; x < s.count; ++x) {
                    kept.volume += s.listed[x];
                    for (std::size_t k = 0; k < D; ++k)
                        kept.first_moment[k] += s.listed[x] * (s.arm[k] + (k == 0 ? static_cast<double>(x) : 0.0));
                }
            });
            each_strip(*layout_, y, z, [&](Strip<D> const& s) {
                std::vector<double> padded(s.listed, s.listed + s.count);
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

//! Gives every body its place in listed_ and strips_; patches come last.
template <int D>
void Coverage<D>::lay_out(std::span<Body<D> const> bodies)
{
    std::size_t const n = bodies.size();
    list_start_.resize(n);
    for (auto* v : {&first_, &count_, &room_}) v->assign(n + patches_.size(), 0);
    std::size_t listed = 0, strips = 0;
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t const side = box_side(bodies[i].radius), rows = D == 2 ? side : side * side;
        std::size_t const turns = periodic_[0] ? 2 + side / static_cast<std::size_t>(layout_->cells()[0]) : 1;
        list_start_[i] = listed;
        first_[i] = strips;
        room_[i] = rows * turns * layout_->most_across();
        listed += list_room<D>(bodies[i].radius);
        strips += room_[i];
    }
    listed_.resize(listed);
    strips_.resize(strips + patch_strips_.size());
    for (std::size_t p = 0; p < patches_.size(); ++p) {
        first_[n + p] = strips + patch_start_[p];
        count_[n + p] = room_[n + p] = patch_start_[p + 1] - patch_start_[p];
    }
    std::copy(patch_strips_.begin(), patch_strips_.end(), strips_.begin() + static_cast<std::ptrdiff_t>(strips));
    for (std::size_t k = strips; k < strips_.size(); ++k) strips_[k].body += static_cast<std::int32_t>(n);
    row_of_strip_.resize(strips_.size());
    for (std::size_t k = strips; k < strips_.size(); ++k) row_of_strip_[k] = strips_[k].row;
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
    thread_local std::vector<RowCover> covers;
    std::span<double> const listed{listed_.data() + list_start_[i], list_room<D>(body.radius)};
    SphereBox box;
    if constexpr (D == 2) {
        DiscBox const square = disc_box(body.centre[0], body.centre[1], body.radius);
        box = {{square.x0, square.y0, 0}, {square.width, square.height, 1}};
        covers.resize(static_cast<std::size_t>(square.height));
        rasterise(body.centre[0], body.centre[1], body.radius, square, listed, covers, scratch);
    } else {
        box = sphere_box(body.centre, body.radius);
        covers.resize(static_cast<std::size_t>(box.size[1] * box.size[2]));
        rasterise(body.centre, body.radius, box, listed, covers);
    }
    count_[i] = 0;
    Strip<D> strip;
    strip.body = static_cast<std::int32_t>(i);
    strip.drag = drag_of_curvature<D>(1 / body.radius);
    for (std::size_t row = 0; row < covers.size(); ++row) {
        static_cast<RowCover&>(strip) = covers[row];
        if (strip.count == 0) continue;
        auto const k = static_cast<std::ptrdiff_t>(row);
        Extent at{box.first[0] + strip.begin, box.first[1] + k % box.size[1], box.first[2] + k / box.size[1]};
        for (std::size_t axis = 0; axis < D; ++axis)
            strip.arm[axis] = static_cast<double>(at[axis]) + 0.5 - body.centre[axis];
        bool inside = true;
        for (std::size_t axis = 1; axis < D; ++axis) {
            if (periodic_[axis]) at[axis] = wrap(at[axis], cells[axis]);
            inside = inside && at[axis] >= 0 && at[axis] < cells[axis];
        }
        if (inside) count_[i] += add_strips(first_[i] + count_[i], strip, at);
    }
}

//! Writes the parts that are stored of a strip, whose first cell is `at` in the lattice along y and z and wraps around
//! along x, to strips_[first...]; returns how many there are.
template <int D>
std::size_t Coverage<D>::add_strips(std::size_t first, Strip<D> const& strip, Extent const& at)
{
    std::ptrdiff_t const nx = layout_->cells()[0];
    if (!periodic_[0]) return add_within_lattice(first, strip, at);
    std::size_t parts = 0;
    for (std::ptrdiff_t done = 0; done < strip.count;) {
        std::ptrdiff_t const begin = wrap(at[0] + done, nx),
                             end = std::min<std::ptrdiff_t>(done + nx - begin, strip.count);
        parts += add_within_lattice(first + parts, strip.part(done, end), {begin, at[1], at[2]});
        done = end;
    }
    return parts;
}

template <int D>
std::size_t Coverage<D>::add_within_lattice(std::size_t first, Strip<D> const& strip, Extent const& at)
{
    std::size_t parts = 0;
    for (std::uint32_t const r : layout_->across(at[1], at[2])) {
        Row const& row = layout_->row(r);
        std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(at[0], row.first),
                             end = std::min<std::ptrdiff_t>(at[0] + strip.count, row.first + row.cells);
        if (begin >= end) continue;
        Strip<D>& part = strips_[first + parts];
        part = strip.part(begin - at[0], end - at[0]);
        part.row = r;
        part.begin = static_cast<std::int32_t>(begin - row.first);
        row_of_strip_[first + parts++] = r;
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
