#pragma once

#include "participants/dem/contact.hpp"

//! What is not elastic of the contacts, as loads on the grains: what the ledger books as lost is the power of these
//! loads at the end of a step, when velocities are known, and needs no second look at the contacts.
namespace dem {

//! No loads yet on so many grains.
template <Features F, int D>
void clear(LossyLoads<D>& loads, Setup<D> const& setup, std::size_t grains)
{
    bool damped = setup.law.tangential.damping > 0.0;
    for (Wall<D> const& wall : setup.walls) damped = damped || wall.law.tangential.damping > 0.0;
    loads.press_and_roll.assign(grains, {});
    loads.tangential.assign(F.friction && damped ? grains : 0, {});
    loads.sliding.assign(loads.tangential.size(), {});
    loads.wall.assign(setup.walls.size(), {});
    loads.image.fill({});
}

//! The parts of one contact's load that are not elastic.
template <int D>
struct LossyLoad
{
    Vec<D> normal, tangential;     //!< on i [N]
    Spin<D> on_i = {}, on_j = {};  //!< of the tangential part [N m]
    Spin<D> rolling = {};          //!< on i, the opposite on j [N m]
    bool slides = false;
};

template <Features F, int D>
LossyLoad<D> lossy_load(Contact<D> const& c, Lossy<D> const& lossy) noexcept
{
    LossyLoad<D> load{lossy.normal * c.normal, {}};
    if constexpr (F.friction) {
        Spin<D> const torque = torque_of(lossy.tangential, c.normal);
        load.tangential = -1.0 * vector_of(lossy.tangential, c.normal);
        load.on_i = c.arm_i * torque;
        load.on_j = c.arm_j * torque;
        load.slides = lossy.slides;
    }
    if constexpr (F.rolling != Rolling::none) load.rolling = -c.effective * torque_of(lossy.rolling, c.normal);
    return load;
}

//! Adds them to one of the two grains; `sign` is +1 for i, -1 for j, `torque` that of the tangential part on it.
template <Features F, int D>
void add(LossyLoads<D>& loads, std::size_t grain, LossyLoad<D> const& load, double sign, Spin<D> torque) noexcept
{
    Load<D>& at = loads.press_and_roll[grain];
    at.force += sign * load.normal;
    if constexpr (F.rolling != Rolling::none) at.torque = at.torque + sign * load.rolling;
    if (F.friction && !loads.tangential.empty()) {
        Load<D>& to = (load.slides ? loads.sliding : loads.tangential)[grain];
        to.force += sign * load.tangential;
        to.torque = to.torque + torque;
    }
}

//! Their forces, for the sums of a wall or an image.
template <int D>
LossyForces<D> lossy_forces(LossyLoad<D> const& load) noexcept
{
    LossyForces<D> forces{load.normal, {}, {}};
    (load.slides ? forces.sliding : forces.tangential) = load.tangential;
    return forces;
}
template <int D>
void add(LossyForces<D>& sum, LossyForces<D> const& more) noexcept
{
    sum.normal += more.normal;
    sum.tangential += more.tangential;
    sum.sliding += more.sliding;
}

}  // namespace dem
