#include "participants/lbm/coverage.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

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

}  // namespace

Coverage::Coverage(std::ptrdiff_t nx, std::ptrdiff_t ny, bool periodic_x, bool periodic_y)
    : nx_(nx), ny_(ny), periodic_x_(periodic_x), periodic_y_(periodic_y), row_start_(static_cast<std::size_t>(ny) + 1)
{
    first_ = {0};
    count_ = {0};
    room_ = {0};
}

void Coverage::set_obstacle(std::vector<double> fraction)
{
    obstacle_ = std::move(fraction);
    obstacle_.resize(obstacle_.size() + strip_lanes - 1);
    shape_.clear();
    lay_out({});
    sort_by_row();
}

std::span<std::uint32_t const> Coverage::row(std::ptrdiff_t y) const noexcept
{
    std::size_t const begin = row_start_[static_cast<std::size_t>(y)],
                      end = row_start_[static_cast<std::size_t>(y) + 1];
    return {by_row_.data() + begin, end - begin};
}

//! Gives every body its place in fraction_ and strips_; the obstacle comes last.
void Coverage::lay_out(std::span<Disc const> discs)
{
    std::size_t const n = discs.size();
    box_start_.resize(n);
    first_.assign(n + 1, 0);
    count_.assign(n + 1, 0);
    room_.assign(n + 1, 0);
    std::size_t cells = 0, strips = 0;
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t const side = box_side(discs[i].radius);
        std::size_t const pieces = periodic_x_ ? 2 + side / static_cast<std::size_t>(nx_) : 1;
        box_start_[i] = cells;
        first_[i] = strips;
        room_[i] = side * pieces;
        cells += side * (side + strip_lanes - 1);
        strips += room_[i];
    }
    first_[n] = strips;
    room_[n] = obstacle_.empty() ? 0 : static_cast<std::size_t>(ny_);
    fraction_.resize(cells);
    strips_.resize(strips + room_[n]);
    for (std::size_t y = 0; y < room_[n]; ++y) {
        double const* const line = obstacle_.data() + y * static_cast<std::size_t>(nx_);
        double const* const end = line + nx_;
        double const* const begin = std::find_if(line, end, [](double f) { return f > 0; });
        if (begin == end) continue;
        strips_[first_[n] + count_[n]++] = {
            static_cast<std::ptrdiff_t>(n), static_cast<std::ptrdiff_t>(y), begin - line, end - begin, begin, 0, 0};
    }
}

std::ptrdiff_t Coverage::update(std::span<Disc const> discs, sluice::Team& team)
{
    auto const same_layout = [&] {
        if (shape_.size() != discs.size()) return false;
        for (std::size_t i = 0; i < discs.size(); ++i)
            if (shape_[i].radius != discs[i].radius) return false;
        return true;
    };
    if (!same_layout()) {
        lay_out(discs);
        shape_.assign(discs.size(), Shape{NAN, NAN, NAN});
    }
    std::atomic<std::ptrdiff_t> changed = 0;
    team.share(static_cast<std::ptrdiff_t>(discs.size()), 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            Shape const now{discs[i].x, discs[i].y, discs[i].radius};
            if (shape_[i] == now) continue;
            shape_[i] = now;
            cover(i, discs[i]);
            changed.fetch_add(1, std::memory_order_relaxed);
        }
    });
    if (changed > 0 || discs.empty()) sort_by_row();
    return changed;
}

//! Rasterises disc i and lists its strips, clipped to the domain or wrapped around it.
void Coverage::cover(std::size_t i, Disc const& disc)
{
    thread_local RasterScratch scratch;
    thread_local std::vector<std::ptrdiff_t> columns;
    DiscBox const box = disc_box(disc.x, disc.y, disc.radius);
    auto const width = static_cast<std::size_t>(box.width), height = static_cast<std::size_t>(box.height);
    columns.resize(2 * height);
    std::size_t const stride = width + strip_lanes - 1;
    std::span<double> const fraction{fraction_.data() + box_start_[i], stride * height};
    rasterise(disc.x, disc.y, disc.radius, box, fraction, columns, scratch);
    count_[i] = 0;
    for (std::size_t j = 0; j < height; ++j) {
        std::ptrdiff_t y = box.y0 + static_cast<std::ptrdiff_t>(j);
        double const arm_y = static_cast<double>(y) + 0.5 - disc.y;
        if (periodic_y_) y = wrap(y, ny_);
        if (y < 0 || y >= ny_ || columns[2 * j] >= columns[2 * j + 1]) continue;
        std::ptrdiff_t const begin = box.x0 + columns[2 * j];
        count_[i] += add_strips(
            first_[i] + count_[i],
            {static_cast<std::ptrdiff_t>(i), y, begin, columns[2 * j + 1] - columns[2 * j],
             fraction.data() + j * stride + columns[2 * j], static_cast<double>(begin) + 0.5 - disc.x, arm_y});
    }
}

//! Writes the parts of a strip that lie in the domain to strips_[at...]; returns how many there are.
std::size_t Coverage::add_strips(std::size_t at, Strip strip)
{
    std::size_t parts = 0;
    while (strip.count > 0) {
        std::ptrdiff_t const begin = periodic_x_ ? wrap(strip.begin, nx_) : std::max<std::ptrdiff_t>(strip.begin, 0);
        std::ptrdiff_t const skipped = periodic_x_ ? 0 : begin - strip.begin;
        std::ptrdiff_t const taken = std::min(strip.count - skipped, nx_ - begin);
        if (taken <= 0) break;
        strips_[at + parts++] = {
            strip.body, strip.y, begin, taken, strip.fraction + skipped, strip.arm_x + static_cast<double>(skipped),
            strip.arm_y};
        if (!periodic_x_) break;
        strip.begin += taken;
        strip.count -= taken;
        strip.fraction += taken;
        strip.arm_x += static_cast<double>(taken);
    }
    return parts;
}

//! Counting sort: by row, and within a row by body.
void Coverage::sort_by_row()
{
    std::fill(row_start_.begin(), row_start_.end(), 0U);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k)
            ++row_start_[static_cast<std::size_t>(strips_[k].y) + 1];
    for (std::size_t y = 1; y < row_start_.size(); ++y) row_start_[y] += row_start_[y - 1];
    by_row_.resize(row_start_.back());
    std::vector<std::uint32_t> next(row_start_.begin(), row_start_.end() - 1);
    for (std::size_t i = 0; i < first_.size(); ++i)
        for (std::size_t k = first_[i]; k < first_[i] + count_[i]; ++k)
            by_row_[next[static_cast<std::size_t>(strips_[k].y)]++] = static_cast<std::uint32_t>(k);
}

}  // namespace lbm
