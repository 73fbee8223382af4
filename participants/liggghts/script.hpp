#pragma once

#include <string>
#include <vector>

#include "participants/dem/config.hpp"
#include "participants/dem/state.hpp"
#include "participants/liggghts/classes.hpp"

//! The block that our DEM reads, as an input script of LIGGGHTS. No LIGGGHTS is needed for it.
namespace liggghts {

//! Dashpots are told by types: so many classes at most. 32 of the sizes of a column of 1 to 1.8 mm are within 1 % of
//! their dashpots.
inline constexpr std::size_t most_classes = 32;

//! What of a block LIGGGHTS cannot do, or not rightly.
struct Refusal
{
    std::string key;   //!< of the block
    std::string text;  //!< why, and what to try
};
std::vector<Refusal> refusals(dem::Config const& config);
//! LIGGGHTS' epsd3 has the stiffness S kn mu_r^2 R*^2, one number S for all; ours is rolling_ratio kt R*^2. That
//! number.
double rolling_stiffness(dem::ContactConfig const& contact);
//! Whether contacts, the grains' or a wall's, resist rolling by epsd3; else by epsd2, with kt R*^2 and no dashpot.
bool rolls_by_epsd3(dem::ContactConfig const& contact, dem::ContactConfig const& grains);
//! What it does in another way than our DEM, one sentence each. `classes` may be empty: the grains are not known yet.
std::vector<std::string> differences(dem::Config const& config, SizeClasses const& classes);

//! The input script; `grains` is the command that brings them, read_data or read_restart. Walls that are gone at time
//! `now` [s] are left out; the others are fixes of the names wall_name() says.
std::string script_of(dem::Config const& config, SizeClasses const& classes, std::string const& grains, double now);
std::string wall_name(std::size_t wall);

//! The data file: grains with ids from 1 on in their order, their class as type.
template <int D>
std::string data_of(dem::Config const& config, dem::Grains<D> const& grains, SizeClasses const& classes);

}  // namespace liggghts
