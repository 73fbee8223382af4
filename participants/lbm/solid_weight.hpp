#pragma once

#include <cstddef>

namespace lbm {

//! Which weight B(eps, tau) a partly covered cell gives to the solid's collision (README: Decision, weight).
enum class SolidWeightLaw
{
    noble_torczynski,
    flat_wall
};

//! B of Noble and Torczynski (1998): eps (tau - 1/2)/((1 - eps) + (tau - 1/2)).
inline double noble_torczynski_weight(double fraction, double tau) noexcept
{
    double const t = tau - 0.5;
    return fraction * t / ((1.0 - fraction) + t);
}

//! B for which a flat wall along the lattice lies exactly at depth eps of its cell (derivation: README).
//! flux_rate = s_q. Bisection; for tables, not for kernels.
double flat_wall_weight(double fraction, double tau, double flux_rate) noexcept;

//! eps/B over eps, tabulated: smooth where B is not (tau near 1/2); linear, hence exact, for Noble and Torczynski.
class SolidWeight
{
 public:
    SolidWeight(SolidWeightLaw law, double tau, double flux_rate) noexcept;

    //! B/eps_total of n cells [-]: what a unit of area fraction gets. Beyond full cover bodies share the cell (B = 1).
    void per_fraction(double const* fraction, double* weight, std::ptrdiff_t n) const noexcept;

 private:
    static constexpr int intervals = 256;
    double table_[intervals + 2];
};

}  // namespace lbm
