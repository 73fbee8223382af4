#pragma once

#include "participants/dem/packed_contacts.hpp"

//! Spheres at a plane wall four at a time, to the last bit as one at a time.
namespace dem {

//! Where the contacts with a wall are summed up.
struct WallSums
{
    Vec3& force;
    Books& books;
    LossyForces<3>& lossy;
};

//! The contacts with a plane wall from the first on, four at a time; returns how many were done. Velocities: the wall's
//! over the step and at its end.
template <Features F>
std::size_t add_packed_wall_forces(Plane<3> const& plane, Setup<3> const& setup, State<3>& state, std::size_t wall,
                                   Vec3 half_velocity, Vec3 late_velocity, double dt, WallSums const& sums) noexcept
{
    ContactLaw const law = setup.walls[wall].law;
    Grains<3>& g = state.grains;
    WallContacts<3>& contacts = state.walls[wall];
    auto const spread = [](Vec3 v) { return PackVec{all(v.x), all(v.y), all(v.z)}; };
    PackVec const n = spread(plane.normal), point = spread(plane.point), shift = spread(contacts.shift);
    std::size_t const end = contacts.grain.size() / 4 * 4;
    for (std::size_t begin = 0; begin < end; begin += 4) {
        Four i, slot;
        std::memcpy(&i, &contacts.grain[begin], sizeof i);
        for (std::size_t k = 0; k < 4; ++k) slot[k] = static_cast<std::uint32_t>(begin + k);
        Columns const place = columns_of(g.place, i);
        FourPlaces at;
        Pack const radius = place.last;
        at.normal = n;
        at.overlap = radius - dot((place.vector - shift) - point, n);
        unsigned const touches = bits(at.overlap > all(0.0));
        auto const forget_all = [&] {
            for (std::size_t k = 0; k < 4; ++k) remember<F>(contacts.history, slot[k], Memory<3>{});
        };
        if (touches == 0 && !F.ledger) {
            forget_all();
            continue;
        }
        at.arm_i = F.scheme == Scheme::liggghts ? radius - all(0.5) * at.overlap : radius;
        at.effective = radius;
        auto const rates = [&](std::vector<Motion<3>> const& motion, Vec3 of_wall) {
            PackVec const spin = columns_of(motion, i, of_spin).vector;
            return FourRates{columns_of(motion, i).vector - spread(of_wall), at.arm_i * spin, spin};
        };
        FourRates const half = rates(g.half, half_velocity);
        FourRates const late = F.scheme == Scheme::liggghts ? half : rates(g.motion, late_velocity);
        FourMotions const m = motions_of<F>(at, half, late, half.spin, dt);
        if constexpr (F.scheme == Scheme::predicted)
            if ((bits(at.overlap < all(dt) * m.half_closing) & touches) != 0) [[unlikely]]
                return begin;
        if constexpr (F.ledger)
            if ((bits(at.overlap - all(dt) * m.half_closing > all(0.0)) & ~touches) != 0) [[unlikely]]
                return begin;  // some have opened
        if (touches == 0) {
            forget_all();
            continue;
        }
        Pack const sqrt_mass =
            setup.absolute_damping ? all(1.0) : root(Pack{g.mass[i[0]], g.mass[i[1]], g.mass[i[2]], g.mass[i[3]]});
        FourLosses<F.ledger> lost;
        FourForces const f = forces_of<F>(law, slot, at, m, sqrt_mass, dt, contacts.history, lost);
        auto const force = rows(f.force), on_i = rows(f.on_i);
        for (std::size_t k = 0; k < 4; ++k) {
            if (!(touches >> k & 1u)) {
                remember<F>(contacts.history, slot[k], Memory<3>{});
                continue;
            }
            add(g.contact[i[k]], force[k], on_i[k]);
            sums.force += Vec3{force[k][0], force[k][1], force[k][2]};
        }
        if constexpr (F.ledger) {
            bool const tangential = !state.lossy.tangential.empty();
            auto const row = rows<F>(lost, tangential);
            for (std::size_t k = 0; k < 4; ++k) {
                if (!(touches >> k & 1u)) continue;
                add<F>(state.lossy, i[k], row[k], all(1.0), row[k].on_i);
                add(sums.lossy, lossy_forces(row[k], tangential));
            }
            book<F>(lost, touches, sums.books);
        }
    }
    return end;
}

}  // namespace dem
