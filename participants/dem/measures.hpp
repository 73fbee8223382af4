#pragma once

#include <cstddef>
#include <vector>

#include "participants/dem/solver.hpp"

namespace dem {

template <int D>
double mean_diameter(Grains<D> const& grains);

//! For each grain whether it belongs to the main mass: the largest set of grains linked by gaps <= d_mean/10.
template <int D>
std::vector<bool> main_mass(Grains<D> const& grains);

//! How far a column has come. Lengths in the solver's axes; the back wall is x = 0, the floor the plane through the
//! origin.
struct RunOut
{
    double front = 0.0;     //!< largest x + R in the main mass [m]
    double foremost = 0.0;  //!< largest x + R of any grain [m]
    double height = 0.0;    //!< largest height + R of the main mass within 2 d_mean of the back wall [m]
};
template <int D>
RunOut run_out_of(Grains<D> const& grains);

template <int D>
Vec<D> centre_of_mass(Grains<D> const& grains);

//! Whose touch counts as a contact.
enum class Partners : unsigned char
{
    grains,
    grains_and_walls
};

//! How many partners each grain touches.
template <int D>
std::vector<std::size_t> contacts_of_grains(Setup<D> const& setup, State<D> const& state, Partners partners);

//! Grains by the number of their contacts. A rattler has fewer than two.
struct Coordination
{
    std::vector<double> grains;  //!< with 0, 1, 2, ... contacts; the last: with as many or more
    double mean = 0.0;           //!< contacts of all grains [-]
    double bearing = 0.0;        //!< of those that are no rattlers [-]
    std::size_t rattlers = 0;
};
Coordination coordination_of(std::vector<std::size_t> const& contacts, std::size_t most);

struct ContactNumbers
{
    std::size_t contacts = 0;      //!< touching pairs and touching walls
    double largest_overlap = 0.0;  //!< xi / (Ri + Rj); wall: xi / 2R [-]
};
template <int D>
ContactNumbers contact_numbers(Setup<D> const& setup, State<D> const& state);

//! All of these: the state of a column in a few numbers.
template <int D>
struct Measures : RunOut, ContactNumbers
{
    double kinetic = 0.0;       //!< linear and rotational [J]
    Vec<D> centre_of_mass;      //!< [m]
    double coordination = 0.0;  //!< mean contacts (pairs and walls) of grains with at least two [-]
    std::size_t rattlers = 0;   //!< grains with fewer than two contacts
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
