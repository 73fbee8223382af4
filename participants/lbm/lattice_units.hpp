#pragma once

namespace lbm {

//! The one place that converts between SI and lattice units (cell = step = reference density = 1, suffix _lu).
//! In the plane what is extensive is per metre of depth (N/m and so on).
struct LatticeUnits
{
    double cell;     //!< dx [m]
    double step;     //!< dt [s]
    double density;  //!< rho_0 [kg/m3]
    int dimension = 2;

    double velocity_unit() const noexcept { return cell / step; }                                  //!< [m/s]
    double acceleration_unit() const noexcept { return cell / (step * step); }                     //!< [m/s2]
    double viscosity_unit() const noexcept { return cell * cell / step; }                          //!< [m2/s]
    double pressure_unit() const noexcept { return density * velocity_unit() * velocity_unit(); }  //!< [Pa]
    double area_unit() const noexcept { return dimension == 2 ? cell : cell * cell; }              //!< [m2]
    double force_unit() const noexcept { return pressure_unit() * area_unit(); }                   //!< [N]
    double torque_unit() const noexcept { return force_unit() * cell; }                            //!< [N m]
    double momentum_unit() const noexcept { return force_unit() * step; }                          //!< [N s]
    double mass_unit() const noexcept { return density * area_unit() * cell; }                     //!< [kg]

    //! p - p_0 = c_s^2 (rho - rho_0) [Pa] from the density excess in lattice units.
    double pressure(double density_excess_lu) const noexcept { return density_excess_lu / 3.0 * pressure_unit(); }
    double density_excess_lu(double pressure_si) const noexcept { return 3.0 * pressure_si / pressure_unit(); }
    //! Relaxation time of the shear stress, in steps: tau = 1/2 + 3 nu_lu.
    double relaxation_time(double viscosity_si) const noexcept { return 0.5 + 3.0 * viscosity_si / viscosity_unit(); }
};

}  // namespace lbm
