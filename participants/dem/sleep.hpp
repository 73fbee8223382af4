#pragma once

#include "participants/dem/state.hpp"

//! Grains at rest that are left alone (a scene's option). A grain may sleep once it and all that are near it (in the
//! list) have been slower than a speed for a time; it then stays where it is, and contacts between two that sleep are
//! not computed. Around those that sleep lies a layer that is as slow but awake: when that moves, or a wall there does,
//! its neighbours wake. Source of the idea: the islands of rigid-body engines; here grain by grain, since a pile is one
//! island.
namespace dem {

//! Steps between two looks at who may sleep.
inline constexpr int steps_between_looks = 20;

enum class Look
{
    no_change,
    some_slept,
    some_woke  //!< the forces have to be evaluated again
};

//! Looks at who falls asleep and who wakes.
template <int D>
Look look_for_sleepers(Setup<D> const& setup, State<D>& state);

//! All are awake.
template <int D>
void wake_all(State<D>& state);

//! Moves the contacts between two that sleep out of the list that is computed, with their histories; nothing to do if
//! nobody sleeps.
template <int D>
void put_aside(Setup<D> const& setup, State<D>& state);
//! The list as it was before.
template <int D>
void take_back(Setup<D> const& setup, State<D>& state);

}  // namespace dem
