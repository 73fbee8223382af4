#pragma once

#include "participants/dem/listed_contact.hpp"

//! The entries of a mesh that do not bear, or did not before: what becomes of their history, and what the ledger books
//! where a contact goes from one facet to the next. Its energy leaves with the one and comes with the other: over a
//! flat surface the two cancel to rounding, at a concave edge what is left is what the step's finite length makes.
namespace dem {

//! An entry that does not bear. Nothing is left of one that did not bear before, either. `radius`: of the grain [m].
template <Features F, int D>
void forget_foot(ContactLaw const& law, double radius, double dt, Motion<D> const& hi, Motion<D> const& hj,
                 WallContacts<D>& contacts, std::size_t at, Books& books) noexcept
{
    Foot<D> const& foot = contacts.foot[at];
    if (!foot.bore || !(dt > 0.0)) return;
    Contact<D> const c = contact_with_wall<D>(foot.last.normal, radius);
    double const overlap = radius - foot.last.distance + dt * c.closing(hi, hj);  // as if the facet went on
    forget<F>(law, c, overlap, dt, hi, hj, contacts.history, at, books);
}

//! A contact that is not new in this step, on a facet that did not bear before.
template <Features F, int D>
void book_arrival(ContactLaw const& law, Contact<D> const& c, double overlap, double dt, Motion<D> const& hi,
                  Motion<D> const& hj, Foot<D> const& foot, Books& books) noexcept
{
    if (foot.bore || !(dt > 0.0)) return;
    Books before;
    book_opening<F>(law, c, overlap, dt * c.closing(hi, hj), Tangent<D>{}, Tangent<D>{}, Memory<D>{}, before);
    books.touch -= before.touch;
}

}  // namespace dem
