// Links: what comes back from bodies, and what they get.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "participants/lbm/lanes.hpp"
#include "participants/lbm/links.hpp"

namespace lbm {
namespace {

constexpr double given_a_step = 0.1;  //!< of what is missing: a jump of one cell makes a whisper

//! Adds a momentum that acts at the end of an arm. Inlined, as cut(): calls would take 5 % of a step in space.
template <int D>
[[gnu::always_inline]] inline void add_at(typename Links<D>::Impulse& to, std::array<double, D> const& arm,
                                          std::array<double, D> const& momentum)
{
    for (std::size_t k = 0; k < D; ++k) to[k] += momentum[k];
    auto const moment = moment_of<D>(arm, momentum);
    for (std::size_t k = 0; k < moment.size(); ++k) to[D + k] += moment[k];
}

//! Lattice<D>::c as numbers.
template <int D>
constexpr auto directions = [] {
    std::array<std::array<double, D>, Lattice<D>::directions> all{};
    for (std::size_t q = 0; q < all.size(); ++q)
        for (std::size_t k = 0; k < D; ++k) all[q][k] = Lattice<D>::c[q][k];
    return all;
}();

//! Where from a cell at `arm` the link in direction q meets a circle or sphere about the origin, as a share of it.
template <int D>
[[gnu::always_inline]] inline double cut(std::array<double, D> const& arm, std::size_t q, double radius)
{
    auto const& c = directions<D>[q];
    double square = 0, along = 0, length = 0;  // of arm and c
    for (std::size_t k = 0; k < D; ++k) {
        square += arm[k] * arm[k];
        along += arm[k] * c[k];
        length += c[k] * c[k];
    }
    double const root = std::sqrt(std::max(along * along - length * (square - radius * radius), 0.0));
    return std::clamp((-along - root) * (length > 1 ? 0.5 : 1.0), 0.0, 1.0);  // over 2 or 1
}

//! Momentum that a surface of velocity u gets from what goes toward it and what comes back, less what fluid of that
//! velocity takes along (Wen et al., J. Comput. Phys. 266 (2014) 161).
template <int D>
std::array<double, D> exchanged(std::size_t q, std::array<double, D> const& u, double toward, double came)
{
    std::array<double, D> momentum;
    for (std::size_t k = 0; k < D; ++k)
        momentum[k] = (directions<D>[q][k] - u[k]) * toward + (directions<D>[q][k] + u[k]) * came;
    return momentum;
}

//! Weight of a direction in shares of the smallest: sums of whole numbers are exact in any order.
constexpr double smallest_weight = 1.0 / 36;
template <int D>
constexpr int shares_of(std::size_t q)
{
    return static_cast<int>(Lattice<D>::weight[q] / smallest_weight + 0.5);
}

}  // namespace

template <int D>
void Links<D>::reflect(Populations<D>& populations, std::span<Body<D> const> bodies, sluice::Team& team)
{
    auto const each_body = [&](auto&& visit) {
        team.share(static_cast<std::ptrdiff_t>(bodies.size()), 4, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) visit(i);
        });
    };
    weight_.assign(bodies.size(), 0.0);
    each_body([&](std::size_t i) {
        if (!has_all_of(bodies[i])) weight_[i] = weight_of(i, bodies[i]);
    });
    share_changes();
    parts_.resize(bodies.size());
    populations.visit([&](auto const& rows) { each_body([&](std::size_t i) { reflect_body(rows, i, bodies[i]); }); });
    share_sums();
    old_bodies_.assign(bodies.begin(), bodies.end());
}

//! A link from a fluid cell x into a cell n of a body. Its populations stand where streaming has brought them from x,
//! in ghost cells if n or the cell behind is another process's. What left x toward n stands in n; what came to x from
//! behind stands in x, and what left x backward in the cell behind: none of these is written by another link.
template <int D>
template <class Stored>
struct Links<D>::Link
{
    std::uint32_t q;            //!< direction into the body
    std::uint32_t layer;        //!< of x, from the lowest that reach the body
    double at;                  //!< where it is cut, as a share of it
    std::array<double, D> arm;  //!< of that place, from the body's centre
    Stored const* toward;
    Stored const *ahead = nullptr, *backward = nullptr;  //!< null: there is no fluid behind
    Stored* entering;

    //! The middle of the link.
    std::array<double, D> middle() const
    {
        std::array<double, D> m = arm;
        for (std::size_t k = 0; k < D; ++k) m[k] += (0.5 - at) * directions<D>[q][k];
        return m;
    }
};

//! Populations of a surface lie far apart: all are asked for before one is used.
template <int D>
template <class Stored>
typename Links<D>::template Link<Stored> Links<D>::find_link(Rows<D, Stored> const& rows, Body<D> const& body,
                                                             Cell const& cell, std::size_t q,
                                                             Source const& source) const
{
    using L = Lattice<D>;
    std::size_t const back = L::opposite[q];
    Extent const place = cells_.place_of(source.at);
    Extent ahead = place, behind = place;
    for (std::size_t k = 0; k < D; ++k) ahead[k] += L::c[q][k], behind[k] -= L::c[q][k];
    Link<Stored> link{.q = static_cast<std::uint32_t>(q),
                      .layer = 0,
                      .at = 0,
                      .arm = cell.arm,
                      .toward = &value(rows, q, ahead),
                      .entering = &value(rows, back, place)};
    if (source.fluid_behind) {
        link.ahead = &value(rows, q, place);
        link.backward = &value(rows, back, behind);
        __builtin_prefetch(link.ahead);
        __builtin_prefetch(link.backward);
    }
    __builtin_prefetch(link.toward);
    __builtin_prefetch(link.entering, 1);
    for (std::size_t k = 0; k < D; ++k) link.arm[k] -= directions<D>[q][k];
    link.at = cut<D>(link.arm, q, body.radius);
    for (std::size_t k = 0; k < D; ++k) link.arm[k] += link.at * directions<D>[q][k];
    return link;
}

template <int D>
template <class Stored>
void Links<D>::reflect_link(Link<Stored> const& link, Body<D> const& body, double excess_given, Sums& sums) const
{
    using L = Lattice<D>;
    std::size_t const q = link.q, back = L::opposite[q];
    auto const u = body.velocity_at(link.arm);
    double normal = 0, square = 0;
    for (std::size_t k = 0; k < D; ++k) {
        normal += directions<D>[q][k] * u[k];
        square += u[k] * u[k];
    }
    double const where = link.ahead ? link.at : 0.5, share = 1 / (1 + 2 * where), toward = *link.toward;
    double came = toward - L::weight[q] * (12 * share * normal - excess_given);
    if (link.ahead) came += (1 - 2 * where) * share * (*link.ahead - static_cast<double>(*link.backward));
    came = *link.entering = static_cast<Stored>(came);
    sums.missing += toward - came;
    double const dynamic = 4.5 * normal * normal - 1.5 * square;
    double const excess = (0.5 * (toward + came) / L::weight[q] - dynamic) / (1 + dynamic);
    // The pressure acts in the middle of the link, then an even one turns no body; all else where the link is cut
    auto const even = exchanged<D>(q, u, equilibrium<D>(q, excess, u), equilibrium<D>(back, excess, u)),
               all = exchanged<D>(q, u, toward, came);
    std::array<double, D> rest;
    for (std::size_t k = 0; k < D; ++k) {
        rest[k] = all[k] - even[k];
        sums.along[k] += u[k] * (toward - came);
    }
    auto const middle = link.middle();
    add_at<D>(sums.impulse, middle, even);
    add_at<D>(sums.impulse, link.arm, rest);
    sums.excess += excess - hydrostatic(middle);
    sums.links += 1;
}

//! By how much fluid at rest is denser at the end of an arm: grad rho c_s^2 is the body force.
template <int D>
double Links<D>::hydrostatic(std::array<double, D> const& arm) const
{
    double excess = 0;
    for (std::size_t k = 0; k < D; ++k) excess += 6 * half_force_[k] * arm[k];
    return excess;
}

//! By the cell that it leads into, of a link that does not come from fluid.
template <int D>
void Links<D>::press(Body<D> const& body, Cell const& cell, std::size_t q, Sums& sums) const
{
    using L = Lattice<D>;
    std::size_t const back = L::opposite[q];
    auto arm = cell.arm;
    for (std::size_t k = 0; k < D; ++k) arm[k] -= 0.5 * L::c[q][k];
    double const density = hydrostatic(arm);
    auto const u = body.velocity_at(cell.arm);
    for (std::size_t k = 0; k < D; ++k) sums.missing += 6 * L::weight[q] * L::c[q][k] * u[k];
    auto const at = [&](double excess) {
        return exchanged<D>(q, u, equilibrium<D>(q, excess, u), equilibrium<D>(back, excess, u));
    };
    auto const still = at(density);
    auto slope = at(density + 1);  // pressure is linear in it
    for (std::size_t k = 0; k < D; ++k) slope[k] -= still[k];
    add_at<D>(sums.still, arm, still);
    add_at<D>(sums.per_excess, arm, slope);
}

//! Cells of this process within a body.
template <int D>
void Links<D>::add_cells(std::size_t i, std::ptrdiff_t lowest, std::span<Sums> layers) const
{
    for (Run const& run : cells_.runs(i)) {
        if (!cells_.is_here(run.first.at)) continue;
        Sums& sums = layers[static_cast<std::size_t>(run.first.layer - lowest)];
        auto const count = static_cast<double>(run.count);
        sums.cells += count;
        for (std::size_t k = 0; k < D; ++k) sums.moment[k] += count * run.first.arm[k];
        sums.moment[0] += 0.5 * count * (count - 1);
    }
}

template <int D>
template <class Stored>
void Links<D>::reflect_body(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body)
{
    thread_local std::vector<Link<Stored>> links;
    thread_local std::vector<Sums> layers;
    parts_[i].clear();
    if (cells_.runs(i).empty()) return;
    auto const [begin, end] = cells_.reach(body);
    links.clear();
    layers.assign(static_cast<std::size_t>(end - begin), Sums{});
    int weight = 0;
    each_link(i, body, [&](Cell const& cell, std::size_t q, Source const& source) {
        auto const layer = static_cast<std::uint32_t>(source.layer - begin);
        if (!source.fluid) return press(body, cell, q, layers[layer]);
        links.push_back(find_link(rows, body, cell, q, source));
        links.back().layer = layer;
        weight += shares_of<D>(q);
    });
    if (weight_[i] > 0) weight = static_cast<int>(weight_[i]);  // with the links of others
    double const given = weight > 0 ? given_a_step * missing_[i] / (weight * smallest_weight) : 0.0;
    for (Link<Stored> const& link : links) reflect_link(link, body, given, layers[link.layer]);
    for (Run const& run : cells_.runs(i))
        if (cells_.is_here(run.first.at)) fill(rows, body, run);
    add_cells(i, begin, layers);
    for (Taken const& taken : std::ranges::equal_range(taken_, static_cast<std::int32_t>(i), {}, &Taken::body)) {
        Sums& sums = layers[static_cast<std::size_t>(taken.cell.layer - begin)];
        add_at<D>(sums.impulse, taken.cell.arm, taken.momentum);
        for (std::size_t k = 0; k < D; ++k) sums.along[k] += taken.along[k];
    }
    for (std::ptrdiff_t layer = begin; layer < end; ++layer)
        if (cells_.has(layer))
            parts_[i].push_back(
                {i, layer,
                 std::bit_cast<std::array<double, numbers>>(layers[static_cast<std::size_t>(layer - begin)])});
    if (has_all_of(body)) join(parts_[i], 0);
}

//! A bit for each direction but rest.
template <int D>
constexpr std::uint32_t every_direction = (1U << Lattice<D>::directions) - 2;

//! A bit for each direction by which a link into a cell comes from one that is not the body's: few are, and not the
//! same from cell to cell, so that all are looked at before one is branched on.
template <int D>
std::uint32_t Links<D>::not_from(std::int32_t body, std::int32_t const* of_cell) const noexcept
{
    std::uint32_t directions = 0;
    for (std::size_t q = 1; q < Lattice<D>::directions; ++q)
        directions |= static_cast<std::uint32_t>(of_cell[-cells_.offset(q)] != body) << q;
    return directions;
}

//! Calls `each(cell within the body, direction into it, the fluid cell it comes from or null, layer)` for the links
//! from outside that are this process's. The layer is that of where they come from, of the cell if that is no place.
template <int D>
template <class Each>
void Links<D>::each_link(std::size_t i, Body<D> const& body, Each&& each) const
{
    using L = Lattice<D>;
    double const deep = std::max(body.radius - std::numbers::sqrt2, 0.0);  // links are no longer
    auto const self = static_cast<std::int32_t>(i);
    for (Run const& run : cells_.runs(i)) {
        bool const inner = cells_.is_inner(run);
        Cells::each_cell(run, [&](Cell const& cell) {
            double square = 0;
            for (double const a : cell.arm) square += a * a;
            if (square < deep * deep) return;
            std::int32_t const* const of_cell = cells_.owner_of(cell.at);
            std::uint32_t directions = every_direction<D>;
            if (inner) directions = not_from(self, of_cell);
            for (; directions != 0; directions &= directions - 1) {
                auto const q = static_cast<std::size_t>(std::countr_zero(directions));
                Extent from = cell.at;
                bool const there = cells_.step(from, L::opposite[q]);
                if (!cells_.is_here(there ? from : cell.at)) continue;
                std::int32_t const owner = there ? cells_.owner(from) : Cells::vacated;
                if (owner == self) continue;
                Source source{from, cell.layer - (there ? L::c[q][D - 1] : 0), owner == Cells::nobody, false};
                if (source.fluid)
                    source.fluid_behind =
                        inner ? of_cell[-2 * cells_.offset(q)] == Cells::nobody : step_to_fluid(from, L::opposite[q]);
                each(cell, q, source);
            }
        });
    }
}

//! Of the links to a body that are this process's, in shares_of().
template <int D>
double Links<D>::weight_of(std::size_t i, Body<D> const& body) const
{
    int weight = 0;
    each_link(i, body, [&](Cell const&, std::size_t q, Source const& source) {
        if (source.fluid) weight += shares_of<D>(q);
    });
    return weight;
}

//! Cells within a body move as it does, with density 1.
template <int D>
template <class Stored>
void Links<D>::fill(Rows<D, Stored> const& rows, Body<D> const& body, Run const& run) const
{
    using L = Lattice<D>;
    Extent const place = cells_.place_of(run.first.at);
    std::array<double, D> const first = body.velocity_at(run.first.arm);
    auto next = run.first.arm;
    next[0] += 1;
    std::array<double, D> slope = body.velocity_at(next);
    for (std::size_t k = 0; k < D; ++k) slope[k] -= first[k];
    Slots<D, Stored> to;
    for (std::size_t q = 0; q < L::directions; ++q) to[q] = &value(rows, q, place);
    using V = Lanes<double>;
    constexpr auto lanes = static_cast<std::ptrdiff_t>(V::count);
    auto const fill_cells = [&](std::ptrdiff_t begin, Slots<D, Stored> const& slots) {  // as many as V has room for
        V const cell = counted_from<V>(static_cast<double>(begin));
        std::array<V, D> u;
        V square{};
        for (std::size_t k = 0; k < D; ++k) {
            u[k] = first[k] + cell * slope[k];
            square = square + u[k] * u[k];
        }
        for (std::size_t q = 0; q < L::directions; ++q) {
            V along{};
            for (std::size_t k = 0; k < D; ++k) along = along + directions<D>[q][k] * u[k];
            V const odd = 3.0 * (along - dot(L::c[q], half_force_));
            store(slots[q] + begin, L::weight[q] * (odd + 4.5 * along * along - 1.5 * square));
        }
    };
    if (run.count >= lanes) {  // the last ones again with some of those before
        for (std::ptrdiff_t x = 0; x + lanes <= run.count; x += lanes) fill_cells(x, to);
        if (run.count % lanes != 0) fill_cells(run.count - lanes, to);
        return;
    }
    Stored cells[L::directions][lanes];
    Slots<D, Stored> at;
    for (std::size_t q = 0; q < L::directions; ++q) at[q] = cells[q];
    fill_cells(0, at);
    for (std::size_t q = 0; q < L::directions; ++q) std::copy_n(cells[q], run.count, to[q]);
}

#define LBM_REFLECTED_LINKS(D) \
    template void Links<D>::reflect(Populations<D>&, std::span<Body<D> const>, sluice::Team&);
LBM_REFLECTED_LINKS(2)
LBM_REFLECTED_LINKS(3)
#undef LBM_REFLECTED_LINKS

}  // namespace lbm
