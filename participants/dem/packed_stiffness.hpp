#pragma once

#include <cmath>

#include "participants/dem/laws.hpp"
#include "participants/dem/pack.hpp"

//! How stiff four contacts are at their present overlaps: Stiffness in normal_force.hpp.
namespace dem {

template <Elasticity E>
struct FourStiffness
{
    Pack force, normal, tangential, slip;

    //! Stored at the overlap that it was asked for at [J].
    Pack energy(Pack overlap) const noexcept { return all(E == Elasticity::linear ? 0.5 : 0.4) * force * overlap; }
    //! Of the tangential stiffness [sqrt(N/m)].
    Pack root_of_tangential() const noexcept
    {
        return E == Elasticity::linear ? all(std::sqrt(tangential[0])) : root(tangential);
    }
};

//! As stiffness_at() in contact.hpp, in its order of operations.
template <Elasticity E>
[[gnu::always_inline]] inline FourStiffness<E> stiffness_at(ContactLaw const& law, Pack overlap,
                                                            [[maybe_unused]] Pack radius) noexcept
{
    if constexpr (E == Elasticity::linear) {
        return {all(law.normal.stiffness) * overlap, all(law.normal.damping), all(law.tangential.stiffness),
                all(law.tangential.damping)};
    } else {
        Pack const patch = root(radius * overlap), edge = root(patch);
        return {all(law.normal.stiffness) * patch * overlap, all(law.normal.damping) * edge,
                all(law.tangential.stiffness) * patch, all(law.tangential.damping) * edge};
    }
}

}  // namespace dem
