#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "participants/lbm/output_config.hpp"

namespace lbm {

//! Fields of the fluid for output, SI, shape [z][y][x] with x fastest, one value for each block of coarsen cells each
//! way (averages; the last block of a row or column may be narrower); one along z in the plane. Velocity and vorticity
//! in a covered cell are those of fluid and solid together: (1 - B) u + B u_s.
struct Fields
{
    std::ptrdiff_t nx = 0, ny = 0, nz = 0;
    double spacing = 0;                  //!< from block to block [m]
    std::vector<double> velocity;        //!< [m/s], D for each block
    std::vector<double> pressure;        //!< p - p_0 [Pa]; without hydrostatics unless gravity acts on the lattice
    std::vector<double> vorticity;       //!< curl of the velocity [1/s], one (plane) or three for each block
    std::vector<double> solid_fraction;  //!< [-]
    std::vector<double> q_criterion;     //!< -1/2 d u_a/d x_b d u_b/d x_a [1/s2]: above 0 where turning outdoes shear
};

//! What the fluid does at a place, SI.
template <int D>
struct Sample
{
    std::array<double, D> velocity{};
    double pressure = 0;
    double solid_fraction = 1;
};

//! Of the fluid, without what solids cover of each cell; in the plane per metre.
struct Energies
{
    double kinetic;    //!< [J]
    double enstrophy;  //!< integral of |curl u|^2/2 [m3/s2]
};

//! One row of cells in lattice units: density excess, velocity, solid fraction.
template <int D>
struct RowState
{
    std::vector<double> excess, fraction;
    std::array<std::vector<double>, D> velocity;
};

}  // namespace lbm
