#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "participants/lbm/still_cells.hpp"

namespace lbm {

//! What the collision needs of the cells of one row, in the order of StillNumber; solids push them alike at any
//! velocity of the fluid.
template <class Stored>
class StillRowNumbers
{
 public:
    using OfCell = std::array<double, still_numbers>;

    //! Of cells without solids: those of the fluid, so that it collides there as elsewhere.
    static OfCell of_fluid(Relaxation const& relaxation, bool les) noexcept;

    StillRowNumbers() = default;  //!< no cells
    //! `has_solid`: of each cell. Of `row` fractions, weights and open shares of these cells are read.
    StillRowNumbers(SolidRow<Stored> const& row, std::vector<char> has_solid, Relaxation const& relaxation, bool les);

    std::vector<StillRun> runs() const;  //!< cells with solids, a register or more apart; their `at` left 0
    std::ptrdiff_t cells() const noexcept { return static_cast<std::ptrdiff_t>(of_cell_.size()); }
    OfCell const& operator[](std::ptrdiff_t x) const noexcept { return of_cell_[static_cast<std::size_t>(x)]; }

 private:
    std::vector<char> has_solid_{};
    std::vector<OfCell> of_cell_{};
};

//! How many rows after a row its runs, and registers that begin in these, may reach.
template <class Stored>
constexpr std::ptrdiff_t rows_in_reach(std::ptrdiff_t stride) noexcept
{
    return 2 + StillNumbers<Stored>::lanes / stride;
}

//! The runs of a row, as StillBlock::runs, with their numbers, as StillNumbers. `line`: it, and those after it in line,
//! as many as there are of rows_in_reach(); `stride` slots from one to the next. add(numbers): where they are.
template <class Stored, class Add>
std::vector<StillRun> runs_in_line(std::deque<StillRowNumbers<Stored>> const& line, std::ptrdiff_t stride,
                                   typename StillRowNumbers<Stored>::OfCell const& of_fluid, Add&& add)
{
    constexpr auto lanes = StillNumbers<Stored>::lanes;
    auto runs = line[0].runs();
    if (line.size() > 1 && !runs.empty()) {
        auto const next = line[1].runs();
        if (!next.empty() && stride + next[0].begin - runs.back().end < lanes) runs.back().end = stride + next[0].end;
    }
    auto const of_slot = [&](std::ptrdiff_t x) {
        auto const k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(x, 0) / stride);
        return x < 0 || k >= line.size() || x % stride >= line[k].cells() ? of_fluid : line[k][x % stride];
    };
    for (StillRun& run : runs) {
        std::ptrdiff_t const length = StillNumbers<Stored>::length(run);
        std::vector<Stored> numbers(static_cast<std::size_t>(still_numbers * length));
        for (std::ptrdiff_t k = 0; k < length; ++k) {
            auto const slot = of_slot(run.begin - lanes + k);
            for (std::size_t number = 0; number < slot.size(); ++number)
                numbers[number * static_cast<std::size_t>(length) + static_cast<std::size_t>(k)] =
                    static_cast<Stored>(slot[number]);
        }
        run.at = add(numbers);
    }
    return runs;
}

}  // namespace lbm
