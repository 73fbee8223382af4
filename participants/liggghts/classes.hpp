#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace liggghts {

//! Grains of about one mass: LIGGGHTS' dashpots are numbers of pairs of types, ours go with the masses of each pair.
struct SizeClass
{
    double mass = 0.0;    //!< that stands for all [kg]
    double radius = 0.0;  //!< [m]
};

struct SizeClasses
{
    std::vector<SizeClass> classes;  //!< by mass
    std::vector<std::size_t> of;     //!< the class of each grain
    double spread = 0.0;             //!< largest |sqrt(m / m of its class) - 1|: so far are dashpots off at most
};

//! One class for each mass where there are at most `most`, else `most` classes of one ratio.
SizeClasses classes_of(std::span<double const> mass, std::span<double const> radius, std::size_t most);

}  // namespace liggghts
