// Solver: the collision of rows in which all solids rest.
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "participants/lbm/row_buffer.hpp"
#include "participants/lbm/solver.hpp"
#include "participants/lbm/still_numbers.hpp"

namespace lbm {
namespace {

//! Of a run with solids at rest, those of a SolidRow.
template <class Stored>
std::vector<Stored> solid_numbers(StillRun const& run, RowBuffer<Stored> const& row)
{
    std::vector<Stored> numbers;
    for (auto const* of : {&row.fraction, &row.weight, &row.open, &row.ease})
        numbers.insert(numbers.end(), of->begin() + run.begin, of->begin() + run.end);
    return numbers;
}

//! Of each cell whether it has solid.
template <class Stored>
std::vector<char> cells_with_solid(RowBuffer<Stored> const& row, std::ptrdiff_t nx)
{
    std::vector<char> has_solid(static_cast<std::size_t>(nx));
    for (auto const& run : row.runs)
        for (std::ptrdiff_t x = run.begin; run.touched && x < std::min(run.end, nx); ++x)
            has_solid[static_cast<std::size_t>(x)] = row.fraction[static_cast<std::size_t>(x)] > 0;
    return has_solid;
}

//! Whether the fluid's velocity changes how solids push it: then numbers do not tell all.
template <int D, class Stored>
bool is_eased(RowBuffer<Stored> const& row)
{
    return eased_by_inertia<D> && std::ranges::any_of(row.runs, [&](auto const& run) {
               return run.touched && std::any_of(row.ease.begin() + run.begin, row.ease.begin() + run.end,
                                                 [](Stored ease) { return ease != 0; });
           });
}

}  // namespace

//! The solids of a row that all rest.
template <int D>
bool Solver<D>::all_rest(std::span<std::uint32_t const> strips) const
{
    return covering().empty() ||
           coverage_.strips()[strips.front()].body >= static_cast<std::ptrdiff_t>(covering().size());  // they come last
}

//! Gathers a row's solids, all of which rest, in row_buffer().
template <int D>
template <class Stored>
void Solver<D>::gather_still_row(std::ptrdiff_t r)
{
    auto& buffer = row_buffer<Stored>();
    auto const strips = coverage_.row(r);
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    begin_row(buffer, nx, strips, coverage_.strips(), [](auto&) {});
    write_covers(buffer, strips, coverage_.strips());
    each_cover(buffer, strips, coverage_.strips(), [&](std::uint32_t, Strip<D> const& s, Stored const* cover) {
        add_strip(s, cover, {}, s.drag, 0.0, buffer);
    });
    for (auto const& run : buffer.runs)
        if (run.touched) find_weights<D>(run, relaxation_.tau, buffer);
}

//! What the collision needs of a row in which all solids rest.
template <int D>
template <class Stored>
StillRows::Known<Stored> Solver<D>::know_still_row(std::ptrdiff_t r)
{
    StillRows::Known<Stored> row{.in_block = kernels_.still != nullptr};
    if (coverage_.row(r).empty()) return row;
    gather_still_row<Stored>(r);
    auto& buffer = row_buffer<Stored>();
    if (row.in_block && !is_eased<D>(buffer))
        row.of_cells = {buffer.view(), cells_with_solid(buffer, layout_.row(r).cells), relaxation_,
                        config_.smagorinsky > 0};
    row.in_block = row.of_cells.cells() > 0 && !row.of_cells.runs().empty();  // none: too little for a float
    if (row.in_block) return row;
    for (auto const& [begin, end, touched] : buffer.runs) {
        StillRun run{begin, end, touched, 0};
        if (touched) run.at = still_.typed<Stored>().of_runs.add(solid_numbers(run, buffer));
        row.alone.push_back(run);
    }
    return row;
}

//! The same of all rows.
template <int D>
template <class Stored>
void Solver<D>::list_still_rows()
{
    if (coverage_.patches().empty()) return;
    auto& numbers = still_.typed<Stored>();
    numbers.rest.assign(static_cast<std::size_t>(layout_.most_in_row()), Stored{});
    auto const of_fluid = StillRowNumbers<Stored>::of_fluid(relaxation_, config_.smagorinsky > 0);
    auto const add = [&](std::vector<Stored> const& of_run) { return numbers.of_runs.add(of_run); };
    std::deque<StillRows::Known<Stored>> ahead;  // the row, and those after it
    std::deque<StillRowNumbers<Stored>> line;    // of the same
    for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r) {
        Row const& row = layout_.row(r);
        Box const& box = layout_.boxes()[static_cast<std::size_t>(row.box)];
        std::ptrdiff_t const stride = populations_.stride(r), left = box.first[1] + box.size[1] - row.y,
                             reach = std::min(left, 1 + rows_in_reach<Stored>(stride));
        while (static_cast<std::ptrdiff_t>(ahead.size()) < reach) {
            ahead.push_back(know_still_row<Stored>(r + static_cast<std::ptrdiff_t>(ahead.size())));
            line.push_back(std::move(ahead.back().of_cells));
        }
        auto const& here = ahead.front();
        still_.add_row(row.cells, here.in_block ? runs_in_line(line, stride, of_fluid, add) : here.alone,
                       here.in_block);
        ahead.pop_front();
        line.pop_front();
    }
}

//! Of a row's solids; all of them are patches, which list all their cells.
template <int D>
template <class Stored>
void Solver<D>::find_still_loads(std::ptrdiff_t r, SolidRow<Stored> const& solid)
{
    for (std::uint32_t const k : coverage_.row(r)) {
        Strip<D> const& s = coverage_.strips()[k];
        find_load<false>(s, s.listed, {}, solid, strip_load_[k]);
    }
}

template <int D>
template <class Stored>
void Solver<D>::collide_still_row(std::ptrdiff_t r, AnySlots<D> const& slots)
{
    auto& buffer = row_buffer<Stored>();
    std::ptrdiff_t const nx = layout_.row(r).cells;
    buffer.resize(layout_.most_in_row(), nx);
    Relaxation const relaxation = of_row(r);
    prefetch_next<Stored>(r);
    SolidRow<Stored> solid = buffer.view();
    solid.momentum.fill(still_.typed<Stored>().rest.data());
    StillRow const row = still_.row(r);
    covered_cells_[static_cast<std::size_t>(r)] = row.touched;
    for (StillRun const& run : still_.runs_of(row)) {
        if (!run.touched) {
            kernels_.fluid(slots, {run.begin, run.end}, relaxation, {});
            continue;
        }
        still_.point(run, solid);
        kernels_.covered(slots, {run.begin, run.end}, relaxation, solid);
    }
    if (finds_solid_loads_) find_still_loads(r, solid);
}

//! `count` rows in line, from r on.
template <int D>
template <class Stored>
void Solver<D>::collide_still_block(std::ptrdiff_t r, std::ptrdiff_t count, OnTheWay& ends)
{
    constexpr auto beyond = std::max(StillNumbers<Stored>::lanes, strip_lanes);  // is written, or read of strips
    auto& buffer = row_buffer<Stored>();
    std::ptrdiff_t const nx = layout_.row(r).cells, stride = populations_.stride(r), room = count * stride + beyond;
    SolidRow<Stored> solid{};
    for (std::size_t k = 0; finds_solid_loads_ && k < 3; ++k) {
        auto& force = buffer.block_force[k];
        if (force.size() < static_cast<std::size_t>(room)) force.assign(static_cast<std::size_t>(room), Stored{});
        solid.force[k] = force.data();
    }
    kernels_.still(populations_.row(r),
                   StillBlock<Stored>{nx, count, stride, still_.rows.data() + r, still_.runs.data(0),
                                      still_.typed<Stored>().of_runs.data(0), solid.force, &ends},
                   of_row(r));
    for (std::ptrdiff_t row = 0; finds_solid_loads_ && row < count; ++row)
        for (Stored* const force : solid.force)
            std::fill_n(force + row * stride + nx, stride - nx, Stored{});  // no cell
    for (std::ptrdiff_t const last = r + count; r < last; ++r) {
        covered_cells_[static_cast<std::size_t>(r)] = still_.row(r).touched;
        if (!finds_solid_loads_) continue;
        find_still_loads(r, solid);
        for (Stored*& force : solid.force) force += stride;
    }
}

template bool Solver<2>::all_rest(std::span<std::uint32_t const>) const;
template bool Solver<3>::all_rest(std::span<std::uint32_t const>) const;
#define LBM_STILL_SOLIDS(D, Stored)                                                                  \
    template void Solver<D>::collide_still_row<Stored>(std::ptrdiff_t, AnySlots<D> const&);          \
    template void Solver<D>::collide_still_block<Stored>(std::ptrdiff_t, std::ptrdiff_t, OnTheWay&); \
    template void Solver<D>::list_still_rows<Stored>();
LBM_STILL_SOLIDS(2, double)
LBM_STILL_SOLIDS(2, float)
LBM_STILL_SOLIDS(3, double)
LBM_STILL_SOLIDS(3, float)
#undef LBM_STILL_SOLIDS

}  // namespace lbm
