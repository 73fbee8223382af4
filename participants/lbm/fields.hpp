#pragma once

#include <cstddef>
#include <vector>

namespace lbm {

//! Fields of the fluid for output, SI, shape [y][x] with x fastest, one value for each block of coarsen x coarsen cells
//! (averages; the last block of a row or column may be narrower). Velocity and vorticity in a covered cell are those of
//! fluid and solid together: (1 - B) u + B u_s.
struct Fields
{
    std::ptrdiff_t nx = 0, ny = 0;
    double spacing = 0;                  //!< from block to block [m]
    std::vector<double> velocity;        //!< [m/s], shape [y][x][2]
    std::vector<double> pressure;        //!< p - p_0 [Pa]; without hydrostatics unless gravity acts on the lattice
    std::vector<double> vorticity;       //!< dv/dx - du/dy [1/s]
    std::vector<double> solid_fraction;  //!< [-]
};

//! One row of cells in lattice units: density excess, velocity, solid fraction.
struct RowState
{
    std::vector<double> excess, ux, uy, fraction;
};

}  // namespace lbm
