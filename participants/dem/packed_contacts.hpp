#pragma once

#include <array>

#include "participants/dem/packed_losses.hpp"
#include "participants/dem/packed_stiffness.hpp"

//! The pairs of spheres four at a time. What is computed for one, and in which order it is added up, is add_pair()'s,
//! to the last bit; that one stays the oracle (Setup::plain) and takes the contacts that begin within a step.
//!
//! First the listed pairs are sieved, four at a time, for those that touch. Then rows of the two grains (32 bytes:
//! centre and radius, velocity, spin) are loaded and transposed, the laws evaluated on columns, and forces transposed
//! back and added row by row.
namespace dem {

//! Whether pairs of these features are computed in packs.
constexpr bool is_packed(Features const& f, int dimension)
{
    return dimension == 3 && f.friction;
}

struct PackLimited
{
    PackVec force, spring;
    PackMask slides;
};
//! As limited() in tangential_force.hpp.
inline PackLimited limited(PackVec spring, PackVec dashpot, Pack limit) noexcept
{
    PackVec const trial = spring + dashpot;
    Pack const square = dot(trial, trial);
    PackMask const slides = square > limit * limit;
    if (bits(slides) == 0) return {trial, spring, slides};
    PackVec const force = (limit / root(square)) * trial;
    return {either(slides, force, trial), either(slides, force - dashpot, spring), slides};
}

//! As carried() in vec.hpp.
inline PackVec carried(PackVec tangent, PackVec normal, Pack twist) noexcept
{
    Pack const square = dot(tangent, tangent);
    PackVec const turned = tangent + twist * cross(normal, tangent);
    PackVec const flat = turned - dot(turned, normal) * normal;
    Pack const left = dot(flat, flat);
    return either(left > all(0.0), root(square / left) * flat, PackVec{});
}

//! A block of touching pairs between the passes: short loops whose turns do not wait for one another.
constexpr std::size_t sieve_block = 512;  //!< listed pairs at a time: what they leave between passes fits the cache
constexpr std::size_t most_fours = sieve_block / 4 + 1;

struct FourPlaces
{
    PackVec normal;
    Pack overlap, arm_i, arm_j, effective;
};
struct FourMotions
{
    Pack half_closing, closing;  //!< over the step; at the velocities the dashpots see
    PackVec half_slip, slip, half_roll, roll;
    Pack spin;   //!< |wi - wj|^2; LIGGGHTS' constant torque only
    Pack twist;  //!< of the two together about the normal, over the step [rad]
};
struct FourForces
{
    PackVec force, on_i, on_j;
};

constexpr std::size_t of_image_velocity = 4;  //!< where it is in an Image<3> [doubles]
//! What four pairs see of the images of their second grains: the shift, or the velocity at its offset.
inline PackVec of_images(Images<3> const& images, Pairs<3> const& pairs, Four const& slot, std::size_t offset) noexcept
{
    auto const from = [&](std::size_t k) {
        return reinterpret_cast<double const*>(&images[pairs.image[slot[k]]]) + offset;
    };
    return columns(from(0), from(1), from(2), from(3)).vector;
}

template <Features F>
[[gnu::always_inline]] inline FourPlaces places_of(Grains<3> const& g, [[maybe_unused]] Pairs<3> const& pairs,
                                                   [[maybe_unused]] Images<3> const& images,
                                                   FourPairs const& p) noexcept
{
    FourPlaces f;
    Columns pi = columns_of(g.place, p.i), pj = columns_of(g.place, p.j);
    if constexpr (F.periodic) pj.vector = pj.vector + of_images(images, pairs, p.slot, 0);
    Pack const ri = pi.last, rj = pj.last, reach = ri + rj;
    PackVec const apart = pi.vector - pj.vector;
    Pack const distance = root(dot(apart, apart));
    f.overlap = reach - distance;
    f.normal = (all(1.0) / distance) * apart;
    if constexpr (F.scheme == Scheme::predicted) {
        Pack const share = distance / reach;
        f.arm_i = ri * share, f.arm_j = rj * share;
    } else {
        f.arm_i = ri - all(0.5) * f.overlap, f.arm_j = rj - all(0.5) * f.overlap;
    }
    if constexpr (F.rolling != Rolling::none || F.elasticity != Elasticity::linear) f.effective = ri * rj / reach;
    return f;
}

//! Relative velocities and weighted sums of spins of four contacts, at one time.
struct FourRates
{
    PackVec velocity;  //!< vi - vj
    PackVec levers;    //!< li wi + lj wj
    PackVec spin;      //!< wi - wj
};
template <Features F>
[[gnu::always_inline]] inline FourRates rates_of(std::vector<Motion<3>> const& motion,
                                                 [[maybe_unused]] Pairs<3> const& pairs,
                                                 [[maybe_unused]] Images<3> const& images, FourPairs const& p,
                                                 FourPlaces const& at) noexcept
{
    PackVec const wi = columns_of(motion, p.i, of_spin).vector, wj = columns_of(motion, p.j, of_spin).vector;
    PackVec vj = columns_of(motion, p.j).vector;
    if constexpr (F.periodic) vj = vj + of_images(images, pairs, p.slot, of_image_velocity);
    return {columns_of(motion, p.i).vector - vj, at.arm_i * wi + at.arm_j * wj, wi - wj};
}

//! `twice`: wi + wj at the half step.
template <Features F>
[[gnu::always_inline]] inline FourMotions motions_of(FourPlaces const& at, FourRates const& half, FourRates const& late,
                                                     PackVec twice, double dt) noexcept
{
    FourMotions m;
    PackVec const n = at.normal;
    m.half_closing = -dot(half.velocity, n);
    m.half_slip = along(half.velocity, n) - cross(half.levers, n);
    if constexpr (F.rolling != Rolling::none) m.half_roll = m.roll = at.effective * cross(half.spin, n);
    if constexpr (F.scheme == Scheme::liggghts) {
        m.closing = m.half_closing;
        m.slip = m.half_slip;
        if constexpr (F.rolling == Rolling::constant) m.spin = dot(half.spin, half.spin);
    } else {
        m.twist = all(dt) * (all(0.5) * dot(twice, n));
        m.closing = -dot(late.velocity, n);
        m.slip = along(late.velocity, n) - cross(late.levers, n);
        if constexpr (F.rolling != Rolling::none) m.roll = at.effective * cross(late.spin, n);
    }
    return m;
}

template <Features F>
[[gnu::always_inline]] inline FourMotions motions_of(Grains<3> const& g, Pairs<3> const& pairs, Images<3> const& images,
                                                     FourPairs const& p, FourPlaces const& at, double dt) noexcept
{
    FourRates const half = rates_of<F>(g.half, pairs, images, p, at);
    if constexpr (F.scheme == Scheme::liggghts) return motions_of<F>(at, half, half, PackVec{}, dt);
    PackVec const twice = columns_of(g.half, p.i, of_spin).vector + columns_of(g.half, p.j, of_spin).vector;
    return motions_of<F>(at, half, rates_of<F>(g.motion, pairs, images, p, at), twice, dt);
}

template <Features F>
inline PackVec rolling_of(ContactLaw const& law, Four const& slot, FourPlaces const& at, FourMotions const& m,
                          FourStiffness<F.elasticity> const& now, [[maybe_unused]] Pack before, Pack press,
                          Pack sqrt_mass, double dt, History<3>& history,
                          [[maybe_unused]] FourLosses<F.ledger>& lost) noexcept
{
    Pack const friction = all(law.rolling.friction);
    if constexpr (F.rolling == Rolling::constant) {
        bool constexpr theirs = F.scheme == Scheme::liggghts;
        Pack const square = theirs ? m.spin : dot(m.roll, m.roll);
        Pack const rate = theirs ? root(square) * at.effective : root(square);
        PackVec const all_of_it =
            either(square > all(0.0), (friction * (theirs ? now.force : press) / rate) * m.roll, PackVec{});
        if constexpr (F.ledger) lost.rolling = all_of_it;
        return all_of_it;
    } else {
        PackVec const held = carried(gathered(history.rolling, slot), at.normal, m.twist);
        Pack const stiffness = all(law.rolling.stiffness) * now.tangential;
        PackVec const rolled = all(dt) * m.half_roll, stretched = held + stiffness * rolled;
        Pack const viscous = all(law.rolling.damping) * now.root_of_tangential() * sqrt_mass;
        PackLimited const free = limited(stretched, viscous * m.roll, friction * press);
        PackLimited const cut = limited(stretched, PackVec{}, friction * press);
        PackVec const force = either(free.slides, cut.force, free.force),
                      spring = either(free.slides, cut.spring, free.spring);
        if constexpr (F.ledger) {
            lost.rolling = force - spring;
            lost.rolled = spring_loss(held, all(law.rolling.stiffness) * before, spring, stiffness, rolled);
        }
        scatter(spring, history.rolling, slot);
        return force;
    }
}

template <Features F>
inline FourForces forces_of(ContactLaw const& law, Four const& slot, FourPlaces const& at, FourMotions const& m,
                            Pack sqrt_mass, double dt, History<3>& history,
                            [[maybe_unused]] FourLosses<F.ledger>& lost) noexcept
{
    constexpr bool predicted = F.scheme == Scheme::predicted;
    constexpr bool changes = predicted && F.elasticity != Elasticity::linear;  // its stiffness over the step
    auto const now = stiffness_at<F.elasticity>(law, at.overlap, at.effective);
    Pack const floor = all(law.normal.floor);
    Pack normal = now.force + now.normal * sqrt_mass * m.closing;
    normal = either(normal > floor, normal, floor);
    Pack const press = either(normal < all(0.0), -normal, normal);
    PackVec const kept = gathered(history.friction, slot),
                  held = predicted ? carried(kept, at.normal, m.twist) : along(kept, at.normal);
    PackVec unloaded = held;
    Pack before = now.tangential;
    if constexpr (changes) {
        Pack const closed = all(dt) * m.half_closing, past = at.overlap - closed;
        auto const then = stiffness_at<F.elasticity>(law, past, at.effective);
        before = then.tangential;
        unloaded = either(now.tangential < before, (now.tangential / before) * held, held);
        if constexpr (F.ledger) {
            Pack const work = all(0.5) * (then.force + now.force) * closed;
            lost.touch = work - (now.energy(at.overlap) - then.energy(past));
        }
    }
    PackVec const slipped = all(dt) * m.half_slip, spring = unloaded + now.tangential * slipped;
    PackVec const dashpot = now.slip * sqrt_mass * m.slip;
    PackLimited const t = limited(spring, predicted ? dashpot : PackVec{}, all(law.tangential.friction) * press);
    PackVec const friction = predicted ? t.force : either(t.slides, t.force, t.spring + dashpot);
    scatter(t.spring, history.friction, slot);
    PackVec const turn = cross(at.normal, friction);
    FourForces f{normal * at.normal - friction, at.arm_i * turn, at.arm_j * turn};
    if constexpr (F.ledger) {
        PackVec const lossy = t.force - t.spring, lossy_turn = cross(at.normal, lossy);
        lost.normal = (normal - now.force) * at.normal;
        lost.tangential = all(-1.0) * lossy;
        lost.on_i = at.arm_i * lossy_turn, lost.on_j = at.arm_j * lossy_turn;
        lost.slides = t.slides;
        lost.slid = spring_loss(held, before, t.spring, now.tangential, slipped);
    }
    if constexpr (F.rolling != Rolling::none) {
        PackVec const resistance = rolling_of<F>(law, slot, at, m, now, before, press, sqrt_mass, dt, history, lost);
        if constexpr (F.ledger) lost.rolling = (-at.effective) * cross(at.normal, lost.rolling);
        PackVec const rolling = at.effective * cross(at.normal, resistance);
        f.on_i = f.on_i - rolling;
        f.on_j = f.on_j + rolling;
    }
    return f;
}

//! Forces as rows of 32 bytes, one a contact.
struct RowForces
{
    std::array<Pack, 4> force, on_i, on_j;
};
[[gnu::always_inline]] inline RowForces rows(FourForces const& f) noexcept
{
    return {rows(f.force), rows(f.on_i), rows(f.on_j)};
}

//! What one contact adds to a grain.
[[gnu::always_inline]] inline void add(Load<3>& to, Pack force, Pack torque) noexcept
{
    auto* const row = reinterpret_cast<double*>(&to);
    store(row, load(row) + force);
    store(row + of_spin, load(row + of_spin) + torque);
}

//! Forces on i, the opposite ones on j; what is not elastic of them; what springs lost, to the books.
template <Features F>
inline void add(FourForces const& f, FourLosses<F.ledger> const& lost, FourPairs const& p, Sink<3> const& to,
                Books& books) noexcept
{
    Grains<3>& g = to.state.grains;
    LossyLoads<3>& lossy = to.state.lossy;
    RowForces const r = rows(f);
    for (std::size_t k = 0; k < 4; ++k) {
        add(g.contact[p.i[k]], r.force[k], r.on_i[k]);
        if (p.j[k] < to.end) add(g.contact[p.j[k]], -r.force[k], r.on_j[k]);
    }
    [[maybe_unused]] std::array<LossyRow, F.ledger ? 4 : 0> row;
    [[maybe_unused]] bool const tangential = !lossy.tangential.empty();
    if constexpr (F.ledger) {
        row = rows<F>(lost, tangential);
        for (std::size_t k = 0; k < 4; ++k) {
            add<F>(lossy, p.i[k], row[k], all(1.0), row[k].on_i);
            if (p.j[k] < to.end) add<F>(lossy, p.j[k], row[k], all(-1.0), row[k].on_j);
        }
        book<F>(lost, ours(g, p.i), books);
    }
    if constexpr (F.periodic)
        for (std::size_t k = 0; k < 4; ++k) {
            std::uint32_t const image = to.state.pairs.image[p.slot[k]];
            if (image == home<3> || g.is_ghost(p.i[k])) continue;
            to.seams.push_back({image, {r.force[k][0], r.force[k][1], r.force[k][2]}, {}});
            if constexpr (F.ledger) to.seams.back().lossy = lossy_forces(row[k], tangential);
        }
}

//! The listed pairs from `begin` to `end` that touch, appended to `touching` from `waiting` on; the history of those
//! that have opened is forgotten, with the ledger they are appended as well. Returns how many there are then.
template <Features F>
std::size_t sieve(Grains<3> const& g, Pairs<3>& pairs, Images<3> const& images, std::size_t begin, std::size_t end,
                  std::uint32_t* touching, std::size_t waiting) noexcept
{
    auto const sort = [&](std::size_t slot, bool touches) {
        touching[waiting] = static_cast<std::uint32_t>(slot);
        waiting += touches;
        if (pairs.touched[slot] != touches) [[unlikely]] {
            pairs.touched[slot] = touches;
            if (!touches && F.ledger) ++waiting;
            if (!touches && !F.ledger) remember<F>(pairs.history, slot, Memory<3>{});
        }
    };
    std::size_t const packs = begin + (end - begin) / 4 * 4;
    for (std::size_t slot = begin; slot < packs; slot += 4) {
        Four i, j;
        std::memcpy(&i, &pairs.owner[slot], sizeof i);
        std::memcpy(&j, &pairs.other[slot], sizeof j);
        Columns pi = columns_of(g.place, i), pj = columns_of(g.place, j);
        if constexpr (F.periodic) {
            auto const s = static_cast<std::uint32_t>(slot);
            pj.vector = pj.vector + of_images(images, pairs, {s, s + 1, s + 2, s + 3}, 0);
        }
        PackVec const apart = pi.vector - pj.vector;
        Pack const reach = pi.last + pj.last;
        unsigned const near = bits(dot(apart, apart) < reach * reach);
        for (std::size_t k = 0; k < 4; ++k) sort(slot + k, (near >> k & 1u) != 0);
    }
    for (std::size_t slot = packs; slot < end; ++slot) {
        auto const &a = g.place[pairs.owner[slot]], &b = g.place[pairs.other[slot]];
        Vec3 const apart = a.centre - centre_seen<F>(b.centre, pairs, slot, images);
        double const reach = a.radius + b.radius;
        sort(slot, dot(apart, apart) < reach * reach);
    }
    return waiting;
}

//! The touching pairs in `touching` by fours, through the passes: `four(forces, losses, pairs)` is called for those
//! that packs can do, `one(slot)` for the others, in order.
template <Features F, class OnFour, class OnOne>
void pass(ContactLaw const& law, Grains<3> const& g, Pairs<3>& pairs, Images<3> const& images,
          std::uint32_t const* touching, std::size_t count, double dt, OnFour&& four, OnOne&& one) noexcept
{
    std::array<FourPairs, most_fours> fours;
    std::array<FourPlaces, most_fours> places;
    std::array<FourMotions, most_fours> motions;
    for (std::size_t f = 0; f < count; ++f)
        for (std::size_t k = 0; k < 4; ++k) {
            std::uint32_t const slot = touching[4 * f + k];
            fours[f].slot[k] = slot;
            fours[f].i[k] = pairs.owner[slot];
            fours[f].j[k] = pairs.other[slot];
        }
    for (std::size_t f = 0; f < count; ++f) places[f] = places_of<F>(g, pairs, images, fours[f]);
    for (std::size_t f = 0; f < count; ++f) motions[f] = motions_of<F>(g, pairs, images, fours[f], places[f], dt);
    for (std::size_t f = 0; f < count; ++f) {
        Pack const overlap = places[f].overlap;
        Four const& slot = fours[f].slot;
        PackMask special = (places[f].normal.x != places[f].normal.x);  // centres that coincide
        if constexpr (F.scheme == Scheme::predicted) special |= overlap < all(dt) * motions[f].half_closing;
        if constexpr (F.ledger) special |= overlap <= all(0.0);
        if (bits(special) != 0) [[unlikely]] {
            for (std::size_t k = 0; k < 4; ++k) one(slot[k]);
        } else {
            auto const& mass = pairs.sqrt_mass;
            Pack const sqrt_mass{mass[slot[0]], mass[slot[1]], mass[slot[2]], mass[slot[3]]};
            FourLosses<F.ledger> lost;
            FourForces const forces =
                forces_of<F>(law, slot, places[f], motions[f], sqrt_mass, dt, pairs.history, lost);
            four(forces, lost, fours[f]);
        }
    }
}

//! The pairs of grains from `begin` to `end`. `booked(group, books)` is called for each group of grains that is booked
//! together, of which `begin` begins one; with the ledger only.
template <Features F, class OnBooks>
void add_pairs_of(ContactLaw const& law, std::size_t begin, std::size_t end, double dt, Sink<3> const& to,
                  OnBooks&& booked) noexcept
{
    Grains<3>& g = to.state.grains;
    Pairs<3>& pairs = to.state.pairs;
    auto const& images = to.state.cell.images;
    std::array<std::uint32_t, sieve_block + 8> touching;
    Books books;
    [[maybe_unused]] Books theirs;  // of pairs whose first grain is another process's, which books them
    auto const one = [&](std::uint32_t slot) {
        std::uint32_t const i = pairs.owner[slot];
        add_pair<F>(law, to, i, slot, dt, F.ledger && g.is_ghost(i) ? theirs : books);
    };
    auto const four = [&](FourForces const& forces, FourLosses<F.ledger> const& lost, FourPairs const& p) {
        add<F>(forces, lost, p, to, books);
    };
    std::size_t const together = F.ledger ? grains_booked : end - begin;
    for (; begin < end; begin += together) {
        std::size_t waiting = 0;  // at the front of `touching`
        std::size_t const last = pairs.first[std::min(end, begin + together)];
        for (std::size_t slot = pairs.first[begin]; slot < last; slot += sieve_block) {
            waiting = sieve<F>(g, pairs, images, slot, std::min(last, slot + sieve_block), touching.data(), waiting);
            std::size_t const fours = waiting / 4;
            pass<F>(law, g, pairs, images, touching.data(), fours, dt, four, one);
            std::copy(touching.begin() + static_cast<std::ptrdiff_t>(4 * fours),
                      touching.begin() + static_cast<std::ptrdiff_t>(waiting), touching.begin());
            waiting -= 4 * fours;
        }
        for (std::size_t k = 0; k < waiting; ++k) one(touching[k]);
        if constexpr (F.ledger) booked(begin / grains_booked, std::exchange(books, {}));
    }
}

//! All listed pairs.
template <Features F>
void add_packed_pair_forces(Setup<3> const& setup, State<3>& state, double dt) noexcept
{
    Books all;
    add_pairs_of<F>(setup.law, 0, state.grains.size(), dt, {state, state.pushes, state.seams},
                    [&](std::size_t, Books const& books) { all.add(books); });
    if constexpr (F.ledger) all.add_to(state.booked);
}

}  // namespace dem
