#pragma once

#include <array>
#include <vector>

#include "participants/lbm/config.hpp"
#include "participants/lbm/populations.hpp"

namespace lbm {

//! One side in lattice units.
struct Boundary
{
    Border kind = Border::wall;
    //! Of a wall, along itself; of an inflow the largest one, whatever its direction (cells a step).
    std::array<double, 3> velocity{};
    //! Of an inflow, over `velocity`, along each of the other axes at every half cell from the domain's edge on; their
    //! product counts. Empty: 1.
    std::array<std::vector<double>, 3> profile{};
    double ramp = 0;            //!< steps within which an inflow grows from 0
    double share = 1;           //!< of its velocity that an inflow has now
    double density_excess = 0;  //!< rho - 1 at an opening where it is given [-]
    //! What enters the cells beside such an opening apart from what left, from when they last had all their
    //! populations; shape [cell][direction].
    std::vector<double> turned{};
};

//! How populations of one direction enter the first or last cell of a row that lies along no side.
struct RowEnd
{
    std::size_t into, from;            //!< directions
    std::ptrdiff_t x, from_x, dy, dz;  //!< that of the cell; where they are: x, and rows from it
    double push;                       //!< what a moving wall adds [-]
};

//! The sides in lattice units.
struct Walls
{
    std::array<std::array<Boundary, 2>, 3> side;  //!< the lower and the upper one along x, y, z
    std::array<double, 3> half_force{};           //!< of the body force, which a cell's velocity contains
    double even_rate = 1;                         //!< of the stress [1/step]
    std::vector<RowEnd> row_ends{};               //!< follow from the sides; empty if one across x is open

    std::array<bool, 3> periodic() const
    {
        std::array<bool, 3> all;
        for (std::size_t k = 0; k < 3; ++k) all[k] = side[k][0].kind == Border::periodic;
        return all;
    }
};

//! The ends of rows of a lattice.
template <int D>
std::vector<RowEnd> row_ends(Walls const& walls, Extent const& cells);

//! Rewrites the populations that enter a row from ghost cells, before the row collides, from the one that left into
//! that ghost cell. A wall or an inflow throws it back half-way and adds 6 w_q rho_0 c_q.u (Ladd, J. Fluid Mech. 271
//! (1994) 285), so that what flows in is rho_0 u; a given density throws it back with the other sign and adds twice the
//! even part of the equilibrium of that density and the cell's velocity, and (2 - s) times the even part that is not in
//! equilibrium, the stress (Ginzburg, Verhaeghe and d'Humieres, Commun. Comput. Phys. 3 (2008) 427); a periodic side
//! takes the one that left on the other side. Links through an edge belong to a wall at
//! rest, else to the side across the last axis (top and bottom before the others). Touches slots of that row alone, and
//! may be repeated until note_turned(). A wall without friction takes the one that left in the mirrored direction.
template <int D, class Stored>
void enter_from_outside(Rows<D, Stored> const& populations, std::ptrdiff_t row, Walls const& walls);

//! Notes what will enter a row's cells beside openings with a given density, once they have all their populations.
template <int D, class Stored>
void note_turned(Rows<D, Stored> const& populations, std::ptrdiff_t row, Walls& walls);

}  // namespace lbm
