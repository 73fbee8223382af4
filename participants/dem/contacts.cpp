#include "participants/dem/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dem {
namespace {

//! A grain's motion as the contact sees it.
struct Motion
{
    Vec2 velocity;  //!< [m/s]
    double spin;    //!< [rad/s]
};

Motion predicted(Grains const& g, std::size_t i) noexcept
{
    return {{g.vx[i], g.vy[i]}, g.spin[i]};
}
Motion half_step(Grains const& g, std::size_t i) noexcept
{
    return {{g.half_vx[i], g.half_vy[i]}, g.half_spin[i]};
}

//! One contact: where, and how fast it closes and slips. A wall is a partner at rest with arm 0.
struct Contact
{
    Vec2 normal;
    double arm_i, arm_j;  //!< [m]

    double closing(Motion const& i, Motion const& j) const noexcept { return -dot(i.velocity - j.velocity, normal); }
    double slip(Motion const& i, Motion const& j) const noexcept
    {
        return dot(i.velocity - j.velocity, tangent_of(normal)) - (arm_i * i.spin + arm_j * j.spin);
    }
};

//! Coincident centres have no direction: x is taken, so that the grains part without a NaN.
Contact contact_of(Vec2 apart, double distance, double radius_i, double radius_j) noexcept
{
    double const inverse = 1.0 / distance, share = distance / (radius_i + radius_j);
    Vec2 const normal = distance > 0.0 ? inverse * apart : Vec2{1.0, 0.0};
    return {normal, radius_i * share, radius_j * share};
}

struct Forces
{
    double normal, tangential;    //!< Fn, Ft [N]
    double dashpot_n, dashpot_t;  //!< the part of them that is not elastic [N]
};

//! Books of one evaluation, summed in the order of the contacts.
struct Books
{
    double sliding = 0.0, touch = 0.0;
};

//! The two laws on one touching contact, and what the ledger books of it. Changes the spring.
template <Features F>
inline Forces contact_forces(NormalForce const& normal_law, TangentialForce const& tangential_law, double dt,
                             Contact const& contact, Motion const& vi, Motion const& vj, Motion const& hi,
                             Motion const& hj, double overlap, double sqrt_mass, double& spring, Books& books) noexcept
{
    double const step_closing = dt * contact.closing(hi, hj);  // change of the overlap over this step [m]
    double acting = 1.0, touched = 1.0;                        // of a step: dashpots, elongation
    if (overlap < step_closing) [[unlikely]] {                 // did not touch one step ago
        touched = overlap / step_closing;
        acting = 0.5 + touched;
        if constexpr (F.ledger) books.touch += 0.5 * normal_law.stiffness * overlap * (step_closing - overlap);
    }
    Forces f{};
    f.normal = normal_law(overlap, acting * contact.closing(vi, vj), sqrt_mass);
    f.dashpot_n = f.normal - normal_law.stiffness * overlap;
    if constexpr (F.friction) {
        double const trial = spring + touched * dt * contact.slip(hi, hj);
        auto const t = tangential_law(trial, acting * contact.slip(vi, vj), f.normal, sqrt_mass);
        f.tangential = t.force;
        f.dashpot_t = t.force - tangential_law.stiffness * t.spring;
        if constexpr (F.ledger)
            books.sliding += 0.5 * tangential_law.stiffness * (spring + t.spring) * (trial - t.spring);
        spring = t.spring;
    }
    return f;
}

//! A contact of the list that does not touch: the springs' energy is gone.
inline void book_opening(NormalForce const& normal_law, TangentialForce const& tangential_law, double overlap,
                         double step_closing, double spring, Books& books) noexcept
{
    double const before = overlap - step_closing;
    if (before > 0.0) books.touch += 0.5 * normal_law.stiffness * before * overlap;
    books.sliding += 0.5 * tangential_law.stiffness * spring * spring;
}

template <Features F>
void add_pair_forces(Setup const& setup, State& state, double dt) noexcept
{
    Grains& g = state.grains;
    Pairs& pairs = state.pairs;
    NormalForce const normal_law = setup.normal_force;
    TangentialForce const tangential_law = setup.tangential_force;
    Books books;
    for (std::size_t i = 0; i < g.size(); ++i) {
        Vec2 const xi{g.x[i], g.y[i]};
        Motion const vi = predicted(g, i), hi = half_step(g, i);
        double const ri = g.radius[i];
        double fx = 0.0, fy = 0.0, torque = 0.0;
        std::uint32_t const end = pairs.first[i + 1];
        for (std::uint32_t slot = pairs.first[i]; slot < end; ++slot) {
            std::size_t const j = pairs.other[slot];
            Vec2 const apart = xi - Vec2{g.x[j], g.y[j]};
            double const reach = ri + g.radius[j], square = dot(apart, apart);
            if (square >= reach * reach) {
                if constexpr (F.ledger) {
                    Contact const c = contact_of(apart, std::sqrt(square), ri, g.radius[j]);
                    double const step_closing = dt * c.closing(hi, half_step(g, j));
                    book_opening(normal_law, tangential_law, reach - std::sqrt(square), step_closing,
                                 pairs.spring[slot], books);
                    pairs.dashpot_n[slot] = pairs.dashpot_t[slot] = 0.0;
                }
                if constexpr (F.friction) pairs.spring[slot] = 0.0;
                continue;
            }
            double const distance = std::sqrt(square);
            Contact const c = contact_of(apart, distance, ri, g.radius[j]);
            Forces const f =
                contact_forces<F>(normal_law, tangential_law, dt, c, vi, predicted(g, j), hi, half_step(g, j),
                                  reach - distance, pairs.sqrt_mass[slot], pairs.spring[slot], books);
            Vec2 const force = f.normal * c.normal - f.tangential * tangent_of(c.normal);
            fx += force.x;
            fy += force.y;
            g.fx[j] -= force.x;
            g.fy[j] -= force.y;
            if constexpr (F.friction) {
                torque += c.arm_i * f.tangential;
                g.torque[j] += c.arm_j * f.tangential;
            }
            if constexpr (F.ledger) {
                pairs.dashpot_n[slot] = f.dashpot_n;
                pairs.dashpot_t[slot] = f.dashpot_t;
            }
        }
        g.fx[i] += fx;
        g.fy[i] += fy;
        g.torque[i] += torque;
    }
    if constexpr (F.ledger) {
        state.booked.sliding += books.sliding;
        state.booked.touch += books.touch;
    }
}

template <Features F>
void add_wall_forces(Setup const& setup, State& state, std::size_t w, double dt) noexcept
{
    Grains& g = state.grains;
    Wall const& wall = setup.walls[w];
    WallContacts& contacts = state.wall_contacts[w];
    Motion const rest{};
    Books books;
    for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
        std::size_t const i = contacts.grain[k];
        Contact const c{wall.normal, g.radius[i], 0.0};
        double const overlap = g.radius[i] - dot(Vec2{g.x[i], g.y[i]} - wall.point, wall.normal);
        if (overlap <= 0.0) {
            if constexpr (F.ledger) {
                book_opening(wall.normal_force, wall.tangential_force, overlap, dt * c.closing(half_step(g, i), rest),
                             contacts.spring[k], books);
                contacts.dashpot_n[k] = contacts.dashpot_t[k] = 0.0;
            }
            contacts.spring[k] = 0.0;
            continue;
        }
        Forces const f =
            contact_forces<F>(wall.normal_force, wall.tangential_force, dt, c, predicted(g, i), rest, half_step(g, i),
                              rest, overlap, std::sqrt(g.mass[i]), contacts.spring[k], books);
        Vec2 const force = f.normal * c.normal - f.tangential * tangent_of(c.normal);
        g.fx[i] += force.x;
        g.fy[i] += force.y;
        g.torque[i] += c.arm_i * f.tangential;
        if constexpr (F.ledger) {
            contacts.dashpot_n[k] = f.dashpot_n;
            contacts.dashpot_t[k] = f.dashpot_t;
        }
    }
    if constexpr (F.ledger) {
        state.booked.sliding += books.sliding;
        state.booked.touch += books.touch;
    }
}

}  // namespace

template <Features F>
void evaluate_contacts(Setup const& setup, State& state, double dt) noexcept
{
    std::fill(state.grains.fx.begin(), state.grains.fx.end(), 0.0);
    std::fill(state.grains.fy.begin(), state.grains.fy.end(), 0.0);
    std::fill(state.grains.torque.begin(), state.grains.torque.end(), 0.0);
    add_pair_forces<F>(setup, state, dt);
    for (std::size_t w = 0; w < setup.walls.size(); ++w) add_wall_forces<F>(setup, state, w, dt);
}

template void evaluate_contacts<Features{}>(Setup const&, State&, double) noexcept;
template void evaluate_contacts<Features{.friction = true}>(Setup const&, State&, double) noexcept;
template void evaluate_contacts<Features{.ledger = true}>(Setup const&, State&, double) noexcept;
template void evaluate_contacts<Features{.friction = true, .ledger = true}>(Setup const&, State&, double) noexcept;

void evaluate_dashpot_power(Setup const& setup, State& state) noexcept
{
    Grains const& g = state.grains;
    Pairs const& pairs = state.pairs;
    state.power_n = state.power_t = 0.0;
    auto add = [&](Contact const& c, Motion const& i, Motion const& j, double dashpot_n, double dashpot_t) {
        state.power_n += dashpot_n * c.closing(i, j);
        state.power_t += dashpot_t * c.slip(i, j);
    };
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            std::size_t const j = pairs.other[slot];
            Vec2 const apart = Vec2{g.x[i], g.y[i]} - Vec2{g.x[j], g.y[j]};
            Contact const c = contact_of(apart, std::sqrt(dot(apart, apart)), g.radius[i], g.radius[j]);
            add(c, predicted(g, i), predicted(g, j), pairs.dashpot_n[slot], pairs.dashpot_t[slot]);
        }
    for (std::size_t w = 0; w < setup.walls.size(); ++w) {
        WallContacts const& contacts = state.wall_contacts[w];
        for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
            std::size_t const i = contacts.grain[k];
            Contact const c{setup.walls[w].normal, g.radius[i], 0.0};
            add(c, predicted(g, i), Motion{}, contacts.dashpot_n[k], contacts.dashpot_t[k]);
        }
    }
}

Elastic elastic_energy_of_pairs(Setup const& setup, State const& state) noexcept
{
    Grains const& g = state.grains;
    Pairs const& pairs = state.pairs;
    Elastic sum;
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = pairs.first[i]; slot < pairs.first[i + 1]; ++slot) {
            std::size_t const j = pairs.other[slot];
            double const overlap = g.radius[i] + g.radius[j] - std::hypot(g.x[i] - g.x[j], g.y[i] - g.y[j]);
            if (overlap <= 0.0) continue;
            sum.normal += 0.5 * setup.normal_force.stiffness * overlap * overlap;
            sum.tangential += 0.5 * setup.tangential_force.stiffness * pairs.spring[slot] * pairs.spring[slot];
        }
    return sum;
}

Elastic elastic_energy_of_wall(Setup const& setup, State const& state, std::size_t w) noexcept
{
    Grains const& g = state.grains;
    Wall const& wall = setup.walls[w];
    WallContacts const& contacts = state.wall_contacts[w];
    Elastic sum;
    for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
        std::size_t const i = contacts.grain[k];
        double const overlap = g.radius[i] - dot(Vec2{g.x[i], g.y[i]} - wall.point, wall.normal);
        if (overlap <= 0.0) continue;
        sum.normal += 0.5 * wall.normal_force.stiffness * overlap * overlap;
        sum.tangential += 0.5 * wall.tangential_force.stiffness * contacts.spring[k] * contacts.spring[k];
    }
    return sum;
}

}  // namespace dem
