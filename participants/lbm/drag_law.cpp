#include "participants/lbm/drag_law.hpp"

#include <algorithm>
#include <cmath>

namespace lbm {
namespace {

//! r = linear + quadratic |w|
struct Coefficients
{
    double linear, quadratic;
};

Coefficients bed_of(DragLaw const& law, double solid) noexcept
{
    double const n = std::max(1 - solid, least_porosity), cube = n * n * n;
    double const square = law.viscosity * solid * solid / (cube * law.diameter * law.diameter);
    if (law.kind == Drag::carman_kozeny) return {180 * square, 0};
    return {150 * square, 1.75 * solid / (cube * law.diameter)};
}

double di_felice(DragLaw const& law, double solid, double flux) noexcept
{
    double const n = std::max(1 - solid, least_porosity), reynolds = flux * law.diameter / law.viscosity;
    double const from = 1.5 - std::log10(std::max(reynolds, 1e-30));
    double const chi = 3.7 - 0.65 * std::exp(-0.5 * from * from);
    double const root = 0.63 * std::sqrt(flux) + 4.8 * std::sqrt(law.viscosity / law.diameter);
    return 0.75 * solid * root * root * std::pow(n, -1 - chi) / law.diameter;
}

}  // namespace

double DragLaw::resistance(double solid, double flux) const noexcept
{
    if (kind == Drag::di_felice) return di_felice(*this, solid, flux);
    auto const [linear, quadratic] = bed_of(*this, solid);
    return linear + quadratic * flux;
}

double DragLaw::resistance_after(double solid, double drive, double half) const noexcept
{
    if (kind != Drag::di_felice) {
        auto const [linear, quadratic] = bed_of(*this, solid);
        double const b = 1 + half * linear;
        double const flux = 2 * drive / (b + std::sqrt(b * b + 4 * half * quadratic * drive));
        return linear + quadratic * flux;
    }
    // r grows with the flux, at most in proportion: the mean of logarithms halves the error or does better
    double flux = drive / (1 + half * di_felice(*this, solid, drive));
    for (int k = 0; k < 40; ++k) {
        double const next = std::sqrt(flux * drive / (1 + half * di_felice(*this, solid, flux)));
        if (std::abs(next - flux) <= 1e-9 * flux) break;
        flux = next;
    }
    return di_felice(*this, solid, flux);
}

}  // namespace lbm
