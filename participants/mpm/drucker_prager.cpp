#include "participants/mpm/drucker_prager.hpp"

#include <algorithm>
#include <cmath>

#include "participants/mpm/laws.hpp"

namespace mpm {
namespace {

constexpr double rounding = 1e-13;  //!< of the stresses at hand: how far beyond the surface still counts as on it

//! d(t)/d(-p) on a meridian of Mohr and Coulomb for an angle; `sign`: -1 compression, +1 extension.
double of_meridian(double sin, double sign)
{
    return 6 * sin / (std::sqrt(3.0) * (3 + sign * sin));
}

}  // namespace

//! In plane strain no plastic strain goes across: s across = -2/3 flow t. With D = sqrt(1 - flow^2/3) the largest shear
//! stress in the plane is D t, its mean stress p + flow t / 3, and its strains obey sin psi = flow / D. Equal to Mohr
//! and Coulomb's there if slope D / (1 - slope flow / 3) = sin phi, and limit D / (...) = c cos phi.
DruckerPragerSurface::DruckerPragerSurface(Elasticity const& e, DruckerPragerParameters const& p)
    : shear_(e.shear()), bulk_(e.bulk())
{
    double const sin_phi = std::sin(p.friction_angle), cos_phi = std::cos(p.friction_angle);
    double const sin_psi = std::sin(p.dilation_angle);
    if (p.cone == Cone::plane_strain) {
        flow_ = sin_psi / std::sqrt(1 + sin_psi * sin_psi / 3);
        double const D = std::sqrt(1 - flow_ * flow_ / 3);
        slope_ = sin_phi / (D + sin_phi * flow_ / 3);
        limit_ = p.cohesion * cos_phi * (1 - slope_ * flow_ / 3) / D;
    } else {
        double const sign = p.cone == Cone::compression ? -1 : 1;
        flow_ = of_meridian(sin_psi, sign);
        slope_ = of_meridian(sin_phi, sign);
        limit_ = 6 * p.cohesion * cos_phi / (std::sqrt(3.0) * (3 + sign * sin_phi));
    }
    tip_ = std::min(p.tension, slope_ > 0 ? limit_ / slope_ : HUGE_VAL);
}

double DruckerPragerSurface::excess(double mean, double shear) const
{
    return std::max(shear + slope_ * mean - limit_, mean - tip_);
}

DruckerPragerSurface::Returned DruckerPragerSurface::bring_back(double mean, double shear) const
{
    double const tolerance = rounding * (std::abs(mean) + shear + limit_) * (1 + bulk_ / shear_);
    if (excess(mean, shear) <= tolerance) return {mean, shear};
    double const beyond = std::max(0.0, shear + slope_ * mean - limit_), x = beyond / (shear_ + bulk_ * slope_ * flow_);
    double const p = mean - bulk_ * flow_ * x, t = shear - shear_ * x;
    if (t >= 0 && p <= tip_) return {p, t, 0, true};
    double const left = std::min(shear, std::max(0.0, limit_ - slope_ * tip_));  // of shear, at the cut-off
    double const dilated = flow_ * (shear - left) / shear_;
    return {tip_, left, std::max(0.0, (mean - tip_) / bulk_ - dilated), true};
}

namespace {

//! The deviator of a trial stress scaled to `shear`, with another mean stress; what plastic strain that takes.
Mat3 scaled(Mat3 const& trial, double trial_shear, double mean, double shear)
{
    Mat3 const deviator = trial - trial.trace() / 3 * Mat3::Identity();
    return (trial_shear > 0 ? shear / trial_shear : 0) * deviator + mean * Mat3::Identity();
}

double shear_of(Mat3 const& stress)
{
    Mat3 const deviator = stress - stress.trace() / 3 * Mat3::Identity();
    return std::sqrt(0.5) * deviator.norm();
}

//! The law of a cone: `bring_back(mean, shear)` of the trial stress says where it returns to.
template <class BringBack>
double yield(Matter& m, Increment const& step, Elasticity const& elasticity, BringBack&& bring_back)
{
    Mat3 flow = close_gap(m, step, elasticity);
    Mat3 const trial = step.turned(m.stress) + elasticity.stress(step.strain - flow);
    double const shear = shear_of(trial);
    DruckerPragerSurface::Returned const back = bring_back(trial.trace() / 3, shear);
    m.stress = trial;
    if (back.plastic) {
        m.stress = scaled(trial, shear, back.mean, back.shear);
        flow += elasticity.strain(trial - m.stress);
        m.gap += back.opened;
        m.plastic_strain += (shear - back.shear) / (std::sqrt(3.0) * elasticity.shear());
    }
    return contract(m.stress, flow);
}

}  // namespace

double DruckerPrager::respond(Matter& m, Increment const& step) const
{
    return yield(m, step, elasticity, [&](double mean, double shear) { return surface.bring_back(mean, shear); });
}

double MuOfI::shear_stress(double pressure, double trial, double dt) const
{
    double const least = static_friction * pressure, most = limit_friction * pressure;
    if (trial <= least) return trial;
    double const scale =
        dt * elasticity.shear() * inertial_number * std::sqrt(pressure / grain_density) / grain_diameter;
    double const sum = trial + most + scale, product = trial * most + scale * least;
    return 2 * product / (sum + std::sqrt(std::max(0.0, sum * sum - 4 * product)));
}

double MuOfI::respond(Matter& m, Increment const& step) const
{
    return yield(m, step, elasticity, [&](double mean, double trial) -> DruckerPragerSurface::Returned {
        double const pressure = std::max(0.0, -mean), shear = shear_stress(pressure, trial, step.duration);
        return {-pressure, shear, std::max(0.0, mean) / elasticity.bulk(), shear < trial || mean > 0};
    });
}

}  // namespace mpm
