#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! Slices across the run-out direction, of equal width, from that of the first grain to that of the last.
struct Bins
{
    double width = 0.0;   //!< [m]
    bool radial = false;  //!< along the distance from the vertical axis through the origin; else along x

    template <int D>
    double position(Vec<D> const& centre) const
    {
        return radial && D == 3 ? std::hypot(centre.x, centre.y) : centre.x;
    }
    double slice(double position) const { return std::floor(position / width); }
};

//! Where the grains' matter is along the run-out direction.
struct Profile
{
    std::vector<double> position;  //!< middle of each slice [m]
    std::vector<double> mass;      //!< in it: each grain cut by the planes between slices [kg]; discs: kg/m
    std::vector<double> surface;   //!< highest point of the main mass in it [m]; 0: the main mass does not reach it
};
template <int D>
Profile profile_of(Grains<D> const& grains, Bins const& bins);

//! The middles of the slices from the one that holds `low` to the one that holds `high` [m].
std::vector<double> slice_positions(Bins const& bins, double low, double high);

}  // namespace dem
