#include "participants/lbm/phase.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "coupler/base/error.hpp"
#include "participants/lbm/solid_weight.hpp"

namespace lbm {
namespace {

using sluice::Error;
using sluice::Exit;
using sluice::require;

constexpr double farthest = 1e9;  //!< cells from the lattice's corner, where a cell's number still is one

//! B of solids of fraction `solid` that are driven past at the speed `drive`, before any drag.
double weight_of(DragLaw const& law, double inertia, double solid, double drive) noexcept
{
    double const half = 0.5 + 1 / (inertia * solid);
    double const r = law.resistance_after(solid, drive, half);
    return 0.5 * r / (1 + half * r);
}

//! What lies beyond a side is beyond the other one (periodic), or its mirror image.
std::ptrdiff_t folded(std::ptrdiff_t cell, std::ptrdiff_t cells, bool periodic) noexcept
{
    std::ptrdiff_t const period = periodic ? cells : 2 * cells;
    cell = wrap(cell, period);
    return cell < cells ? cell : period - 1 - cell;
}

}  // namespace

template <int D>
Phase<D>::Phase(Config const& c, Domain<D> const& domain)
    : law_{c.phase->law, c.phase->diameter / c.cell, c.viscosity / c.units().viscosity_unit()},
      inertia_(c.phase->solid_density / c.density - (c.phase->matter ? 1 : 0)),
      width_(c.phase->spread),
      matter_(c.phase->matter),
      unit_(c.units()),
      origin_(c.origin),
      cells_(c.cells()),
      periodic_{c.periodic(0), c.periodic(1), c.periodic(2)},
      domain_(domain),
      first_row_(domain.begin() * (D == 2 ? 1 : cells_[1])),
      blocks_((cells_[0] + block - 1) / block)
{
    auto const rows = static_cast<std::size_t>(cells_[1] * cells_[2]), row = static_cast<std::size_t>(cells_[0]);
    solid_.assign(rows * row, 0.0);
    own_.assign(rows * row, 0.0);
    for (auto& component : given_) component.assign(rows * row, 0.0);
    row_blocks_.assign(rows * static_cast<std::size_t>(blocks_), 0);
    any_.assign(rows, 0);
}

template <int D>
void Phase<D>::require_usable(Point const& point, std::int64_t id) const
{
    bool usable = point.volume > 0 && std::isfinite(point.volume);
    for (std::size_t k = 0; k < D; ++k)
        usable = usable && std::abs(point.place[k]) < farthest && std::isfinite(point.velocity[k]);
    require(usable, [&] {
        return Error("fluid: point " + std::to_string(id) +
                         " of the solids has no finite place, velocity or positive solid volume.",
                     Exit::numerical);
    });
}

template <int D>
void Phase<D>::place(PhaseView const& view, std::int64_t steps)
{
    std::size_t const n = view.id.size();
    bool const same = std::ranges::equal(id_, view.id);
    std::unordered_map<std::int64_t, std::size_t> where;
    for (std::size_t i = 0; !same && i < id_.size(); ++i) where.emplace(id_[i], i);
    std::vector<Point> now(n);
    double const over = 1 / static_cast<double>(steps_);
    for (std::size_t i = 0; i < n; ++i) {
        Point& p = now[i];
        p.volume = view.solid_volume[i] * unit_.density / unit_.mass_unit();
        for (std::size_t k = 0; k < D; ++k) {
            p.place[k] = (view.position[D * i + k] - origin_[k]) / unit_.cell;
            p.velocity[k] = p.start[k] = view.velocity[D * i + k] / unit_.velocity_unit();
        }
        require_usable(p, view.id[i]);
        auto const found = same ? where.end() : where.find(view.id[i]);
        if (!same && found == where.end()) continue;
        Point const& past = points_[same ? i : found->second];
        for (std::size_t k = 0; k < D; ++k)
            p.other[k] = over * (p.velocity[k] - past.start[k] - past.impulse[k] / mass_of(past.volume));
    }
    points_ = std::move(now);
    id_.assign(view.id.begin(), view.id.end());
    steps_ = steps;
    gathered_ = 0;
    lay_out();
}

//! Hat functions around the points, and the solid fractions. A point that is a cell or more outside hinders nothing.
template <int D>
void Phase<D>::lay_out()
{
    auto const across = static_cast<std::size_t>(2 * width_);
    at_.assign(points_.size() * D * across, -1);
    share_.assign(points_.size() * D * across, 0.0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
        bool inside = true;
        for (std::size_t k = 0; k < D; ++k)
            inside = inside && (periodic_[k] ||
                                (points_[i].place[k] > -1 && points_[i].place[k] < static_cast<double>(cells_[k]) + 1));
        for (std::size_t k = 0; inside && k < D; ++k) {
            double const x = points_[i].place[k];
            auto const first = static_cast<std::ptrdiff_t>(std::floor(x - 0.5)) - width_ + 1;
            for (std::size_t c = 0; c < across; ++c) {
                std::ptrdiff_t const cell = first + static_cast<std::ptrdiff_t>(c);
                double const distance = std::abs(x - 0.5 - static_cast<double>(cell));
                at_[(i * D + k) * across + c] = static_cast<std::int32_t>(folded(cell, cells_[k], periodic_[k]));
                share_[(i * D + k) * across + c] = std::max(0.0, 1 - distance / width_) / width_;
            }
        }
    }
    std::ranges::fill(solid_, 0.0);
    for (std::size_t i = 0; i < points_.size(); ++i)
        each_cell(i, [&](std::size_t cell, double share) { solid_[cell] += share * points_[i].volume; });
    std::ranges::fill(row_blocks_, 0);
    std::ranges::fill(any_, 0);
    auto const row = static_cast<std::size_t>(cells_[0]);
    for (std::size_t cell = 0; cell < solid_.size(); ++cell) {
        if (solid_[cell] <= 0) continue;
        any_[cell / row] = 1;
        row_blocks_[cell / row * static_cast<std::size_t>(blocks_) + cell % row / block] = 1;
    }
    find_near();
}

//! each(cell, share of the point) over the cells that a point reaches.
template <int D>
template <class Each>
void Phase<D>::each_cell(std::size_t i, Each&& each) const
{
    auto const across = static_cast<std::size_t>(2 * width_);
    std::int32_t const* const at = at_.data() + i * D * across;
    double const* const share = share_.data() + i * D * across;
    if (at[0] < 0) return;
    auto const nx = static_cast<std::size_t>(cells_[0]), ny = static_cast<std::size_t>(cells_[1]);
    for (std::size_t c = 0; c < (D == 2 ? 1 : across); ++c) {
        std::size_t plane = 0;
        double outer = 1;
        if constexpr (D == 3) plane = static_cast<std::size_t>(at[2 * across + c]) * ny, outer = share[2 * across + c];
        for (std::size_t b = 0; b < across; ++b) {
            std::size_t const row = (plane + static_cast<std::size_t>(at[across + b])) * nx;
            for (std::size_t a = 0; a < across; ++a)
                each(row + static_cast<std::size_t>(at[a]), outer * share[across + b] * share[a]);
        }
    }
}

template <int D>
void Phase<D>::spread()
{
    for (std::size_t const row : rows_)
        for (auto& component : given_)
            std::fill_n(component.begin() + static_cast<std::ptrdiff_t>(row) * cells_[0], cells_[0], 0.0);
    for (std::size_t const i : near_) {
        Point const& p = points_[i];
        Vector b;
        for (std::size_t k = 0; k < D; ++k) b[k] = p.volume * (p.velocity[k] + p.other[k]);
        each_cell(i, [&](std::size_t cell, double share) {
            for (std::size_t k = 0; k < D; ++k) given_[k][cell] += share * b[k];
        });
    }
}

template <int D>
void Phase<D>::mark(std::ptrdiff_t row, std::vector<char>& blocks) const
{
    for (std::ptrdiff_t k = 0; k < blocks_; ++k)
        blocks[static_cast<std::size_t>(k)] |= row_blocks_[static_cast<std::size_t>((first_row_ + row) * blocks_ + k)];
}

template <int D>
typename Phase<D>::Cell Phase<D>::cell_at(std::size_t index, std::array<double, 3> const& j, double rho) const
{
    Cell cell{.solid = solid_[index]};
    if (cell.solid <= 0) return cell;
    double square = 0;
    for (std::size_t k = 0; k < D; ++k) {
        cell.velocity[k] = given_[k][index] / cell.solid;
        double const drive = j[k] / rho - cell.velocity[k];
        square += drive * drive;
    }
    cell.weight = weight_of(law_, inertia_, cell.solid, std::sqrt(square));
    return cell;
}

//! As one more solid that covers `fraction` = B/weight: together with bodies in a cell at most full_weight.
template <int D>
template <class Stored>
void Phase<D>::add_to_row(std::ptrdiff_t row, std::ptrdiff_t begin, std::ptrdiff_t end, Slots<D, Stored> const& slots,
                          Relaxation const& relaxation, SolidRowInput<Stored> const& input)
{
    using L = Lattice<D>;
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        auto const index = index_of(row, x);
        if (solid_[index] <= 0) continue;
        double rho = 1;
        std::array<double, 3> j;
        for (std::size_t k = 0; k < 3; ++k)
            j[k] = 0.5 * (relaxation.force[k] + relaxation.slope[k] * static_cast<double>(x));
        for (std::size_t q = 0; q < L::directions; ++q) {
            double const f = slots[q][x];
            rho += f;
            for (std::size_t k = 0; k < D; ++k) j[k] += L::c[q][k] * f;
        }
        Cell const c = cell_at(index, j, rho);
        Stored& fraction = input.fraction[x];
        Stored& weight = input.weight[x];
        if (weight <= 0) weight = 1, input.open[x] = 1;  // no solid, or too little to push
        input.ease[x] = 0;                               // fine solids drag by their law
        double const room = std::max(0.0, full_weight - static_cast<double>(weight) * fraction);
        auto const own = static_cast<Stored>(std::min(c.weight, room) / weight);
        fraction += own;
        for (std::size_t k = 0; k < D; ++k) input.momentum[k][x] += static_cast<Stored>(own * c.velocity[k]);
        own_[index] = own;
    }
}

template <int D>
template <class Stored>
void Phase<D>::take_from_row(std::ptrdiff_t row, std::ptrdiff_t begin, std::ptrdiff_t end,
                             SolidRow<Stored> const& solid)
{
    for (std::ptrdiff_t x = begin; x < end; ++x) {
        auto const index = index_of(row, x);
        if (solid_[index] <= 0) continue;
        double const share = own_[index] / solid_[index], rate = share * solid.force_rate[x];
        for (std::size_t k = 0; k < D; ++k) {
            double const mean = matter_ ? rate * given_[k][index] / solid_[index] : 0.0;
            given_[k][index] = share * solid.force[k][x] - mean;
        }
        own_[index] = matter_ ? 0.0 : rate;
    }
}

template <int D>
void Phase<D>::gather(sluice::Team& team)
{
    swap_borders();
    team.share(static_cast<std::ptrdiff_t>(near_.size()), 256, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        for (auto n = static_cast<std::size_t>(from); n < static_cast<std::size_t>(to); ++n) {
            std::size_t const i = near_[n];
            Point& p = points_[i];
            Vector pull{};
            double rate = 0;
            each_cell(i, [&](std::size_t cell, double share) {
                rate += share * own_[cell];
                for (std::size_t k = 0; k < D; ++k) pull[k] += share * given_[k][cell];
            });
            for (std::size_t k = 0; k < D; ++k) {
                double const own = p.velocity[k] + p.other[k], got = pull[k] - rate * own;
                p.impulse[k] += p.volume * got;
                p.velocity[k] = own + got / inertia_;
            }
        }
    });
    if (++gathered_ == steps_) share_impulses();
}

template <int D>
std::span<double const> Phase<D>::force()
{
    double const unit = unit_.force_unit() / static_cast<double>(steps_);
    force_.clear();
    for (Point const& p : points_)
        for (double const component : p.impulse) force_.push_back(component * unit);
    return force_;
}

template <int D>
void Phase<D>::keep(sluice::State& kept) const
{
    std::vector<double> values;
    for (Point const& p : points_) {
        values.push_back(p.volume);
        for (Vector const* v : {&p.place, &p.velocity, &p.other, &p.start, &p.impulse})
            values.insert(values.end(), v->begin(), v->end());
    }
    kept.put("phase/id", std::span<std::int64_t const>(id_));
    kept.put("phase/points", std::span<double const>(values));
    kept.put_integer("phase/steps", steps_);
}

template <int D>
void Phase<D>::restore(sluice::State const& kept)
{
    auto const ids = kept.integers("phase/id");
    auto const values = kept.numbers("phase/points", numbers * ids.size());
    std::vector<Point> points(ids.size());
    double const* from = values.data();
    for (std::size_t i = 0; i < points.size(); ++i) {
        Point& p = points[i];
        p.volume = *from++;
        for (Vector* v : {&p.place, &p.velocity, &p.other, &p.start, &p.impulse}) {
            std::copy_n(from, D, v->begin());
            from += D;
        }
        require_usable(p, ids[i]);
    }
    id_.assign(ids.begin(), ids.end());
    points_ = std::move(points);
    steps_ = gathered_ = kept.integer("phase/steps");
    lay_out();
}

template class Phase<2>;
template class Phase<3>;
#define LBM_PHASE(D, Stored)                                                                                    \
    template void Phase<D>::add_to_row(std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t, Slots<D, Stored> const&, \
                                       Relaxation const&, SolidRowInput<Stored> const&);                        \
    template void Phase<D>::take_from_row(std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t, SolidRow<Stored> const&);
LBM_PHASE(2, double)
LBM_PHASE(2, float)
LBM_PHASE(3, double)
LBM_PHASE(3, float)
#undef LBM_PHASE

}  // namespace lbm
