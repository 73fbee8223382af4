#pragma once

#include "participants/mpm/state.hpp"

namespace mpm {

//! How far matter has come. The back wall is x = 0, the floor the plane through the origin; a point reaches half its
//! width beyond its place.
struct RunOut
{
    double front = 0;     //!< largest x in the main mass [m]
    double foremost = 0;  //!< largest x of any point [m]
    double height = 0;    //!< of the main mass within two cells of the back wall [m]
};

//! The main mass: the heaviest set of cells that hold points and touch by a side, an edge or a corner.
template <int D>
RunOut run_out_of(Setup<D> const& setup, State<D> const& state);

template <int D>
Vec<D> centre_of_mass(State<D> const& state);

}  // namespace mpm
