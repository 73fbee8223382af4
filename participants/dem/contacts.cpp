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
    double lossy_n, lossy_t;      //!< the part of them that is not elastic [N]
    double impulse_n, impulse_t;  //!< of a fresh contact, besides the forces [N s]
    bool slides;
    bool fresh;  //!< did not touch one step ago
};

//! Books of one evaluation, summed in the order of the contacts [J].
struct Books
{
    double normal_dashpot = 0.0, tangential_dashpot = 0.0, sliding = 0.0, touch = 0.0;

    void add_to(Booked& booked) const noexcept
    {
        booked.normal_dashpot += normal_dashpot;
        booked.tangential_dashpot += tangential_dashpot;
        booked.sliding += sliding;
        booked.touch += touch;
    }
};

//! Work of the spring's force over a step, by the trapezium, less what it stores: taken by sliding [J].
inline double spring_loss(double stiffness, double before, double after, double displacement) noexcept
{
    return 0.5 * stiffness * (before + after) * (displacement - (after - before));
}

//! What two partners and a step are to the laws of one contact.
struct Touching
{
    double overlap;                  //!< xi > 0 [m]
    double sqrt_mass;                //!< sqrt(m*) [sqrt(kg)]
    double closing, slip;            //!< predicted at the end of the step [m/s]
    double step_closing, step_slip;  //!< over the step [m]
};

inline Touching touching_of(Contact const& c, double overlap, double sqrt_mass, double dt, Motion const& vi,
                            Motion const& vj, Motion const& hi, Motion const& hj) noexcept
{
    return {overlap, sqrt_mass, c.closing(vi, vj), c.slip(vi, vj), dt * c.closing(hi, hj), dt * c.slip(hi, hj)};
}

//! A contact that began within the step, `touched` of a step ago (see contacts.hpp). `turning` is li^2/Ii + lj^2/Ij
//! [1/kg].
template <Features F>
Forces first_forces(NormalForce const& normal_law, TangentialForce const& tangential_law, double dt, Touching const& c,
                    double turning, double& spring, Books& books) noexcept
{
    double const touched = c.overlap / c.step_closing, lag = touched * dt, missing = (touched - 0.5) * dt;
    double const inverse_n = 1.0 / (c.sqrt_mass * c.sqrt_mass), inverse_t = inverse_n + turning;
    Forces f{};
    f.fresh = true;
    double const closing = c.closing / (1.0 + lag * normal_law.damping / c.sqrt_mass);
    f.normal = normal_law(c.overlap, closing, c.sqrt_mass);
    f.lossy_n = f.normal - normal_law.stiffness * c.overlap;
    f.impulse_n = missing * f.lossy_n;
    if constexpr (F.friction) {
        double const first_slip = c.step_slip / dt;
        auto const t0 =
            tangential_law(spring, first_slip, normal_law(0.0, c.step_closing / dt, c.sqrt_mass), c.sqrt_mass);
        double const trial = t0.spring + touched * c.step_slip;  // cut back at the touch, then stretched since
        double const slowed = c.slip - lag * inverse_t * t0.force;
        double const slip = slowed * c.slip > 0.0 ? slowed : 0.0;  // friction stops a slip, it does not turn it round
        auto const t = tangential_law(trial, slip, f.normal, c.sqrt_mass);
        f.tangential = t.force;
        f.impulse_t = missing * t.force;
        f.lossy_t = t.force - tangential_law.stiffness * t.spring;
        f.slides = t.slides;
        if constexpr (F.ledger) books.sliding += spring_loss(tangential_law.stiffness, spring, t.spring, c.step_slip);
        spring = t.spring;
    }
    if constexpr (F.ledger) {
        books.touch += 0.5 * normal_law.stiffness * c.overlap * (c.step_closing - c.overlap);
        books.normal_dashpot += f.impulse_n * (c.step_closing / dt - 0.5 * f.impulse_n * inverse_n);
        (f.slides ? books.sliding : books.tangential_dashpot) +=
            f.impulse_t * (c.step_slip / dt - 0.5 * f.impulse_t * inverse_t);
    }
    return f;
}

//! The two laws on one touching contact, and what the ledger books of it. Changes the spring. `turning()` is called
//! only for a contact that began within the step.
template <Features F, class Turning>
inline Forces contact_forces(NormalForce const& normal_law, TangentialForce const& tangential_law, double dt,
                             Touching const& c, Turning&& turning, double& spring, Books& books) noexcept
{
    if (c.overlap < c.step_closing) [[unlikely]]
        return first_forces<F>(normal_law, tangential_law, dt, c, turning(), spring, books);
    Forces f{};
    f.normal = normal_law(c.overlap, c.closing, c.sqrt_mass);
    if constexpr (F.ledger) f.lossy_n = f.normal - normal_law.stiffness * c.overlap;
    if constexpr (F.friction) {
        auto const t = tangential_law(spring + c.step_slip, c.slip, f.normal, c.sqrt_mass);
        f.tangential = t.force;
        if constexpr (F.ledger) {
            books.sliding += spring_loss(tangential_law.stiffness, spring, t.spring, c.step_slip);
            f.lossy_t = f.tangential - tangential_law.stiffness * t.spring;
            f.slides = t.slides;
        }
        spring = t.spring;
    }
    return f;
}

//! Gives a grain its share of a fresh contact's impulse; `sign` is +1 for i, -1 for j.
void push(Grains& g, std::size_t i, double sign, double arm, Contact const& c, Forces const& f) noexcept
{
    Vec2 const impulse = (sign / g.mass[i]) * (f.impulse_n * c.normal - f.impulse_t * tangent_of(c.normal));
    g.half_vx[i] += impulse.x;
    g.half_vy[i] += impulse.y;
    g.half_spin[i] += arm * f.impulse_t / g.inertia[i];
}

//! A contact of the list that does not touch, and what the ledger books if it did one step ago: the springs' energy.
inline void book_opening(NormalForce const& normal_law, TangentialForce const& tangential_law, double overlap,
                         double step_closing, double displacement, double spring, Books& books) noexcept
{
    double const before = overlap - step_closing;
    if (before > 0.0) books.touch += 0.5 * normal_law.stiffness * before * overlap;
    books.sliding += spring_loss(tangential_law.stiffness, spring, 0.0, displacement);
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
                    Motion const hj = half_step(g, j);
                    book_opening(normal_law, tangential_law, reach - std::sqrt(square), dt * c.closing(hi, hj),
                                 dt * c.slip(hi, hj), pairs.spring[slot], books);
                    pairs.lossy_n[slot] = pairs.lossy_t[slot] = 0.0;
                }
                if constexpr (F.friction) pairs.spring[slot] = 0.0;
                continue;
            }
            double const distance = std::sqrt(square);
            Contact const c = contact_of(apart, distance, ri, g.radius[j]);
            Touching const touching =
                touching_of(c, reach - distance, pairs.sqrt_mass[slot], dt, vi, predicted(g, j), hi, half_step(g, j));
            auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i] + c.arm_j * c.arm_j / g.inertia[j]; };
            Forces const f =
                contact_forces<F>(normal_law, tangential_law, dt, touching, turning, pairs.spring[slot], books);
            if (f.fresh) [[unlikely]] {
                push(g, i, 1.0, c.arm_i, c, f);
                push(g, j, -1.0, c.arm_j, c, f);
            }
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
                pairs.lossy_n[slot] = f.lossy_n;
                pairs.lossy_t[slot] = f.lossy_t;
                pairs.slides[slot] = f.slides;
            }
        }
        g.fx[i] += fx;
        g.fy[i] += fy;
        g.torque[i] += torque;
    }
    if constexpr (F.ledger) books.add_to(state.booked);
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
                Motion const hi = half_step(g, i);
                book_opening(wall.normal_force, wall.tangential_force, overlap, dt * c.closing(hi, rest),
                             dt * c.slip(hi, rest), contacts.spring[k], books);
                contacts.lossy_n[k] = contacts.lossy_t[k] = 0.0;
            }
            contacts.spring[k] = 0.0;
            continue;
        }
        Touching const touching =
            touching_of(c, overlap, std::sqrt(g.mass[i]), dt, predicted(g, i), rest, half_step(g, i), rest);
        auto const turning = [&] { return c.arm_i * c.arm_i / g.inertia[i]; };
        Forces const f = contact_forces<F>(wall.normal_force, wall.tangential_force, dt, touching, turning,
                                           contacts.spring[k], books);
        if (f.fresh) [[unlikely]]
            push(g, i, 1.0, c.arm_i, c, f);
        Vec2 const force = f.normal * c.normal - f.tangential * tangent_of(c.normal);
        g.fx[i] += force.x;
        g.fy[i] += force.y;
        g.torque[i] += c.arm_i * f.tangential;
        if constexpr (F.ledger) {
            contacts.lossy_n[k] = f.lossy_n;
            contacts.lossy_t[k] = f.lossy_t;
            contacts.slides[k] = f.slides;
        }
    }
    if constexpr (F.ledger) books.add_to(state.booked);
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

void evaluate_lossy_power(Setup const& setup, State& state) noexcept
{
    Grains const& g = state.grains;
    State::Power power;
    auto add = [&](Contact const& c, Motion const& i, Motion const& j, auto const& list, std::size_t at) {
        power.normal += list.lossy_n[at] * c.closing(i, j);
        (list.slides[at] ? power.sliding : power.tangential) += list.lossy_t[at] * c.slip(i, j);
    };
    for (std::size_t i = 0; i < g.size(); ++i)
        for (std::uint32_t slot = state.pairs.first[i]; slot < state.pairs.first[i + 1]; ++slot) {
            std::size_t const j = state.pairs.other[slot];
            Vec2 const apart = Vec2{g.x[i], g.y[i]} - Vec2{g.x[j], g.y[j]};
            Contact const c = contact_of(apart, std::sqrt(dot(apart, apart)), g.radius[i], g.radius[j]);
            add(c, predicted(g, i), predicted(g, j), state.pairs, slot);
        }
    for (std::size_t w = 0; w < setup.walls.size(); ++w) {
        WallContacts const& contacts = state.wall_contacts[w];
        for (std::size_t k = 0; k < contacts.grain.size(); ++k) {
            std::size_t const i = contacts.grain[k];
            add(Contact{setup.walls[w].normal, g.radius[i], 0.0}, predicted(g, i), Motion{}, contacts, k);
        }
    }
    state.power = power;
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
