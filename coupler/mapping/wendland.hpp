#pragma once

namespace sluice {

//! Compact, positive definite up to 3D, twice differentiable; r in radii, 0 beyond 1.
//! Source: Wendland, Adv. Comput. Math. 4 (1995), phi_{3,1}.
inline double wendland_c2(double r) noexcept
{
    if (r >= 1) return 0;
    double const s = (1 - r) * (1 - r);
    return s * s * (4 * r + 1);
}

}  // namespace sluice
