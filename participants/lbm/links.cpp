#include "participants/lbm/links.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

namespace lbm {
namespace {

constexpr double given_a_step = 0.1;  //!< of what is missing: a jump of one cell makes a whisper

//! Adds a momentum that acts at the end of an arm.
template <int D>
void add_at(typename Links<D>::Impulse& to, std::array<double, D> const& arm, std::array<double, D> const& momentum)
{
    for (std::size_t k = 0; k < D; ++k) to[k] += momentum[k];
    auto const moment = moment_of<D>(arm, momentum);
    for (std::size_t k = 0; k < moment.size(); ++k) to[D + k] += moment[k];
}

template <int D, class Stored>
Stored& value(Rows<D, Stored> const& rows, std::size_t q, Extent const& at)
{
    return rows.at(0, q, at[1], at[2])[at[0]];
}

//! Density excess and momentum of a cell; half of the body force is not in it.
template <int D>
struct Moments
{
    double excess = 0;
    std::array<double, D> momentum{};

    template <class Stored>
    Moments(Rows<D, Stored> const& rows, Extent const& at)
    {
        for (std::size_t q = 0; q < Lattice<D>::directions; ++q) {
            double const f = value(rows, q, at);
            excess += f;
            for (std::size_t k = 0; k < D; ++k) momentum[k] += Lattice<D>::c[q][k] * f;
        }
    }
};

//! Where from a cell at `arm` the link in direction c meets a circle or sphere about the origin, as a share of it.
template <int D>
double cut(std::array<double, D> const& arm, std::array<int, 3> const& c, double radius)
{
    double square = 0, along = 0, length = 0;
    for (std::size_t k = 0; k < D; ++k) {
        square += arm[k] * arm[k];
        along += arm[k] * c[k];
        length += c[k] * c[k];
    }
    double const root = std::sqrt(std::max(along * along - length * (square - radius * radius), 0.0));
    return std::clamp((-along - root) / length, 0.0, 1.0);
}

//! Momentum that a surface of velocity u gets from what goes toward it and what comes back, less what fluid of that
//! velocity takes along (Wen et al., J. Comput. Phys. 266 (2014) 161).
template <int D>
std::array<double, D> exchanged(std::size_t q, std::array<double, D> const& u, double toward, double came)
{
    std::array<double, D> momentum;
    for (std::size_t k = 0; k < D; ++k)
        momentum[k] = (Lattice<D>::c[q][k] - u[k]) * toward + (Lattice<D>::c[q][k] + u[k]) * came;
    return momentum;
}

}  // namespace

template <int D>
Links<D>::Links(Extent cells, std::array<bool, 3> periodic)
    : cells_(cells),
      periodic_(periodic),
      owner_(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]), nobody),
      first_{0}
{}

//! To the cell at +c_q; false: outside of the domain.
template <int D>
bool Links<D>::step(Extent& at, std::size_t q) const noexcept
{
    for (std::size_t k = 0; k < D; ++k) {
        at[k] += Lattice<D>::c[q][k];
        if (at[k] >= 0 && at[k] < cells_[k]) continue;
        if (!periodic_[k]) return false;
        at[k] = wrap(at[k], cells_[k]);
    }
    return true;
}

template <int D>
template <class Each>
void Links<D>::each_cell(Run const& run, Each&& each)
{
    Cell cell{run.first, run.arm};
    for (std::ptrdiff_t k = 0; k < run.count; ++k, ++cell.at[0], cell.arm[0] += 1) each(cell);
}

template <int D>
void Links<D>::list(std::span<Body<D> const> bodies)
{
    runs_.clear();
    first_.assign(1, 0);
    count_.assign(bodies.size(), 0);
    moment_.assign(bodies.size(), {});
    entered_.clear();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        Body<D> const& b = bodies[i];
        // cells whose centre k + 1/2 is within the radius
        auto const low = [&](std::size_t k) {
            return static_cast<std::ptrdiff_t>(std::ceil(b.centre[k] - b.radius - 0.5));
        };
        auto const high = [&](std::size_t k) {
            return static_cast<std::ptrdiff_t>(std::floor(b.centre[k] + b.radius - 0.5));
        };
        std::ptrdiff_t const bottom = D == 3 ? low(D - 1) : 0, top = D == 3 ? high(D - 1) : 0;
        for (std::ptrdiff_t z = bottom; z <= top; ++z)
            for (std::ptrdiff_t y = low(1); y <= high(1); ++y) list_row(static_cast<std::int32_t>(i), b, {0, y, z});
        first_.push_back(runs_.size());
    }
}

//! The cells of a row within a body that no body before it has.
template <int D>
void Links<D>::list_row(std::int32_t body, Body<D> const& b, Extent at)
{
    Cell cell;
    double square = b.radius * b.radius;
    for (std::size_t k = 1; k < D; ++k) {
        cell.arm[k] = static_cast<double>(at[k]) + 0.5 - b.centre[k];
        square -= cell.arm[k] * cell.arm[k];
        if (periodic_[k]) at[k] = wrap(at[k], cells_[k]);
        if (at[k] < 0 || at[k] >= cells_[k]) return;
    }
    if (square < 0) return;
    double const half = std::sqrt(square);
    auto const end = static_cast<std::ptrdiff_t>(std::floor(b.centre[0] + half - 0.5));
    for (auto x = static_cast<std::ptrdiff_t>(std::ceil(b.centre[0] - half - 0.5)); x <= end; ++x) {
        at[0] = periodic_[0] ? wrap(x, cells_[0]) : x;
        if (at[0] < 0 || at[0] >= cells_[0]) continue;
        cell.at = at;
        cell.arm[0] = static_cast<double>(x) + 0.5 - b.centre[0];
        own(body, cell);
    }
}

template <int D>
void Links<D>::own(std::int32_t body, Cell const& cell)
{
    std::int32_t& owner = owner_[index(cell.at)];
    if (owner >= 0) return;
    if (owner == nobody) entered_.push_back({body, cell});
    owner = body;
    auto const i = static_cast<std::size_t>(body);
    ++count_[i];
    for (std::size_t k = 0; k < D; ++k) moment_[i][k] += cell.arm[k];
    if (runs_.size() > first_.back()) {
        Run& last = runs_.back();
        bool const same_row = last.first[1] == cell.at[1] && last.first[2] == cell.at[2];
        if (same_row && last.first[0] + last.count == cell.at[0]) {
            ++last.count;
            return;
        }
    }
    runs_.push_back({cell.at, 1, cell.arm});
}

template <int D>
void Links<D>::begin(std::size_t bodies, std::array<double, 3> const& half_force)
{
    impulse_.assign(bodies, Impulse{});
    pressed_.assign(bodies, Impulse{});
    along_.assign(bodies, {});
    given_back_ = {};
    half_force_ = half_force;
}

template <int D>
void Links<D>::restore(std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                       std::array<double, 3> const& half_force, std::span<double const> missing)
{
    begin(bodies.size(), half_force);
    missing_.assign(missing.begin(), missing.end());
    std::ranges::fill(owner_, nobody);
    list(bodies);
    id_.assign(id.begin(), id.end());
    old_bodies_.assign(bodies.begin(), bodies.end());
}

template <int D>
void Links<D>::place(Populations<D>& populations, std::span<Body<D> const> bodies, std::span<std::uint64_t const> id,
                     std::array<double, 3> const& half_force)
{
    begin(bodies.size(), half_force);
    std::swap(old_runs_, runs_);
    std::swap(old_first_, first_);
    for (Run const& run : old_runs_)
        std::fill_n(owner_.begin() + static_cast<std::ptrdiff_t>(index(run.first)), run.count, vacated);
    list(bodies);
    std::vector<std::size_t> freed;
    populations.visit([&](auto const& rows) {
        for (std::size_t i = 0; i < old_bodies_.size(); ++i)
            for (std::size_t r = old_first_[i]; r < old_first_[i + 1]; ++r)
                each_cell(old_runs_[r], [&](Cell const& cell) {
                    if (owner_[index(cell.at)] != vacated) return;
                    missing_[i] -= uncover(rows, old_bodies_[i], cell);
                    freed.push_back(index(cell.at));
                });
        auto const is_new = follow(id);
        for (auto const& [body, cell] : entered_) {
            auto const i = static_cast<std::size_t>(body);
            if (!is_new[i]) missing_[i] += cover(rows, i, bodies[i], cell);
        }
    });
    for (std::size_t const cell : freed) owner_[cell] = nobody;
    old_bodies_.assign(bodies.begin(), bodies.end());
}

//! Brings what is kept of the bodies into the order of now; tells which were not there before.
template <int D>
std::vector<char> Links<D>::follow(std::span<std::uint64_t const> id)
{
    std::vector<char> is_new(id.size(), 0);
    if (std::ranges::equal(id, id_)) return is_new;
    std::unordered_map<std::uint64_t, double> known;
    for (std::size_t i = 0; i < id_.size(); ++i) known.emplace(id_[i], missing_[i]);
    missing_.assign(id.size(), 0.0);
    for (std::size_t i = 0; i < id.size(); ++i) {
        auto const found = known.find(id[i]);
        is_new[i] = found == known.end();
        if (!is_new[i]) missing_[i] = found->second;
    }
    id_.assign(id.begin(), id.end());
    return is_new;
}

//! Fluid that a body comes to lie on takes the body's velocity; the difference is the body's. Returns its density
//! excess.
template <int D>
template <class Stored>
double Links<D>::cover(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body, Cell const& cell)
{
    Moments<D> const m(rows, cell.at);
    auto const u = body.velocity_at(cell.arm);
    std::array<double, D> given;
    for (std::size_t k = 0; k < D; ++k) {
        double const own = (1 + m.excess) * u[k] - half_force_[k];
        given[k] = m.momentum[k] - own;
        along_[i][k] += own;
    }
    add_at<D>(impulse_[i], cell.arm, given);
    return m.excess;
}

//! Fluid where a body was: with its velocity, and what the fluid around has of density and stress in the mean. Returns
//! its density excess.
template <int D>
template <class Stored>
double Links<D>::uncover(Rows<D, Stored> const& rows, Body<D> const& body, Cell const& cell)
{
    using L = Lattice<D>;
    std::array<double, L::directions> stress{};
    double excess = 0, count = 0;
    for (std::size_t p = 1; p < L::directions; ++p) {
        Extent there = cell.at;
        if (!step(there, p) || !is_fluid(there)) continue;
        Moments<D> m(rows, there);
        for (std::size_t k = 0; k < D; ++k) m.momentum[k] = (m.momentum[k] + half_force_[k]) / (1 + m.excess);
        for (std::size_t q = 0; q < L::directions; ++q)
            stress[q] += value(rows, q, there) - equilibrium<D>(q, m.excess, m.momentum);
        excess += m.excess;
        ++count;
    }
    double const share = count > 0 ? 1 / count : 0.0;
    excess *= share;
    std::array<double, D> odd{};  // what the stress must not have: momentum
    for (std::size_t q = 0; q < L::directions; ++q)
        for (std::size_t k = 0; k < D; ++k) odd[k] += share * stress[q] * L::c[q][k];
    auto const u = body.velocity_at(cell.arm);
    for (std::size_t q = 0; q < L::directions; ++q) {
        double f = equilibrium<D>(q, excess, u) + share * stress[q];
        for (std::size_t k = 0; k < D; ++k) f -= 3 * L::weight[q] * L::c[q][k] * (odd[k] + half_force_[k]);
        value(rows, q, cell.at) = static_cast<Stored>(f);
    }
    for (std::size_t k = 0; k < D; ++k) given_back_[k] += (1 + excess) * u[k] - half_force_[k];
    return excess;
}

//! Cells within a body move as it does, with density 1.
template <int D>
template <class Stored>
void Links<D>::fill(Rows<D, Stored> const& rows, Body<D> const& body, Run const& run) const
{
    using L = Lattice<D>;
    constexpr std::ptrdiff_t at_once = 64;
    std::array<double, D> const first = body.velocity_at(run.arm);
    auto next = run.arm;
    next[0] += 1;
    std::array<double, D> slope = body.velocity_at(next);
    for (std::size_t k = 0; k < D; ++k) slope[k] -= first[k];
    for (std::ptrdiff_t begin = 0; begin < run.count; begin += at_once) {
        std::ptrdiff_t const count = std::min(at_once, run.count - begin);
        double u[D][at_once], square[at_once];
        for (std::ptrdiff_t x = 0; x < count; ++x) {
            square[x] = 0;
            for (std::size_t k = 0; k < D; ++k) {
                u[k][x] = first[k] + static_cast<double>(begin + x) * slope[k];
                square[x] += u[k][x] * u[k][x];
            }
        }
        for (std::size_t q = 0; q < L::directions; ++q) {
            double const w = L::weight[q], half = dot(L::c[q], half_force_);
            Stored* const to = &value(rows, q, run.first) + begin;
            for (std::ptrdiff_t x = 0; x < count; ++x) {
                double along = 0;
                for (std::size_t k = 0; k < D; ++k) along += L::c[q][k] * u[k][x];
                to[x] = static_cast<Stored>(w * (3 * (along - half) + 4.5 * along * along - 1.5 * square[x]));
            }
        }
    }
}

template <int D>
void Links<D>::reflect(Populations<D>& populations, std::span<Body<D> const> bodies, sluice::Team& team)
{
    populations.visit([&](auto const& rows) {
        team.share(static_cast<std::ptrdiff_t>(bodies.size()), 4, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                reflect_body(rows, i, bodies[i]);
        });
    });
}

//! A link from a fluid cell x into a cell n of a body. What left x toward n now stands in n; what came to x from behind
//! stands in x, and what left x backward in the cell behind: none of these is written by another link.
template <int D>
template <class Stored>
struct Links<D>::Link
{
    std::size_t q;              //!< direction into the body
    double at;                  //!< where it is cut, as a share of it
    std::array<double, D> arm;  //!< of that place, from the body's centre
    Stored const* toward;
    Stored const *ahead = nullptr, *backward = nullptr;  //!< null: there is no fluid behind
    Stored* entering;

    //! The middle of the link.
    std::array<double, D> middle() const
    {
        std::array<double, D> m = arm;
        for (std::size_t k = 0; k < D; ++k) m[k] += (0.5 - at) * Lattice<D>::c[q][k];
        return m;
    }
};

//! Populations of a surface lie far apart: all are asked for before one is used.
template <int D>
template <class Stored>
typename Links<D>::template Link<Stored> Links<D>::find_link(Rows<D, Stored> const& rows, Body<D> const& body,
                                                             Cell const& cell, std::size_t q, Extent const& x) const
{
    using L = Lattice<D>;
    std::size_t const back = L::opposite[q];
    Link<Stored> link{
        .q = q, .at = 0, .arm = cell.arm, .toward = &value(rows, q, cell.at), .entering = &value(rows, back, x)};
    Extent behind = x;
    if (step(behind, back) && is_fluid(behind)) {
        link.ahead = &value(rows, q, x);
        link.backward = &value(rows, back, behind);
        __builtin_prefetch(link.ahead);
        __builtin_prefetch(link.backward);
    }
    __builtin_prefetch(link.toward);
    __builtin_prefetch(link.entering, 1);
    for (std::size_t k = 0; k < D; ++k) link.arm[k] -= L::c[q][k];
    link.at = cut<D>(link.arm, L::c[q], body.radius);
    for (std::size_t k = 0; k < D; ++k) link.arm[k] += link.at * L::c[q][k];
    return link;
}

//! Returns the density excess there.
template <int D>
template <class Stored>
double Links<D>::reflect_link(Link<Stored> const& link, std::size_t i, Body<D> const& body, double excess_given)
{
    using L = Lattice<D>;
    std::size_t const q = link.q, back = L::opposite[q];
    auto const u = body.velocity_at(link.arm);
    double normal = 0, square = 0;
    for (std::size_t k = 0; k < D; ++k) {
        normal += L::c[q][k] * u[k];
        square += u[k] * u[k];
    }
    double const where = link.ahead ? link.at : 0.5, share = 1 / (1 + 2 * where), toward = *link.toward;
    double came = toward - L::weight[q] * (12 * share * normal - excess_given);
    if (link.ahead) came += (1 - 2 * where) * share * (*link.ahead - static_cast<double>(*link.backward));
    came = *link.entering = static_cast<Stored>(came);
    missing_[i] += toward - came;
    double const dynamic = 4.5 * normal * normal - 1.5 * square;
    double const excess = (0.5 * (toward + came) / L::weight[q] - dynamic) / (1 + dynamic);
    // The pressure acts in the middle of the link, then an even one turns no body; all else where the link is cut
    auto const even = exchanged<D>(q, u, equilibrium<D>(q, excess, u), equilibrium<D>(back, excess, u)),
               all = exchanged<D>(q, u, toward, came);
    std::array<double, D> rest;
    for (std::size_t k = 0; k < D; ++k) {
        rest[k] = all[k] - even[k];
        along_[i][k] += u[k] * (toward - came);
    }
    add_at<D>(impulse_[i], link.middle(), even);
    add_at<D>(impulse_[i], link.arm, rest);
    return excess;
}

//! By how much fluid at rest is denser at the end of an arm: grad rho c_s^2 is the body force.
template <int D>
double Links<D>::hydrostatic(std::array<double, D> const& arm) const
{
    double excess = 0;
    for (std::size_t k = 0; k < D; ++k) excess += 6 * half_force_[k] * arm[k];
    return excess;
}

template <int D>
template <class Stored>
void Links<D>::reflect_body(Rows<D, Stored> const& rows, std::size_t i, Body<D> const& body)
{
    thread_local std::vector<Link<Stored>> links;
    links.clear();
    bool pressed = false;
    each_link(i, body, [&](Cell const& cell, std::size_t q, Extent const* fluid) {
        pressed = pressed || !fluid;
        if (fluid) links.push_back(find_link(rows, body, cell, q, *fluid));
    });
    double weights = 0, excess = 0;  // excess: of the fluid beside it, at the body's centre
    for (Link<Stored> const& link : links) weights += Lattice<D>::weight[link.q];
    double const given = links.empty() ? 0.0 : given_a_step * missing_[i] / weights;
    for (Link<Stored> const& link : links) excess += reflect_link(link, i, body, given) - hydrostatic(link.middle());
    if (pressed) press(i, body, links.empty() ? 0.0 : excess / static_cast<double>(links.size()));
    for (std::size_t r = first_[i]; r < first_[i + 1]; ++r) fill(rows, body, runs_[r]);
}

//! Calls `each(cell within the body, direction into it, the fluid cell it comes from or null)` for links from outside.
template <int D>
template <class Each>
void Links<D>::each_link(std::size_t i, Body<D> const& body, Each&& each) const
{
    double const deep = std::max(body.radius - std::numbers::sqrt2, 0.0);  // links are no longer
    auto const each_of = [&](Cell const& cell) {
        double square = 0;
        for (double const a : cell.arm) square += a * a;
        if (square < deep * deep) return;
        for (std::size_t q = 1; q < Lattice<D>::directions; ++q) {
            Extent from = cell.at;
            bool const there = step(from, Lattice<D>::opposite[q]);
            std::int32_t const owner = there ? owner_[index(from)] : vacated;
            if (owner != static_cast<std::int32_t>(i)) each(cell, q, owner == nobody ? &from : nullptr);
        }
    };
    for (std::size_t r = first_[i]; r < first_[i + 1]; ++r) each_cell(runs_[r], each_of);
}

template <int D>
void Links<D>::press(std::size_t i, Body<D> const& body, double excess)
{
    using L = Lattice<D>;
    each_link(i, body, [&](Cell const& cell, std::size_t q, Extent const* fluid) {
        if (fluid) return;
        auto arm = cell.arm;
        for (std::size_t k = 0; k < D; ++k) arm[k] -= 0.5 * L::c[q][k];
        double const density = excess + hydrostatic(arm);
        auto const u = body.velocity_at(cell.arm);
        for (std::size_t k = 0; k < D; ++k) missing_[i] += 6 * L::weight[q] * L::c[q][k] * u[k];
        add_at<D>(pressed_[i], arm,
                  exchanged<D>(q, u, equilibrium<D>(q, density, u), equilibrium<D>(L::opposite[q], density, u)));
    });
}

template <int D>
std::array<double, D> Links<D>::taken_along() const
{
    std::array<double, D> sum{};
    for (std::size_t k = 0; k < D; ++k) {
        for (auto const& along : along_) sum[k] += along[k];
        sum[k] -= given_back_[k];
    }
    return sum;
}

template class Links<2>;
template class Links<3>;

}  // namespace lbm
