#pragma once

#include "participants/mpm/state.hpp"

namespace mpm {

//! How far matter has come. The back wall is x = 0, the floor the plane through the origin; a point reaches half its
//! width beyond its place.
struct RunOut
{
    double front = 0;     //!< where the depth of the main mass falls below the one asked for [m]
    double foremost = 0;  //!< largest x of any point [m]
    double height = 0;    //!< of the main mass within two cells of the back wall [m]
};

//! The main mass: the heaviest set of cells that hold points and touch by a side, an edge or a corner. Its depth:
//! volume at the start above a place, of points as wide as they were, as a mean over two cells (in space, and across
//! the domain). A collapse ends in a tongue that grows thinner with the cells, and breaks: where it ends is no figure
//! of the continuum, where it falls below a certain depth is. A blunt front is seen up to a cell further out.
template <int D>
RunOut run_out_of(Setup<D> const& setup, State<D> const& state, double depth);

template <int D>
Vec<D> centre_of_mass(State<D> const& state);

}  // namespace mpm
