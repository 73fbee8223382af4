#include "participants/lbm/live_cells.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

namespace lbm {
namespace {

constexpr double traces = 1e-9;  //!< of a cell: exact fractions, but for rounding

enum class Cover : char
{
    open,
    partly,
    wholly
};

Cover cover_of(double fraction)
{
    return fraction >= 1 - traces ? Cover::wholly : fraction > traces ? Cover::partly : Cover::open;
}

//! How far solids cover each cell; shape [z][y][x].
template <int D>
std::vector<Cover> covers(Extent const& n, std::vector<Patch<D>> const& patches)
{
    std::vector<Cover> cover(static_cast<std::size_t>(n[0] * n[1] * n[2]));
    std::vector<double> sum(static_cast<std::size_t>(n[0]));
    for (std::ptrdiff_t row = 0; row < n[1] * n[2]; ++row) {
        std::ranges::fill(sum, 0.0);
        for (Patch<D> const& patch : patches) {
            double const* const fraction = patch.row(row % n[1], row / n[1]);
            if (fraction == nullptr) continue;
            std::ptrdiff_t const begin = std::max<std::ptrdiff_t>(0, patch.first[0]),
                                 end = std::min(n[0], patch.first[0] + patch.size[0]);
            for (std::ptrdiff_t x = begin; x < end; ++x)
                sum[static_cast<std::size_t>(x)] += fraction[x - patch.first[0]];
        }
        std::ranges::transform(sum, cover.begin() + row * n[0], cover_of);
    }
    return cover;
}

//! Marks the cells beside marked ones along an axis as well.
void spread(std::vector<char>& marked, Extent const& n, std::size_t axis, bool periodic)
{
    std::vector<char> const before = marked;
    std::ptrdiff_t const count = n[axis], step = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
    auto const cells = static_cast<std::ptrdiff_t>(marked.size());
    for (std::ptrdiff_t lines = 0; lines < cells; lines += step * count)  // `step` lines lie side by side
        for (std::ptrdiff_t k = 0; k < count; ++k)
            for (std::ptrdiff_t const beside : {k - 1, k + 1}) {
                std::ptrdiff_t const at = periodic ? wrap(beside, count) : beside;
                if (at < 0 || at >= count) continue;
                char const* const other = before.data() + lines + at * step;
                char* const here = marked.data() + lines + k * step;
                for (std::ptrdiff_t i = 0; i < step; ++i) here[i] |= other[i];
            }
}

//! A solid's cells that lie in the lattice.
template <int D>
Box cells_of(Patch<D> const& patch, Extent const& n)
{
    Box cells;
    for (std::size_t k = 0; k < 3; ++k) {
        cells.first[k] = std::max<std::ptrdiff_t>(patch.first[k], 0);
        cells.size[k] = std::max<std::ptrdiff_t>(std::min(n[k], patch.first[k] + patch.size[k]) - cells.first[k], 0);
    }
    return cells;
}

//! For each cell whether it is covered wholly, and no solid that covers any of it has a cell beside it, across edges
//! and corners too, that is covered in part.
template <int D>
std::vector<char> dead_cells(std::vector<Cover> const& cover, Extent const& n, std::array<bool, 3> const& periodic,
                             std::vector<Patch<D>> const& patches)
{
    std::vector<char> dead(cover.size()), near_surface;
    std::ranges::transform(cover, dead.begin(), [](Cover c) { return c == Cover::wholly; });
    for (Patch<D> const& patch : patches) {
        Box const cells = cells_of(patch, n);
        auto const each = [&](auto&& visit) {  // cell with some of this solid: number in the box, in the lattice
            for (std::ptrdiff_t row = 0; row < cells.size[1] * cells.size[2]; ++row) {
                std::ptrdiff_t const y = cells.first[1] + row % cells.size[1], z = cells.first[2] + row / cells.size[1];
                double const* const fraction = patch.row(y, z) + (cells.first[0] - patch.first[0]);
                for (std::ptrdiff_t x = 0; x < cells.size[0]; ++x)
                    if (fraction[x] > traces)
                        visit(static_cast<std::size_t>(row * cells.size[0] + x),
                              static_cast<std::size_t>((z * n[1] + y) * n[0] + cells.first[0] + x));
            }
        };
        near_surface.assign(static_cast<std::size_t>(cells.cells()), 0);
        each([&](std::size_t here, std::size_t cell) { near_surface[here] = cover[cell] == Cover::partly; });
        for (std::size_t axis = 0; axis < D; ++axis)
            spread(near_surface, cells.size, axis, periodic[axis] && cells.size[axis] == n[axis]);
        each([&](std::size_t here, std::size_t cell) { dead[cell] = dead[cell] && near_surface[here] == 0; });
    }
    return dead;
}

//! Live cells side by side in a row of the lattice.
struct LiveRun
{
    std::ptrdiff_t begin, end, y, z;
};

std::vector<LiveRun> runs_between(std::vector<char> const& dead, Extent const& n)
{
    std::vector<LiveRun> runs;
    for (std::ptrdiff_t row = 0; row < n[1] * n[2]; ++row) {
        char const* const at = dead.data() + row * n[0];
        for (std::ptrdiff_t x = 0; x < n[0];) {
            if (at[x] != 0) {
                ++x;
                continue;
            }
            std::ptrdiff_t const begin = x;
            while (x < n[0] && at[x] == 0) ++x;
            runs.push_back({begin, x, row % n[1], row / n[1]});
        }
    }
    return runs;
}

//! Lowest cell and the one after the highest along each axis.
struct Bounds
{
    Extent low{std::numeric_limits<std::ptrdiff_t>::max(), std::numeric_limits<std::ptrdiff_t>::max(),
               std::numeric_limits<std::ptrdiff_t>::max()};
    Extent high{-1, -1, -1};

    void add(LiveRun const& run) { add(Bounds{{run.begin, run.y, run.z}, {run.end, run.y + 1, run.z + 1}}); }
    void add(Bounds const& other)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], other.low[k]);
            high[k] = std::max(high[k], other.high[k]);
        }
    }
    bool empty() const { return high[0] < 0; }
    Box box() const { return {low, {high[0] - low[0], high[1] - low[1], high[2] - low[2]}}; }
};

//! What a box costs, in cells: rows, the links at both their ends, ghost cells.
double cost(Bounds const& b)
{
    if (b.empty()) return 0;
    constexpr std::ptrdiff_t ends = 8, each = 100;
    auto const [nx, ny, nz] = b.box().size;
    std::ptrdiff_t const rows = (ny + 1) * (nz > 1 ? nz + 1 : 1);
    return static_cast<double>((nx + ends) * rows + each);
}

struct Cut
{
    std::size_t axis;
    std::ptrdiff_t at;
};

LiveRun part_of(LiveRun run, std::size_t axis, std::ptrdiff_t low, std::ptrdiff_t high)
{
    if (axis == 0) {
        run.begin = std::max(run.begin, low);
        run.end = std::min(run.end, high);
    } else if (std::ptrdiff_t const at = axis == 1 ? run.y : run.z; at < low || at >= high) {
        run.end = run.begin;
    }
    return run;
}

//! The cut into two that costs least, bounds drawn tight around both parts.
std::optional<Cut> best_cut(std::vector<LiveRun> const& runs, Bounds const& all)
{
    std::optional<Cut> best;
    double least = cost(all);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        auto const slices = static_cast<std::size_t>(all.high[axis] - all.low[axis]);
        std::vector<Bounds> slice(slices), above(slices + 1);
        for (LiveRun const& run : runs) {
            std::ptrdiff_t const begin = axis == 0   ? run.begin
                                         : axis == 1 ? run.y
                                                     : run.z,
                                 end = axis == 0 ? run.end : begin + 1;
            for (std::ptrdiff_t k = begin; k < end; ++k)
                slice[static_cast<std::size_t>(k - all.low[axis])].add(part_of(run, axis, k, k + 1));
        }
        for (std::size_t k = slices; k-- > 0;) {
            above[k] = above[k + 1];
            above[k].add(slice[k]);
        }
        Bounds below;
        for (std::size_t k = 1; k < slices; ++k) {
            below.add(slice[k - 1]);
            double const both = cost(below) + cost(above[k]);
            if (both >= least) continue;
            least = both;
            best = Cut{axis, all.low[axis] + static_cast<std::ptrdiff_t>(k)};
        }
    }
    return best;
}

struct Boxes
{
    std::vector<Box> boxes;
    double cost = 0;
};

//! Cuts where it saves most; where no single cut saves anything, in the middle, to see whether more cuts do.
Boxes cut_up(std::vector<LiveRun> const& runs)
{
    constexpr std::ptrdiff_t smallest = 12;  // cells, of what is cut in the middle
    Bounds all;
    std::ptrdiff_t live = 0;
    for (LiveRun const& run : runs) {
        all.add(run);
        live += run.end - run.begin;
    }
    if (all.empty()) return {};
    Boxes const one{{all.box()}, cost(all)};
    if (live == one.boxes[0].cells()) return one;
    auto cut = best_cut(runs, all);
    if (!cut) {
        auto const& size = one.boxes[0].size;
        auto const axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
        if (size[axis] < 2 * smallest) return one;
        cut = Cut{axis, all.low[axis] + size[axis] / 2};
    }
    Boxes both;
    for (bool const upper : {false, true}) {
        std::vector<LiveRun> part;
        for (LiveRun const& run : runs) {
            LiveRun const rest =
                part_of(run, cut->axis, upper ? cut->at : all.low[cut->axis], upper ? all.high[cut->axis] : cut->at);
            if (rest.begin < rest.end) part.push_back(rest);
        }
        Boxes const side = cut_up(part);
        both.boxes.insert(both.boxes.end(), side.boxes.begin(), side.boxes.end());
        both.cost += side.cost;
    }
    return both.cost < one.cost ? both : one;
}

bool overlap(Box const& a, Box const& b)
{
    for (std::size_t k = 0; k < 3; ++k)
        if (a.first[k] >= b.first[k] + b.size[k] || b.first[k] >= a.first[k] + a.size[k]) return false;
    return true;
}

//! Whether there are cells with solid in a box.
bool holds_solid(Box const& box, std::vector<Cover> const& cover, Extent const& n)
{
    for (std::ptrdiff_t z = box.first[2]; z < box.first[2] + box.size[2]; ++z)
        for (std::ptrdiff_t y = box.first[1]; y < box.first[1] + box.size[1]; ++y) {
            auto const row = cover.begin() + (z * n[1] + y) * n[0] + box.first[0];
            if (std::any_of(row, row + box.size[0], [](Cover c) { return c != Cover::open; })) return true;
        }
    return false;
}

//! Makes rows of boxes with solids longer, into dead cells, to whole registers where there is room: in the plane they
//! collide one by one, and their last cells are slow else.
void fill_registers(std::vector<Box>& boxes, std::vector<Cover> const& cover, Extent const& n)
{
    constexpr std::ptrdiff_t lanes = 8;  // cells that are computed with at once
    for (Box& box : boxes) {
        if (!holds_solid(box, cover, n)) continue;
        std::ptrdiff_t const missing = (lanes - box.size[0] % lanes) % lanes;
        for (bool const upward : {true, false}) {
            Box wider = box;
            wider.size[0] += missing;
            if (!upward) wider.first[0] -= missing;
            bool const within = wider.first[0] >= 0 && wider.first[0] + wider.size[0] <= n[0];
            auto const in_the_way = [&](Box const& other) { return &other != &box && overlap(wider, other); };
            if (!within || std::ranges::any_of(boxes, in_the_way)) continue;
            box = wider;
            break;
        }
    }
}

}  // namespace

template <int D>
std::vector<Box> live_boxes(Extent const& n, std::array<bool, 3> const& periodic, std::vector<Patch<D>> const& patches)
{
    constexpr double worth = 0.9;  // of what all cells cost
    Box const all{{0, 0, 0}, n};
    if (patches.empty()) return {all};
    auto const cover = covers(n, patches);
    auto const dead = dead_cells(cover, n, periodic, patches);
    auto const left_out = static_cast<double>(std::ranges::count(dead, 1));
    if (left_out < (1 - worth) * static_cast<double>(dead.size())) return {all};
    Boxes cut = cut_up(runs_between(dead, n));
    if (cut.boxes.empty() || cut.cost > worth * cost({{0, 0, 0}, n})) return {all};
    if (D == 2) fill_registers(cut.boxes, cover, n);
    return cut.boxes;
}

template <int D>
std::int32_t solid_at(std::vector<Patch<D>> const& patches, Extent const& cell)
{
    std::int32_t found = 0;
    double most = -1;
    for (std::size_t p = 0; p < patches.size(); ++p) {
        double const* const fraction = patches[p].row(cell[1], cell[2]);
        std::ptrdiff_t const x = cell[0] - patches[p].first[0];
        if (fraction == nullptr || x < 0 || x >= patches[p].size[0] || fraction[x] <= most) continue;
        most = fraction[x];
        found = static_cast<std::int32_t>(p);
    }
    return found;
}

template <int D>
bool is_covered(std::vector<Patch<D>> const& patches, Extent const& cell)
{
    double sum = 0;
    for (Patch<D> const& patch : patches) {
        double const* const fraction = patch.row(cell[1], cell[2]);
        std::ptrdiff_t const x = cell[0] - patch.first[0];
        if (fraction != nullptr && x >= 0 && x < patch.size[0]) sum += fraction[x];
    }
    return cover_of(sum) == Cover::wholly;
}

template bool is_covered<2>(std::vector<Patch<2>> const&, Extent const&);
template bool is_covered<3>(std::vector<Patch<3>> const&, Extent const&);
template std::vector<Box> live_boxes<2>(Extent const&, std::array<bool, 3> const&, std::vector<Patch<2>> const&);
template std::vector<Box> live_boxes<3>(Extent const&, std::array<bool, 3> const&, std::vector<Patch<3>> const&);
template std::int32_t solid_at<2>(std::vector<Patch<2>> const&, Extent const&);
template std::int32_t solid_at<3>(std::vector<Patch<3>> const&, Extent const&);

}  // namespace lbm
