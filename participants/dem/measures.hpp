#pragma once

#include <cstddef>

#include "participants/dem/solver.hpp"

namespace dem {

//! What is looked at while a column collapses. Lengths in the solver's axes; the back wall is x = 0, the floor the
//! plane through the origin.
template <int D>
struct Measures
{
    double front = 0.0;  //!< largest x + R in the main mass: the largest set of grains linked by gaps <= d_mean/10 [m]
    double foremost = 0.0;         //!< largest x + R of any grain [m]
    double height = 0.0;           //!< largest height + R of the main mass within 2 d_mean of the back wall [m]
    double kinetic = 0.0;          //!< linear and rotational [J]
    Vec<D> centre_of_mass;         //!< [m]
    std::size_t contacts = 0;      //!< touching pairs and touching walls
    double coordination = 0.0;     //!< mean contacts (pairs and walls) of grains with at least two [-]
    std::size_t rattlers = 0;      //!< grains with fewer than two contacts
    double largest_overlap = 0.0;  //!< xi / (Ri + Rj); wall: xi / 2R [-]
};
template <int D>
Measures<D> measure(Solver<D> const& solver);

//! Volume (area) of grains over that of a box [-]: the packing fraction, by clipping each grain.
template <int D>
double packing_fraction(Grains<D> const& grains, Vec<D> lower, Vec<D> upper);

//! Force of a wall on all its grains [N].
template <int D>
Vec<D> wall_reaction(Solver<D> const& solver, std::size_t wall)
{
    return solver.state().walls[wall].force;
}

}  // namespace dem
