#include "participants/lbm/solid_weight.hpp"

#include <algorithm>

namespace lbm {
namespace {

//! (1 - eps)(1 + (1/a - 1) P) - T P: positive while the wall lies deeper than eps.
double wall_balance(double weight, double fraction, double tau, double flux_rate) noexcept
{
    double const a = (1 - weight) / tau, b = (1 - weight) * flux_rate;
    double const p = 2 - 2 * weight - 4 * b * weight / (b + 6 * weight);
    return (1 - fraction) * (1 + (1 / a - 1) * p) - (tau - 0.5) * p;
}

}  // namespace

double flat_wall_weight(double fraction, double tau, double flux_rate) noexcept
{
    if (fraction >= 1) return 1;
    double low = 0, high = 1 - 1e-12;
    for (int i = 0; i < 60; ++i) {
        double const middle = 0.5 * (low + high);
        (wall_balance(middle, fraction, tau, flux_rate) > 0 ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

SolidWeight::SolidWeight(SolidWeightLaw law, double tau, double flux_rate) noexcept
{
    auto const weight = [&](double fraction) {
        return law == SolidWeightLaw::flat_wall ? flat_wall_weight(fraction, tau, flux_rate)
                                                : noble_torczynski_weight(fraction, tau);
    };
    for (int k = 1; k < intervals; ++k) {
        double const fraction = static_cast<double>(k) / intervals;
        table_[k] = fraction / weight(fraction);
    }
    table_[0] = 2 * table_[1] - table_[2];
    table_[intervals] = table_[intervals + 1] = 1;
}

void SolidWeight::per_fraction(double const* fraction, double* weight, std::ptrdiff_t n) const noexcept
{
#pragma omp simd
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        double const at = std::min(fraction[i], 1.0) * intervals;
        auto const k = static_cast<int>(at);
        double const inverse = table_[k] + (table_[k + 1] - table_[k]) * (at - k);
        weight[i] = 1.0 / std::max(inverse, fraction[i]);  // inverse >= 1
    }
}

}  // namespace lbm
