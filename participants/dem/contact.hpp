#pragma once

#include <cmath>

#include "participants/dem/state.hpp"

//! One contact (i, j): n from j to i, xi = Ri + Rj - |xi - xj|, arms li = Ri |xi - xj|/(Ri + Rj);
//!     slip      s  = tangential part of vi - vj - (li wi + lj wj) x n
//!     force     on i = Fn n - Ft,  on j the opposite;   torque on i = li n x Ft - R* n x Fr,  on j lj n x Ft + R* n x
//!     Fr
//! The arms meet in one point, so that angular momentum is conserved; a wall is the limit Rj -> infinity, l = R.
//! Dashpots see the velocity predicted at the end of the step, springs the displacement over it.
//!
//! Beginning of a contact: a pair that touched a fraction q = xi / (dt xi_dot) of a step ago has had dashpot and
//! friction for q dt, where the second half kick acts for dt/2. The difference, (q - 1/2) dt times these forces, is an
//! impulse on the half-step velocities; the elongation is that of q dt, and the laws see the velocities slowed for q
//! dt. Without this the rebound depends on where in a step the contact begins, at first order in dt (0.03 alpha v0 at
//! t_c/50).
namespace dem {

template <int D>
struct Contact
{
    Vec<D> normal;
    double arm_i, arm_j;  //!< [m]; a wall: 0
    double effective;     //!< R* = Ri Rj/(Ri + Rj), for a wall Ri [m]

    double closing(Motion<D> const& i, Motion<D> const& j) const noexcept
    {
        return -dot(i.velocity - j.velocity, normal);
    }
    Tangent<D> slip(Motion<D> const& i, Motion<D> const& j) const noexcept
    {
        return along(i.velocity - j.velocity, normal) - turning_about(arm_i * i.spin + arm_j * j.spin, normal);
    }
    Tangent<D> roll(Motion<D> const& i, Motion<D> const& j) const noexcept
    {
        return effective * turning_about(i.spin - j.spin, normal);
    }
};

//! Coincident centres have no direction: x is taken, so that the grains part without a NaN.
template <int D>
inline Contact<D> contact_of(Vec<D> apart, double distance, double radius_i, double radius_j) noexcept
{
    double const inverse = 1.0 / distance, share = distance / (radius_i + radius_j);
    Vec<D> const normal = distance > 0.0 ? inverse * apart : Vec<D>{1.0, 0.0};
    return {normal, radius_i * share, radius_j * share, radius_i * radius_j / (radius_i + radius_j)};
}

template <int D>
inline Contact<D> contact_with_wall(Vec<D> normal, double radius) noexcept
{
    return {normal, radius, 0.0, radius};
}

//! LIGGGHTS measures arms from the middle of the overlap, also on walls (surface_model_default.h).
template <int D>
inline void shorten_arms(Contact<D>& c, double radius_i, double radius_j, double overlap) noexcept
{
    c.arm_i = radius_i - 0.5 * overlap;
    if (c.arm_j > 0.0) c.arm_j = radius_j - 0.5 * overlap;
}

//! The stiffness of one contact at an overlap xi >= 0 [m]; `radius` is R* [m].
template <Elasticity E>
inline Stiffness stiffness_at(ContactLaw const& law, double overlap, double radius) noexcept
{
    if constexpr (E == Elasticity::linear) {
        double const force = law.normal.stiffness * overlap;
        return {force, 0.5 * force * overlap, law.normal.damping, law.tangential.stiffness, law.tangential.damping};
    } else {
        double const patch = std::sqrt(radius * overlap), root = std::sqrt(patch);  // of the area of contact
        double const force = law.normal.stiffness * patch * overlap;
        return {force, 0.4 * force * overlap, law.normal.damping * root, law.tangential.stiffness * patch,
                law.tangential.damping * root};
    }
}

inline Stiffness stiffness_of(Elasticity elasticity, ContactLaw const& law, double overlap, double radius) noexcept
{
    return elasticity == Elasticity::linear ? stiffness_at<Elasticity::linear>(law, overlap, radius)
                                            : stiffness_at<Elasticity::hertz>(law, overlap, radius);
}

//! What two partners and a step are to the laws of one contact.
template <int D>
struct Touching
{
    double overlap;        //!< xi > 0 [m]
    double radius;         //!< R* [m]
    double sqrt_mass;      //!< sqrt(m*) [sqrt(kg)]
    double closing;        //!< predicted at the end of the step [m/s]
    Tangent<D> slip;       //!< [m/s]
    Tangent<D> roll;       //!< [m/s]
    double spin = 0.0;     //!< |wi - wj| [rad/s]; LIGGGHTS' order only
    double step_closing;   //!< over the step [m]
    Tangent<D> step_slip;  //!< [m]
    Tangent<D> step_roll;  //!< [m]
};

template <Features F, int D>
inline Touching<D> touching_of(Contact<D> const& c, double overlap, double sqrt_mass, double dt, Motion<D> const& vi,
                               Motion<D> const& vj, Motion<D> const& hi, Motion<D> const& hj) noexcept
{
    Touching<D> t{overlap, c.effective, sqrt_mass, c.closing(vi, vj), {}, {}, 0.0, dt * c.closing(hi, hj), {}, {}};
    if constexpr (F.friction) {
        t.slip = c.slip(vi, vj);
        t.step_slip = dt * c.slip(hi, hj);
    }
    if constexpr (F.rolling != Rolling::none) {
        t.roll = c.roll(vi, vj);
        t.step_roll = dt * c.roll(hi, hj);
        if constexpr (F.scheme == Scheme::liggghts) t.spin = norm(vi.spin - vj.spin);
    }
    return t;
}

//! The forces of a contact less their elastic parts, for the ledger.
template <int D>
struct Lossy
{
    double normal = 0.0;         //!< [N]
    Tangent<D> tangential = {};  //!< [N]
    Tangent<D> rolling = {};     //!< [N]
    bool slides = false;         //!< the contact is at its friction limit
};

//! What acts in a contact after a step.
template <int D>
struct Forces
{
    double normal = 0.0;         //!< Fn [N]
    Tangent<D> tangential = {};  //!< Ft [N]
    Tangent<D> rolling = {};     //!< Fr [N]
    Lossy<D> lossy;              //!< the parts that are not elastic
    double impulse_n = 0.0;      //!< of a fresh contact, besides the forces [N s]
    Tangent<D> impulse_t = {};   //!< [N s]
    bool fresh = false;          //!< did not touch one step ago
};

//! Books of one evaluation, summed in the order of the contacts [J].
struct Books
{
    double normal_dashpot = 0.0, tangential_dashpot = 0.0, sliding = 0.0, rolling = 0.0, touch = 0.0;
    double wall_work = 0.0;  //!< of moving walls and images through the impulses of fresh contacts

    void add(Books const& more) noexcept
    {
        normal_dashpot += more.normal_dashpot;
        tangential_dashpot += more.tangential_dashpot;
        sliding += more.sliding;
        rolling += more.rolling;
        touch += more.touch;
        wall_work += more.wall_work;
    }
    void add_to(Booked& booked) const noexcept
    {
        booked.normal_dashpot += normal_dashpot;
        booked.tangential_dashpot += tangential_dashpot;
        booked.sliding += sliding;
        booked.rolling += rolling;
        booked.touch += touch;
        booked.wall_work += wall_work;
    }
};

//! Energy of a spring whose force is f: f^2 / 2k [J].
template <class Tangent>
inline double spring_energy(Tangent force, double stiffness) noexcept
{
    return stiffness > 0.0 ? 0.5 * dot(force, force) / stiffness : 0.0;
}

//! Work of a spring over a step, by the trapezium of its force, less what it stores: taken by sliding [J].
template <class Tangent>
inline double spring_loss(Tangent before, double stiffness_before, Tangent after, double stiffness,
                          Tangent displacement) noexcept
{
    return 0.5 * dot(before + after, displacement) -
           (spring_energy(after, stiffness) - spring_energy(before, stiffness_before));
}

//! The history of one contact, as the laws change it.
template <int D>
struct Memory
{
    Tangent<D> friction = {};
    Tangent<D> rolling = {};
};

//! Resistance to rolling, given Fn; `share` is the part of the step for which the contact has been.
template <Features F, int D>
inline void resist_rolling(ContactLaw const& law, Touching<D> const& c, Stiffness const& now, Stiffness const& before,
                           double share, Memory<D>& memory, Forces<D>& f, Books& books) noexcept
{
    double const limit = law.rolling.friction * std::abs(f.normal);
    if constexpr (F.rolling == Rolling::constant) {
        double const square = dot(c.roll, c.roll);
        if (square > 0.0) f.rolling = limit / std::sqrt(square) * c.roll;
        if constexpr (F.ledger) f.lossy.rolling = f.rolling;
    }
    if constexpr (F.rolling == Rolling::elastic_plastic) {
        double const stiffness = law.rolling.stiffness * now.tangential;
        Tangent<D> const stretched = memory.rolling + stiffness * share * c.step_roll;
        Tangent<D> const dashpot = law.rolling.damping * std::sqrt(now.tangential) * c.sqrt_mass * c.roll;
        Limited<Tangent<D>> r = limited(stretched, dashpot, limit);
        if (r.slides) r = limited(stretched, Tangent<D>{}, limit);  // the spring alone: no dashpot beyond the limit
        f.rolling = r.force;
        if constexpr (F.ledger) {
            f.lossy.rolling = r.force - r.spring;
            books.rolling += spring_loss(memory.rolling, law.rolling.stiffness * before.tangential, r.spring, stiffness,
                                         c.step_roll);
        }
        memory.rolling = r.spring;
    }
}

//! A contact that began within the step (see above). `turning` is li^2/Ii + lj^2/Ij [1/kg].
template <Features F, int D>
Forces<D> first_forces(ContactLaw const& law, double dt, Touching<D> const& c, double turning, Memory<D>& memory,
                       Books& books) noexcept
{
    double const touched = c.overlap / c.step_closing, lag = touched * dt, missing = (touched - 0.5) * dt;
    double const per_dt = 1.0 / dt;  // a step there was: the contact closed in it
    double const inverse_n = 1.0 / (c.sqrt_mass * c.sqrt_mass), inverse_t = inverse_n + turning;
    Stiffness const now = stiffness_at<F.elasticity>(law, c.overlap, c.radius);
    Forces<D> f;
    f.fresh = true;
    double const closing = c.closing / (1.0 + lag * now.normal / c.sqrt_mass);
    f.normal = law.normal.limited(now.force + now.normal * c.sqrt_mass * closing);
    f.lossy.normal = f.normal - now.force;
    f.impulse_n = missing * f.lossy.normal;
    if constexpr (F.friction) {
        Stiffness const touch = stiffness_at<F.elasticity>(law, 0.0, c.radius);
        double const first_normal = law.normal.limited(touch.normal * c.sqrt_mass * per_dt * c.step_closing);
        auto const t0 = limited(memory.friction, touch.slip * c.sqrt_mass * per_dt * c.step_slip,
                                law.tangential.friction * std::abs(first_normal));
        Tangent<D> const slipped = touched * c.step_slip;
        Tangent<D> const trial = t0.spring + now.tangential * slipped;  // cut back at the touch, then stretched since
        Tangent<D> const slowed = c.slip - lag * inverse_t * t0.force;
        // friction stops a slip, it does not turn it round
        Tangent<D> const slip = dot(slowed, c.slip) > 0.0 ? slowed : Tangent<D>{};
        auto const t = limited(trial, now.slip * c.sqrt_mass * slip, law.tangential.friction * std::abs(f.normal));
        f.tangential = t.force;
        f.impulse_t = missing * t.force;
        f.lossy.tangential = t.force - t.spring;
        f.lossy.slides = t.slides;
        if constexpr (F.ledger)
            books.sliding += spring_loss(memory.friction, now.tangential, t.spring, now.tangential, c.step_slip);
        memory.friction = t.spring;
    }
    if constexpr (F.rolling != Rolling::none) resist_rolling<F>(law, c, now, now, touched, memory, f, books);
    if constexpr (F.ledger) {
        books.touch += 0.5 * now.force * c.step_closing - now.energy;
        books.normal_dashpot += f.impulse_n * (per_dt * c.step_closing - 0.5 * f.impulse_n * inverse_n);
        (f.lossy.slides ? books.sliding : books.tangential_dashpot) +=
            dot(f.impulse_t, per_dt * c.step_slip - 0.5 * inverse_t * f.impulse_t);
    }
    return f;
}

//! LIGGGHTS' order: everything at the half step, the dashpot outside the Coulomb test, nothing for a contact's
//! beginning.
template <Features F, int D>
inline Forces<D> forces_as_liggghts(ContactLaw const& law, Touching<D> const& c, Memory<D>& memory) noexcept
{
    Stiffness const now = stiffness_at<F.elasticity>(law, c.overlap, c.radius);
    Forces<D> f;
    f.normal = law.normal.limited(now.force + now.normal * c.sqrt_mass * c.closing);
    if constexpr (F.friction) {
        auto const t = limited(memory.friction + now.tangential * c.step_slip, Tangent<D>{},
                               law.tangential.friction * std::abs(f.normal));
        f.tangential = t.slides ? t.force : t.spring + now.slip * c.sqrt_mass * c.slip;
        memory.friction = t.spring;
    }
    // cdt: the elastic normal force alone, and the share of the relative spin that is not torsion
    if constexpr (F.rolling == Rolling::constant)
        if (c.spin > 0.0) f.rolling = law.rolling.friction * now.force / (c.spin * c.radius) * c.roll;
    return f;
}

//! The laws on one touching contact, and what the ledger books of it. Changes the memory, which has been carried to
//! the contact's present place. `turning()` is called only for a contact that began within the step.
template <Features F, int D, class Turning>
inline Forces<D> contact_forces(ContactLaw const& law, double dt, Touching<D> const& c, Turning&& turning,
                                Memory<D>& memory, Books& books) noexcept
{
    if constexpr (F.scheme == Scheme::liggghts) return forces_as_liggghts<F>(law, c, memory);
    if (c.overlap < c.step_closing) [[unlikely]]
        return first_forces<F>(law, dt, c, turning(), memory, books);
    Stiffness const now = stiffness_at<F.elasticity>(law, c.overlap, c.radius);
    Stiffness before = now;
    if constexpr (F.elasticity != Elasticity::linear && (F.friction || F.ledger))
        before = stiffness_at<F.elasticity>(law, c.overlap - c.step_closing, c.radius);
    Forces<D> f;
    f.normal = law.normal.limited(now.force + now.normal * c.sqrt_mass * c.closing);
    if constexpr (F.ledger) {
        f.lossy.normal = f.normal - now.force;
        if constexpr (F.elasticity != Elasticity::linear)  // for a straight line the trapezium is exact
            books.touch += 0.5 * (before.force + now.force) * c.step_closing - (now.energy - before.energy);
    }
    if constexpr (F.friction) {
        Tangent<D> spring = memory.friction;
        if constexpr (F.elasticity != Elasticity::linear)
            if (now.tangential < before.tangential) spring = now.tangential / before.tangential * spring;
        auto const t = limited(spring + now.tangential * c.step_slip, now.slip * c.sqrt_mass * c.slip,
                               law.tangential.friction * std::abs(f.normal));
        f.tangential = t.force;
        if constexpr (F.ledger) {
            books.sliding += spring_loss(memory.friction, before.tangential, t.spring, now.tangential, c.step_slip);
            f.lossy.tangential = t.force - t.spring;
            f.lossy.slides = t.slides;
        }
        memory.friction = t.spring;
    }
    if constexpr (F.rolling != Rolling::none) resist_rolling<F>(law, c, now, before, 1.0, memory, f, books);
    return f;
}

//! A contact of the list that does not touch, and what the ledger books if it did one step ago: the springs' energy.
template <Features F, int D>
inline void book_opening(ContactLaw const& law, Contact<D> const& c, double overlap, double step_closing,
                         Tangent<D> slipped, Tangent<D> rolled, Memory<D> const& memory, Books& books) noexcept
{
    double const before = overlap - step_closing;
    if (before <= 0.0) return;
    Stiffness const held = stiffness_at<F.elasticity>(law, before, c.effective);
    books.touch += 0.5 * held.force * step_closing + held.energy;
    books.sliding += spring_loss(memory.friction, held.tangential, Tangent<D>{}, held.tangential, slipped);
    if constexpr (F.rolling == Rolling::elastic_plastic) {
        double const stiffness = law.rolling.stiffness * held.tangential;
        books.rolling += spring_loss(memory.rolling, stiffness, Tangent<D>{}, stiffness, rolled);
    }
}

}  // namespace dem
