// Links: which cells bodies take and leave.
#include "participants/lbm/links.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace lbm {
namespace {

//! Density excess and momentum of a cell; half of the body force is not in it.
template <int D>
struct Moments
{
    double excess = 0;
    std::array<double, D> momentum{};

    explicit Moments(std::array<double, Lattice<D>::directions> const& populations)
    {
        for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
            excess += populations[q];
            for (std::size_t k = 0; k < D; ++k) momentum[k] += Lattice<D>::c[q][k] * populations[q];
        }
    }
};

}  // namespace

template <int D>
void Links<D>::begin(std::size_t bodies, std::array<double, 3> const& half_force)
{
    impulse_.assign(bodies, Impulse{});
    pressed_.assign(bodies, Impulse{});
    sums_.assign(bodies, Sums{});
    given_back_ = {};
    half_force_ = half_force;
}

template <int D>
void Links<D>::restore(std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                       std::array<double, 3> const& half_force, std::span<double const> missing)
{
    begin(bodies.size(), half_force);
    missing_.assign(missing.begin(), missing.end());
    cells_.restart(bodies);
    id_.assign(id.begin(), id.end());
    old_bodies_.assign(bodies.begin(), bodies.end());
}

template <int D>
void Links<D>::place(Populations<D>& populations, std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                     std::array<double, 3> const& half_force)
{
    begin(bodies.size(), half_force);
    cells_.move(bodies);
    fetch_neighbours(populations);
    follow(id);
    changes_.clear();
    taken_.clear();
    auto const note = [&](std::size_t which, Cell const& cell, Change const& change) {
        if (changes_.empty() || changes_.back().which != which || changes_.back().layer != cell.layer)
            changes_.push_back({which, cell.layer, {}});
        auto const some = std::bit_cast<std::array<double, changes>>(change);
        for (std::size_t k = 0; k < changes; ++k) changes_.back().sum[k] += some[k];
    };
    populations.visit([&](auto const& rows) {
        for (auto const& [body, cell] : cells_.left()) {
            auto const i = static_cast<std::size_t>(body);
            if (cells_.is_here(cell.at)) note(bodies.size() + i, cell, uncover(rows, old_bodies_[i], cell));
        }
        for (auto const& [body, cell] : cells_.entered()) {
            auto const i = static_cast<std::size_t>(body);
            if (was_[i] != nothing) note(i, cell, cover(rows, bodies[i], {body, cell}));
        }
    });
    cells_.settle();
}

//! Brings what is kept of the bodies into the order of now.
template <int D>
void Links<D>::follow(std::span<std::uint64_t const> id)
{
    was_.resize(id.size());
    std::iota(was_.begin(), was_.end(), std::ptrdiff_t{0});
    if (std::ranges::equal(id, id_)) return;
    std::unordered_map<std::uint64_t, std::ptrdiff_t> known;
    for (std::size_t i = 0; i < id_.size(); ++i) known.emplace(id_[i], static_cast<std::ptrdiff_t>(i));
    std::vector<double> missing(id.size());
    for (std::size_t i = 0; i < id.size(); ++i) {
        auto const found = known.find(id[i]);
        was_[i] = found == known.end() ? nothing : found->second;
        if (was_[i] != nothing) missing[i] = missing_[static_cast<std::size_t>(was_[i])];
    }
    missing_ = std::move(missing);
    id_.assign(id.begin(), id.end());
}

//! Fluid that a body comes to lie on takes the body's velocity; the difference is the body's.
template <int D>
template <class Stored>
typename Links<D>::Change Links<D>::cover(Rows<D, Stored> const& rows, Body<D> const& body,
                                          typename Cells::Changed const& change)
{
    Moments<D> const m(populations_of(rows, change.cell.at));
    auto const u = body.velocity_at(change.cell.arm);
    Taken taken{.body = change.body, .cell = change.cell, .momentum = m.momentum, .along = {}};
    for (std::size_t k = 0; k < D; ++k) {
        taken.along[k] = (1 + m.excess) * u[k] - half_force_[k];
        taken.momentum[k] -= taken.along[k];
    }
    taken_.push_back(taken);
    return {.excess = m.excess};
}

//! Fluid where a body was: with its velocity, and what the fluid around has of density and stress in the mean.
template <int D>
template <class Stored>
typename Links<D>::Change Links<D>::uncover(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell) const
{
    using L = Lattice<D>;
    CellPopulations stress{};
    double excess = 0, count = 0;
    for (std::size_t p = 1; p < L::directions; ++p) {
        Extent there = cell.at;
        if (!step_to_fluid(there, p)) continue;
        auto const populations = populations_of(rows, there);
        Moments<D> m(populations);
        for (std::size_t k = 0; k < D; ++k) m.momentum[k] = (m.momentum[k] + half_force_[k]) / (1 + m.excess);
        for (std::size_t q = 0; q < L::directions; ++q)
            stress[q] += populations[q] - equilibrium<D>(q, m.excess, m.momentum);
        excess += m.excess;
        ++count;
    }
    double const share = count > 0 ? 1 / count : 0.0;
    excess *= share;
    std::array<double, D> odd{};  // what the stress must not have: momentum
    for (std::size_t q = 0; q < L::directions; ++q)
        for (std::size_t k = 0; k < D; ++k) odd[k] += share * stress[q] * L::c[q][k];
    auto const u = body.velocity_at(cell.arm);
    Extent const place = cells_.place_of(cell.at);
    for (std::size_t q = 0; q < L::directions; ++q) {
        double f = equilibrium<D>(q, excess, u) + share * stress[q];
        for (std::size_t k = 0; k < D; ++k) f -= 3 * L::weight[q] * L::c[q][k] * (odd[k] + half_force_[k]);
        value(rows, q, place) = static_cast<Stored>(f);
    }
    Change change{.excess = excess};
    for (std::size_t k = 0; k < D; ++k) change.given_back[k] = (1 + excess) * u[k] - half_force_[k];
    return change;
}

template <int D>
std::array<double, D> Links<D>::taken_along() const
{
    std::array<double, D> sum{};
    for (std::size_t k = 0; k < D; ++k) {
        for (Sums const& sums : sums_) sum[k] += sums.along[k];
        sum[k] -= given_back_[k];
    }
    return sum;
}

#define LBM_LINKS(D)                                                                                         \
    template void Links<D>::place(Populations<D>&, std::span<Body<D> const>, std::span<std::uint64_t const>, \
                                  std::array<double, 3> const&);                                             \
    template void Links<D>::restore(std::span<Body<D> const>, std::span<std::uint64_t const>,                \
                                    std::array<double, 3> const&, std::span<double const>);                  \
    template std::array<double, D> Links<D>::taken_along() const;
LBM_LINKS(2)
LBM_LINKS(3)
#undef LBM_LINKS

}  // namespace lbm
