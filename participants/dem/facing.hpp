#pragma once

#include "participants/dem/vec.hpp"

namespace dem {

//! What a wall is to the centre of a grain.
template <int D>
struct Facing
{
    double distance;  //!< from the centre to the wall [m]; not positive: the centre is behind it
    Vec<D> normal;    //!< unit vector from the wall to the grain
};

}  // namespace dem
