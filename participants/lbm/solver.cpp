#include "participants/lbm/solver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/base/error.hpp"
#include "participants/lbm/live_cells.hpp"
#include "participants/lbm/row_ends.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::require;

//! Rows with some 4096 cells: what enters them from outside is spread over the memory, and is waited for together.
std::ptrdiff_t rows_at_once(Layout const& layout)
{
    return std::clamp<std::ptrdiff_t>(4096 / layout.most_in_row(), 1, 64);
}

constexpr std::int64_t watch_every = 64;  //!< steps
//! By c_s/L, of the pressure at a side that absorbs sound (Rudy and Strikwerda, J. Comput. Phys. 36 (1980) 55).
constexpr double recall_by_length = 0.28;

//! Rows between two of these are handed to a thread at a time: about as many cells each, enough parts that all threads
//! end together, few enough that lines of rows stay long. One thread gets all.
std::vector<std::ptrdiff_t> cut_rows(Layout const& layout, int threads)
{
    constexpr std::ptrdiff_t for_each = 32, least = 4;  // parts for a thread; rows
    std::ptrdiff_t const wanted = std::max(layout.stored() / (for_each * threads), least * layout.most_in_row());
    std::vector<std::ptrdiff_t> cuts{0};
    std::ptrdiff_t cells = 0;
    for (std::ptrdiff_t r = 0; r < layout.rows() && threads > 1; ++r) {
        if (cells >= wanted) {
            cuts.push_back(r);
            cells = 0;
        }
        cells += layout.row(r).cells;
    }
    cuts.push_back(layout.rows());
    return cuts;
}

//! 4 s (1 - s) at every half cell, 0 at both edges of the domain.
std::vector<double> parabola(std::ptrdiff_t cells)
{
    std::vector<double> values;
    for (std::ptrdiff_t half = 0; half <= 2 * cells; ++half) {
        double const s = static_cast<double>(half) / static_cast<double>(2 * cells);
        values.push_back(4 * s * (1 - s));
    }
    return values;
}

template <int D>
Boundary boundary_lu(Config const& c, std::size_t s)
{
    Wall const& wall = c.walls[s];
    auto const cells = c.cells();
    Boundary side{.kind = wall.kind, .ramp = wall.ramp / c.step};
    for (std::size_t k = 0; k < 3; ++k) side.velocity[k] = wall.velocity[k] / c.units().velocity_unit();
    for (std::size_t k = 0; k < c.axes(); ++k)
        if (wall.parabola && k != s / 2 && !c.periodic(k)) side.profile[k] = parabola(cells[k]);
    if (wall.kind == Border::pressure) {
        side.density_excess = c.units().density_excess_lu(wall.pressure);
        auto const beside = static_cast<std::size_t>(cells[0] * cells[1] * cells[2] / cells[s / 2]);
        side.turned.resize(Lattice<D>::directions * beside);
        if (wall.absorbing) {
            side.recall = recall_by_length / (std::numbers::sqrt3 * static_cast<double>(cells[s / 2]));
            side.incoming.resize(beside);
            side.held.resize(beside);
        }
    }
    return side;
}

template <int D>
Walls walls_lu(Config const& c, Relaxation const& relaxation, Domain<D> const& domain,
               std::vector<Patch<D>> const& patches)
{
    Walls walls{};
    for (std::size_t s = 0; s < 2 * c.axes(); ++s) walls.side[s / 2][s % 2] = boundary_lu<D>(c, s);
    walls.even_rate = relaxation.shear;
    walls.entrances = find_entrances<D>(walls, domain.own(),
                                        {.solid_at = [&](Extent const& cell) { return solid_at(patches, cell); },
                                         .cover = [&](Extent const& cell) { return is_covered(patches, cell); },
                                         .elsewhere = [&](Extent const& cell) { return domain.whole().box_of(cell); }});
    return walls;
}

//! Whether there is a side with a given density.
bool has_openings(Walls const& walls)
{
    auto const is_opening = [](Boundary const& side) { return side.kind == Border::pressure; };
    return std::ranges::any_of(walls.side, [&](auto const& pair) { return std::ranges::any_of(pair, is_opening); });
}

//! Solids finer than a cell and interpolated surfaces have arrays over whole layers: then all of it is stored.
template <int D>
Layout layout_of(Config const& c, std::vector<Patch<D>> const& patches, std::vector<Box> boxes)
{
    for (Patch<D> const& patch : patches) {
        auto const cells = static_cast<std::size_t>(patch.size[0] * patch.size[1] * patch.size[2]);
        require(patch.fraction.size() == cells, [&] {
            return Error("fluid: a patch of " + std::to_string(cells) + " cells has " +
                         std::to_string(patch.fraction.size()) + " fractions.");
        });
    }
    if (boxes.empty() && !c.phase && c.surface != Surface::interpolated)
        boxes = live_boxes(c.cells(), {c.periodic(0), c.periodic(1), c.periodic(2)}, patches);
    return boxes.empty() ? Layout(c.cells()) : Layout(c.cells(), std::move(boxes));
}

//! Share of an inflow that is there at a time, smooth at both ends.
double grown(double time, double ramp)
{
    return time < ramp ? 0.5 * (1 - std::cos(std::numbers::pi * time / ramp)) : 1.0;
}

}  // namespace

Config const& checked(Config const& config)
{
    std::string text;
    for (Issue const& issue : find_issues(config))
        if (issue.refused)
            text.append(text.empty() ? "fluid: " : "\nfluid: ").append(issue.key).append(" = ").append(issue.text);
    require(text.empty(), [&] { return Error(text); });
    return config;
}

void require_shareable(Config const& config, int processes)
{
    std::ptrdiff_t const layers = config.cells()[config.axes() - 1];
    require(processes <= layers, [&] { return too_many(processes, layers, config.axes() - 1); });
}

//! The solids' fractions are let go before the populations are allocated.
template <int D>
Solver<D>::Solver(Config const& config, std::vector<Patch<D>> patches, std::vector<Box> boxes, ranks::Peers* peers,
                  std::vector<double> extra)
    : config_(checked(config)),
      extra_(std::move(extra)),
      relaxation_(relaxation(config_)),
      domain_(layout_of(config_, patches, std::move(boxes)), peers, extra_),
      walls_(walls_lu<D>(config_, relaxation_, domain_, patches)),
      kernels_(kernels_of<D>(config_)),
      coverage_(domain_, walls_.periodic(), std::move(patches)),
      rim_loads_(domain_, walls_.entrances, coverage_.patches()),
      team_(config_.threads),
      cuts_(cut_rows(layout_, team_.size())),
      populations_(layout_, config_.precision, team_),
      solid_exchange_(coverage_.patches().size()),
      solid_force_(D * coverage_.patches().size()),
      solid_torque_(spins<D> * coverage_.patches().size()),
      covered_cells_(static_cast<std::size_t>(layout_.rows()))
{
    require_shareable(config_, peers ? peers->count() : 1);
    if (peers) halo_.emplace(domain_, walls_.entrances.crossings, config_.precision);
    populations_.visit([&]<class Stored>(Rows<D, Stored> const&) { list_still_rows<Stored>(); });
    if (config_.rotation) turning_ = Turning{frame::RotatingFrame<D>(*config_.rotation)};
    if (config_.phase) phase_.emplace(config_, domain_);
    if (config_.surface == Surface::interpolated) links_.emplace(domain_, walls_.periodic());
    find_field();
}

//! For the step that comes: what flows in, what acts everywhere alike, and the frame.
template <int D>
void Solver<D>::find_field()
{
    for (auto& pair : walls_.side)
        for (Boundary& side : pair) side.share = grown(static_cast<double>(steps_) + 0.5, side.ramp);
    acceleration_ = config_.acceleration;
    if (auto const& o = config_.oscillation)
        for (std::size_t k = 0; k < 3; ++k)
            acceleration_[k] += o->amplitude[k] * std::cos(2 * std::numbers::pi * o->frequency * time());
    for (std::size_t k = 0; k < 3; ++k) {
        relaxation_.force[k] = acceleration_[k] / config_.units().acceleration_unit();
        walls_.half_force[k] = 0.5 * relaxation_.force[k];
    }
    if (!turning_) return;
    double const from = time(), to = from + config_.step;
    turning_->field = turning_->frame.euler(from, to);
    auto const centrifugal = turning_->frame.centrifugal(0.5 * (from + to));
    if (config_.hydrostatic)
        for (std::size_t k = 0; k < centrifugal.size(); ++k) turning_->field[k] += centrifugal[k];
    // Guo's half force turns a velocity by 2 atan(w dt): with the tangent by twice the frame's angle, exactly
    double const turn = config_.rotation->coriolis ? std::tan(turning_->frame.angle(from, to)) : 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        relaxation_.turn[k] = turn * turning_->frame.direction()[k];
        turning_->rate[k] = relaxation_.turn[k] / config_.step;
    }
    for (std::size_t k = 0; k < D; ++k)
        relaxation_.slope[k] = turning_->field[k * D] * config_.cell / config_.units().acceleration_unit();
}

//! With the force in the row's first cell.
template <int D>
Relaxation Solver<D>::of_row(std::ptrdiff_t r) const
{
    Relaxation row = relaxation_;
    if (!turning_) return row;
    constexpr std::array<double, D> rest{};
    auto const a = acceleration_at(centre_of(0, r), rest.data());
    for (std::size_t k = 0; k < D; ++k) row.force[k] = a[k] / config_.units().acceleration_unit();
    return row;
}

//! What the scene's field and its frame do to fluid that moves [m/s2].
template <int D>
std::array<double, D> Solver<D>::acceleration_at(std::array<double, D> const& place, double const* velocity) const
{
    std::array<double, D> a;
    std::copy_n(acceleration_.begin(), D, a.begin());
    if (!turning_) return a;
    std::array<double, 3> u{};
    std::copy_n(velocity, D, u.begin());
    auto const turned = cross(turning_->rate, u);
    for (std::size_t i = 0; i < D; ++i) {
        a[i] -= 2 * turned[i];
        for (std::size_t k = 0; k < D; ++k)
            a[i] += turning_->field[i * D + k] * (place[k] - turning_->frame.point(static_cast<int>(k)));
    }
    return a;
}

template <int D>
void Solver<D>::step(SolidLoads on_solids)
{
    finds_solid_loads_ = on_solids == SolidLoads::found;
    sluice::Team::Awake const awake(team_);
    std::ptrdiff_t const rebuilt = coverage_.update(covering(), team_);
    if (links_) {
        complete();
        links_->place(populations_, bodies_, id_, walls_.half_force);
        populations_.visit([&](auto const& rows) {  // what surfaces wrote beside openings
            for (std::ptrdiff_t r = 0; r < rows.rows(); ++r) note_turned(rows, r, walls_, Incoming::kept);
        });
    }
    share_.rebuilt_bodies = static_cast<double>(rebuilt) / std::max(1.0, static_cast<double>(bodies_.size()));
    strip_load_.resize(coverage_.strips().size());
    if (phase_) phase_->spread();
    std::fill(covered_cells_.begin(), covered_cells_.end(), 0);
    collide_rows();
    note_held();
    if (phase_) phase_->gather(team_);
    populations_.stream(team_);
    if (halo_) halo_->send(populations_);
    complete_ = false;
    if (links_) {
        complete();
        links_->reflect(populations_, bodies_, team_);
    }
    bool const finite = sum_loads();
    ++steps_;
    find_field();
    if (!finite || steps_ % watch_every == 0) watch();
    require(finite, [&] {
        return Error("fluid: t = " + std::to_string(time()) + " s: the force on a body is not finite.",
                     sluice::Exit::numerical);
    });
}

//! Those that others' populations enter come last: these may be under way till then.
template <int D>
void Solver<D>::collide_rows()
{
    auto const waits = [&](std::ptrdiff_t r) { return halo_ && halo_->enters(r); };
    team_.share(static_cast<std::ptrdiff_t>(cuts_.size()) - 1, 1, [&](std::ptrdiff_t chunk, std::ptrdiff_t last) {
        std::ptrdiff_t begin = cuts_[static_cast<std::size_t>(chunk)];
        std::ptrdiff_t const end = cuts_[static_cast<std::size_t>(last)];
        for (std::ptrdiff_t next = begin; begin < end; begin = next) {
            while (next < end && waits(next) == waits(begin)) ++next;
            if (!waits(begin)) collide_run(begin, next);
        }
    });
    if (!halo_) return;
    halo_->receive(populations_);
    auto const& rows = halo_->rows();
    auto const count = static_cast<std::ptrdiff_t>(rows.size());
    team_.share(count, std::max<std::ptrdiff_t>(count / (16 * team_.size()), 4),
                [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
                    auto const row = [&](std::ptrdiff_t k) { return rows[static_cast<std::size_t>(k)]; };
                    for (std::ptrdiff_t next = begin; begin < end; begin = next) {
                        while (next < end && row(next) - next == row(begin) - begin) ++next;
                        collide_run(row(begin), row(next - 1) + 1);
                    }
                });
}

template <int D>
void Solver<D>::collide_run(std::ptrdiff_t begin, std::ptrdiff_t end)
{
    for (std::ptrdiff_t next = begin; begin < end; begin = next) {
        bool in_block = false;
        std::ptrdiff_t const last = begin + rows_in_line(begin, end);
        if (coverage_.strips().empty() && !phase_) next = last;
        for (; next < last; ++next) {
            Way const way = way_of(next);
            if (way == Way::alone) break;
            in_block = in_block || way == Way::in_block;
        }
        if (in_block) {
            collide_in_line(begin, next, [&]<class Stored>(Rows<D, Stored> const&, OnTheWay& ends) {
                collide_still_block<Stored>(begin, next - begin, ends);
            });
        } else if (next > begin) {
            collide_in_line(begin, next, [&]<class Stored>(Rows<D, Stored> const& rows, OnTheWay& ends) {
                kernels_.fluid(populations_.row(begin), {0, rows.nx(begin), next - begin, rows.stride(begin), &ends},
                               of_row(begin), {});
            });
        } else {
            std::ptrdiff_t const most = std::min(end, begin + rows_at_once(layout_));
            while (next < most && way_of(next) == Way::alone) ++next;
            collide_solid_rows(begin, next);
        }
        if (finds_solid_loads_) rim_loads_.find(populations_, begin, next);
    }
}

template <int D>
typename Solver<D>::Way Solver<D>::way_of(std::ptrdiff_t r) const
{
    if (phase_ && phase_->reaches(r)) return Way::alone;
    if (!covering().empty()) {
        auto const strips = coverage_.row(r);
        if (strips.empty()) return Way::plain;
        if (!all_rest(strips)) return Way::alone;
    }
    StillRow const row = still_.row(r);
    return row.count == 0 ? Way::plain : row.in_block ? Way::in_block : Way::alone;
}

//! Whether solids cover something of a row, and all of these rest.
template <int D>
bool Solver<D>::has_still_solids(std::ptrdiff_t r) const
{
    auto const strips = coverage_.row(r);
    return !strips.empty() && !(phase_ && phase_->reaches(r)) && all_rest(strips);
}

//! How many rows from r on lie in line, for one call of a kernel.
template <int D>
std::ptrdiff_t Solver<D>::rows_in_line(std::ptrdiff_t r, std::ptrdiff_t end) const
{
    return turning_ ? 1 : populations_.rows_in_line(r, end - r);  // turning: a force for each row
}

//! Rows that lie in line: collide(rows, what is to be done on the way).
template <int D>
template <class Collide>
void Solver<D>::collide_in_line(std::ptrdiff_t begin, std::ptrdiff_t end, Collide&& collide)
{
    bool const on_the_way = !complete_ && !has_openings(walls_);  // what openings note needs all of a row
    if (!complete_ && !on_the_way) enter_rows(begin, end);
    populations_.visit([&](auto const& rows) {
        RowEnds ends(rows, walls_, begin, end, on_the_way);
        collide(rows, ends);
        ends.finish();
    });
}

template <int D>
void Solver<D>::collide_solid_rows(std::ptrdiff_t begin, std::ptrdiff_t end)
{
    if (!complete_) enter_rows(begin, end);
    populations_.visit([&]<class Stored>(Rows<D, Stored> const& rows) {
        for (std::ptrdiff_t r = begin; r < end; ++r)
            has_still_solids(r) ? collide_still_row<Stored>(r, populations_.row(r))
                                : collide_covered_row<Stored>(r, populations_.row(r), coverage_.row(r));
        rows.note_ends(begin, end);
    });
}

template <int D>
void Solver<D>::enter_rows(std::ptrdiff_t begin, std::ptrdiff_t end)
{
    populations_.visit([&](auto const& rows) {
        enter_from_outside(rows, begin, end, walls_);
        if (!has_openings(walls_)) return;
        for (std::ptrdiff_t r = begin; r < end; ++r) note_turned(rows, r, walls_);
    });
}

template class Solver<2>;
template class Solver<3>;

}  // namespace lbm
