#pragma once

#include <array>
#include <optional>
#include <utility>

#include "participants/dem/state.hpp"

namespace dem {

//! Rows: the first index.
template <int D>
using Tensor = std::array<Vec<D>, D>;

//! A box, by its lower and upper corner [m].
template <int D>
using Box = std::pair<Vec<D>, Vec<D>>;

//! Averages over a volume V; stresses are positive in compression.
template <int D>
struct Averages
{
    Tensor<D> contact{};            //!< 1/V sum over contacts of f_a l_b, l the branch to the grain that f acts on [Pa]
    Tensor<D> kinetic{};            //!< 1/V sum m c_a c_b, c the velocity beyond that of the mean flow [Pa]
    Tensor<D> fabric{};             //!< mean of n_a n_b over contacts [-]; trace 1
    double packing_fraction = 0.0;  //!< [-]
    double contacts = 0.0;          //!< within V, in parts [-]
    double volume = 0.0;            //!< V [m3]; in the plane an area [m2]

    double stress(std::size_t a, int b) const { return component(contact[a], b) + component(kinetic[a], b); }
};

//! Over the whole periodic cell, or over a box: of a branch counts the part that lies in it, so that the stress is what
//! presses on the box's sides, whatever they cut; of a grain its volume in it; the grains whose centres are in it move
//! beyond their mean velocity, in a sheared cell beyond the shear.
//! Sources: Drescher and de Josselin de Jong, J. Mech. Phys. Solids 20 (1972) 337; parts of branches: Hardy, J. Chem.
//! Phys. 76 (1982) 622.
template <int D>
Averages<D> averages(Setup<D> const& setup, State<D> const& state, std::optional<Box<D>> const& box = std::nullopt);

//! Angle of friction that a stress mobilises in the plane of two axes: asin of deviator over mean [rad].
template <int D>
double friction_angle(Averages<D> const& a, int first, int second);

//! What presses across a sheared cell, positive in compression [Pa]: contacts by the virial of the forces that act on
//! the grains, and the grains' motion. Where they are shared out, this process's part of it.
template <int D>
double stress_across(Setup<D> const& setup, State<D> const& state) noexcept;

}  // namespace dem
