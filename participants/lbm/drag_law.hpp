#pragma once

#include "participants/lbm/config.hpp"

namespace lbm {

//! How a bed of grains of one size resists a flux w through it (volume a time and area, relative to the grains): by a
//! force r w on a cell of fluid, in lattice units, of solid volume fraction phi, porosity n = 1 - phi:
//!     Ergun             r = 150 nu phi^2/(n^3 d^2) + 1.75 phi |w|/(n^3 d)                        dense beds
//!     Carman-Kozeny     r = 180 nu phi^2/(n^3 d^2)                                               dense beds, slow flow
//!     Di Felice         r = 3/4 C_d phi |w| n^(-1-chi)/d,  Re = |w| d/nu,                        any porosity
//!                       C_d = (0.63 + 4.8/sqrt(Re))^2,  chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2/2)
//! Sources: Ergun, Chem. Eng. Prog. 48 (1952) 89; Carman, Trans. Inst. Chem. Eng. 15 (1937) 150; Di Felice, Int. J.
//! Multiphase Flow 20 (1994) 153. The fluid's stress is shared out by volume: a bed feels r w, of which n r w is drag
//! and phi r w its part of the gradient of pressure that drives the flow.
struct DragLaw
{
    Drag kind;
    double diameter;   //!< d [cells]
    double viscosity;  //!< nu [cells^2 a step]

    double resistance(double solid, double flux) const noexcept;  //!< r [1/step]
    //! r for the flux that satisfies flux (1 + half r) = drive: the one that is left of `drive` once drag has acted.
    double resistance_after(double solid, double drive, double half) const noexcept;
};

//! Fuller cells count as ones of this porosity: the laws have no bound there.
inline constexpr double least_porosity = 0.05;

}  // namespace lbm
