#pragma once

#include <array>
#include <vector>

#include "participants/lbm/still_cells.hpp"

namespace lbm {

//! Finds what the collision needs of rows in which solids rest that push cells alike at any velocity of the fluid.
template <class Stored>
class StillRowNumbers
{
 public:
    //! `has_solid`: of each slot up to the next row's cell x = 0, which is alike. Of `row` fractions, weights and open
    //! shares of these cells are read. Keeps references.
    StillRowNumbers(SolidRow<Stored> const& row, std::vector<char> has_solid, Relaxation const& relaxation,
                    bool les) noexcept
        : row_(row), has_solid_(std::move(has_solid)), relaxation_(relaxation), les_(les)
    {}
    std::vector<StillRun> runs() const;                      //!< as StillBlock::runs, their `at` left 0
    std::vector<Stored> numbers(StillRun const& run) const;  //!< as StillNumbers

 private:
    std::array<double, still_numbers> of_slot(std::ptrdiff_t x) const;

    SolidRow<Stored> row_;
    std::vector<char> has_solid_;
    Relaxation const& relaxation_;
    bool les_;
};

}  // namespace lbm
