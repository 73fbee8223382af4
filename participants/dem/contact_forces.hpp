#pragma once

#include <cstdint>
#include <vector>

#include "participants/dem/state.hpp"

namespace dem {

//! What acts in one contact, on the first grain; on the second the opposite.
template <int D>
struct ContactForce
{
    std::uint32_t first;   //!< grain
    std::uint32_t second;  //!< grain > first, or wall index + number of grains
    Vec<D> begin, end;     //!< centre of the first; of the second (its image), or the nearest point of the wall [m]
    double overlap;        //!< > 0 [m]
    double normal;         //!< pushes the first away from the second [N]
    Vec<D> tangential;     //!< friction [N]

    Vec<D> force() const { return (normal / norm(begin - end)) * (begin - end) + tangential; }
};

//! The forces of all contacts, pairs first, from places, velocities and springs as they are: those of the last step but
//! for the dashpots, which there see the velocities predicted for its end (a difference of the order of the step).
template <int D>
std::vector<ContactForce<D>> contact_forces(Setup<D> const& setup, State<D> const& state);

}  // namespace dem
