#pragma once

#include "participants/dem/config.hpp"
#include "participants/dem/solver.hpp"

namespace liggghts {

//! What our DEM sees in grains that LIGGGHTS moves, for the measures of a run. What only LIGGGHTS knows (what was
//! dissipated, springs along contacts) it does not see: those energies are not numbers.
template <int D>
class Observer
{
 public:
    explicit Observer(dem::Setup<D> setup);

    //! At a time [s]; `work`: of the partners' loads so far [J]. Valid until the next look. Throws sluice::Error
    //! (numerical) if a grain is behind a wall.
    dem::Solver<D> const& look(dem::Grains<D> const& grains, double time, double work);

 private:
    dem::Setup<D> setup_;
    std::optional<dem::Solver<D>> seen_;
};

}  // namespace liggghts
