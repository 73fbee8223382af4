#pragma once

#include "participants/dem/state.hpp"

//! Which of the facets near a grain are its contacts.
//!
//! A facet whose nearest point is within the radius overlaps. A contact there cuts a cap off the sphere, of the angle
//! acos(d/R) about its direction, where d is the distance: what the grain meets on or behind the plane through that
//! point is in the cap. The facets that overlap are gone through from the nearest on (of equal ones the lower first):
//! each whose direction is in the cap of a nearer one is part of that contact, or of the one that the nearer is part
//! of; the others bear. Hence
//!   on a flat or convex surface, however it is cut into facets, a grain has one contact, where the distance is least;
//!   in a groove it has one on each side, from the moment each begins with no overlap; sides that differ by less than
//!   the cap, acos(d/R), are one contact, whose normal goes over from the one to the other where they are as near.
//! The friction of a contact goes with it from facet to facet. No neighbourhood of facets is needed: meshes may have
//! corners that lie on other facets' edges, gaps below the overlap, facets that are there twice.
namespace dem {

//! Brings the feet of all meshes up to the places of the grains after a step of `dt` [s] (0: no step), and moves the
//! histories of contacts that have gone to another facet. Throws sluice::Error (numerical) if a grain's centre is
//! nearer to a facet than it has moved in the step: it could have gone through.
template <int D>
void find_feet(Setup<D> const& setup, State<D>& state, double dt);

}  // namespace dem
