// Solver: what sides that absorb sound have to know of solids.
#include "participants/lbm/solid_weight.hpp"
#include "participants/lbm/solver.hpp"

namespace lbm {

//! What solids do in a step to the fluid of a cell, whose momentum before they act may swing from step to step: B is
//! near 1 where they cover it.
template <int D>
Boundary::Held Solver<D>::held_in(std::ptrdiff_t r, std::ptrdiff_t x, std::size_t axis) const
{
    double fraction = 0, drag = 0, forced = 0, momentum = 0;
    for (std::uint32_t const k : coverage_.row(r)) {
        Strip<D> const& s = coverage_.strips()[k];
        std::ptrdiff_t const cell = x - s.begin;
        if (cell < 0 || cell >= s.count) continue;
        double const here = s.fraction(cell);
        if (is_forced(s))
            forced += here;
        else
            drag += here * s.drag;
        fraction += here;
        momentum += here * StripVelocity<D>(s, covering()).template at<double>(axis, static_cast<int>(cell));
    }
    double const weight = weight_beside_forced(forced, fraction - forced, drag, relaxation_.tau);
    return {weight * fraction, weight * momentum};
}

template <int D>
void Solver<D>::note_held()
{
    for (std::size_t axis = 0; axis < D; ++axis)
        for (bool const upper : {false, true}) {
            Boundary& side = walls_.side[axis][upper ? 1 : 0];
            if (side.held.empty()) continue;
            for (std::ptrdiff_t r = 0; r < layout_.rows(); ++r)
                each_beside<D>(layout_, r, axis, upper, [&](std::ptrdiff_t x, std::size_t place) {
                    Boundary::Held held = held_in(r, x, axis);
                    if (!upper) held.velocity = -held.velocity;
                    side.held[place] = held;
                });
        }
}

template void Solver<2>::note_held();
template void Solver<3>::note_held();

}  // namespace lbm
